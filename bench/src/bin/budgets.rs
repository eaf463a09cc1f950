//! Whether budgets are kept: errors reached against errors asked for, and time taken against time allowed.
//!
//! `cargo run --release -p conray-bench --bin budgets -- [SCENE...] [--size 256] [--seeds 5] [--truth 4096]`

use clap::Parser;
use conray::{AoSettings, Control, Error, Method, Outcome};
use conray_bench::{Bench, judged};
use std::error::Error as StdError;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "cornell-blocks", "atrium", "grove"])]
    scenes: Vec<String>,
    /// Pixels on each side
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Runs of each
    #[arg(long, default_value_t = 5)]
    seeds: u32,
    /// Methods: hybrid, rays
    #[arg(long, value_delimiter = ',', default_values = ["hybrid"])]
    methods: Vec<Method>,
    /// Seconds
    #[arg(long, value_delimiter = ',', default_values = ["0.02", "0.1", "0.3", "1", "3"])]
    times: Vec<f64>,
    /// Rays a point for the truth
    #[arg(long, default_value_t = 4096)]
    truth: u32,
}

/// Runs within 1.1 times the error asked for, of all.
#[derive(Default)]
struct Kept {
    within: u32,
    all: u32,
}

fn main() -> Result<(), Box<dyn StdError>> {
    let args = Args::parse();
    let mut kept = Kept::default();
    for name in &args.scenes {
        let mut bench =
            Bench::new(judged(name)?, &AoSettings::default(), (args.size, args.size), args.truth)?;
        for &method in &args.methods {
            for error in [0.05, 0.02, 0.01, 0.005] {
                for seed in 0..args.seeds {
                    let settings = AoSettings { method, error: Some(error), seed, ..AoSettings::default() };
                    let (outcome, rmse) = run(&mut bench, &settings)?;
                    let ratio = rmse / f64::from(error);
                    if method == Method::Hybrid {
                        kept.all += 1;
                        kept.within += u32::from(ratio <= 1.1);
                    }
                    println!(
                        "{name:15} {method:6} error {error:.3}: true {rmse:.5} expected {:.5}, {ratio:.2} of the goal, {:6.1} rays, {} rounds, {:.3} s",
                        outcome.work.expected_rmse,
                        outcome.work.rays as f64 / outcome.estimates.len() as f64,
                        outcome.work.explanation.map_or(0, |e| e.rounds.len()),
                        outcome.work.seconds
                    );
                }
            }
            for &seconds in &args.times {
                let mut taken = Vec::new();
                for seed in 0..args.seeds {
                    let settings = AoSettings { method, time: Some(seconds), seed, ..AoSettings::default() };
                    let (outcome, rmse) = run(&mut bench, &settings)?;
                    taken.push(format!("{:.3} ({rmse:.4})", outcome.work.seconds));
                }
                println!("{name:15} {method:6} time {seconds} s: {}", taken.join(" "));
            }
        }
    }
    println!("hybrid: {} of {} runs within 1.1 times the error", kept.within, kept.all);
    Ok(())
}

/// One run over the image, as a user gets it, and its true RMSE.
fn run(bench: &mut Bench, settings: &AoSettings) -> Result<(Outcome, f64), Error> {
    bench.session.set_plan(settings)?;
    let outcome = bench.session.run_target(&bench.target, Control::none())?;
    let squares =
        outcome.estimates.iter().zip(&bench.truth).map(|(e, t)| f64::from(e.visibility - t).powi(2));
    let rmse = (squares.sum::<f64>() / bench.truth.len().max(1) as f64).sqrt();
    Ok((outcome, rmse))
}
