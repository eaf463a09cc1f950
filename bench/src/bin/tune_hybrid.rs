//! Searches the constants of method `hybrid` on the built-in scenes, one after the other.
//!
//! `cargo run --release -p conray-bench --bin tune_hybrid -- [SCENE...] [--size 192] [--rays 8,16,64,256] [--seeds 4]`
//!
//! Each constant is tried smaller and larger, the others as they are. Judged is the logarithm of the RMSE, over scenes and rays, for the
//! same rays and seeds: so the differences are those of the constants, and their standard error is that of the pairs. A step is
//! taken where it gains more than two standard errors and more than a thousandth, and is tried again until none is.
//! Time is not judged: these constants cost none.

use clap::Parser;
use conray::{AoSettings, Control, Error, HybridConstants, Method, target::Target};
use conray_bench::{Bench, judged};
use std::time::Instant;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "cornell-blocks", "atrium", "grove"])]
    scenes: Vec<String>,
    /// Pixels on each side
    #[arg(long, default_value_t = 192)]
    size: u32,
    /// Rays a point
    #[arg(long, value_delimiter = ',', default_values = ["8", "16", "64", "256"])]
    rays: Vec<u32>,
    /// Runs of each
    #[arg(long, default_value_t = 4)]
    seeds: u32,
    /// Rays a point for the truth
    #[arg(long, default_value_t = 4096)]
    truth: u32,
    /// Times that all constants are gone through at most
    #[arg(long, default_value_t = 3)]
    rounds: u32,
    /// Print what each step would gain and take none
    #[arg(long)]
    look: bool,
}

/// A constant by name, and its place.
type Constant = (&'static str, fn(&mut HybridConstants) -> &mut f32);

const CONSTANTS: [Constant; 12] = [
    ("distance", |c| &mut c.distance),
    ("cells", |c| &mut c.cells),
    ("plane", |c| &mut c.plane),
    ("cosine", |c| &mut c.cosine),
    ("slope", |c| &mut c.slope),
    ("bend", |c| &mut c.bend),
    ("prior_samples", |c| &mut c.prior_samples),
    ("beyond_chance", |c| &mut c.beyond_chance),
    ("least_noise", |c| &mut c.least_noise),
    ("doubt_units", |c| &mut c.doubt_units),
    ("first_rays", |c| &mut c.first_rays),
    ("least_share", |c| &mut c.least_share),
];

/// Smaller and larger: a step that shows and does not leap.
const STEPS: [f32; 2] = [1.0 / 1.4, 1.4];
/// Gains below this are not worth another figure in the code.
const WORTHWHILE: f64 = 1e-3;

/// The outcome of one run: logarithms of the true RMSE and of the expected one over it.
#[derive(Clone, Copy)]
struct Run {
    error: f64,
    belief: f64,
}

fn main() -> Result<(), Error> {
    let args = Args::parse();
    let benches: Result<Vec<Bench>, Error> = args
        .scenes
        .iter()
        .map(|name| Bench::new(judged(name)?, &AoSettings::default(), (args.size, args.size), args.truth))
        .collect();
    let mut benches = benches?;
    let mut best = HybridConstants::default();
    let start = Instant::now();
    let mut runs = runs(&mut benches, &args, &best)?;
    println!("as they are: {}; {:.1} s a trial", told(&runs), start.elapsed().as_secs_f64());
    for _ in 0..args.rounds {
        let mut moved = false;
        for (name, place) in CONSTANTS {
            for step in STEPS {
                let mut trial = best;
                *place(&mut trial) *= step;
                let found = self::runs(&mut benches, &args, &trial)?;
                let (gain, standard_error) = gain(&runs, &found);
                let better = gain > 2.0 * standard_error && gain > WORTHWHILE;
                let value = *place(&mut trial);
                let taken = if better && !args.look { ", taken" } else { "" };
                println!(
                    "{name:14} {value:<9.4} gains {:6.2} % +- {:.2}, {}{taken}",
                    100.0 * gain,
                    100.0 * standard_error,
                    told(&found)
                );
                if better && !args.look {
                    (best, runs, moved) = (trial, found, true);
                    break;
                }
            }
        }
        if !moved {
            break;
        }
        println!("{best:?}");
    }
    Ok(())
}

/// A run for each scene, budget and seed.
fn runs(benches: &mut [Bench], args: &Args, constants: &HybridConstants) -> Result<Vec<Run>, Error> {
    let mut runs = Vec::new();
    for bench in benches {
        for &rays in &args.rays {
            for seed in 0..args.seeds {
                let settings =
                    AoSettings { method: Method::Hybrid, rays: Some(rays), seed, ..AoSettings::default() };
                bench.session.set_plan(&settings)?;
                let hybrid = bench.session.hybrid(bench.session.plan(), &bench.target);
                let mut hybrid =
                    hybrid.expect("the method is hybrid, of an image").with_constants(*constants);
                let points = bench.target.points();
                let outcome = bench.session.run_hybrid(
                    &mut hybrid,
                    bench.session.plan().budget,
                    points,
                    Instant::now(),
                    Control::none(),
                );
                let squares = outcome.estimates.iter().zip(&bench.truth);
                let squares = squares.map(|(e, truth)| f64::from(e.visibility - truth).powi(2)).sum::<f64>();
                let rmse = (squares / bench.truth.len().max(1) as f64).sqrt();
                runs.push(Run { error: rmse.ln(), belief: (outcome.work.expected_rmse / rmse).ln() });
            }
        }
    }
    Ok(runs)
}

/// Mean gain of the second over the first, and its standard error over the pairs of runs.
fn gain(before: &[Run], after: &[Run]) -> (f64, f64) {
    let gains: Vec<f64> =
        before.iter().zip(after).map(|(before, after)| before.error - after.error).collect();
    let count = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    (mean, (variance / count).sqrt())
}

/// Geometric mean of errors, and of expected over true ones with how far they scatter about it, as factors.
fn told(runs: &[Run]) -> String {
    let count = runs.len() as f64;
    let error = runs.iter().map(|run| run.error).sum::<f64>() / count;
    let belief = runs.iter().map(|run| run.belief).sum::<f64>() / count;
    let scatter = runs.iter().map(|run| run.belief.powi(2)).sum::<f64>() / count;
    format!(
        "RMSE {:.5}, expected over true {:.2}, off by {:.2}",
        error.exp(),
        belief.exp(),
        scatter.sqrt().exp()
    )
}
