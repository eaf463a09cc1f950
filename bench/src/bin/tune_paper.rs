//! Searches beta, gamma and N_max of the paper's blend on a scene.
//!
//! `cargo run --release -p conray-bench --bin tune_paper`
//!
//! The figure of merit is RMSE against the rays it costs: squared error times the time of the run, where time is
//! counted in rays (a cone is taken as `--cone-cost` rays), so that it does not depend on the machine's noise.

use clap::Parser;
use conray::{AoSettings, Error, Method};
use conray_bench::{Bench, judged};

#[derive(Parser)]
struct Args {
    /// A built-in scene or a file
    #[arg(default_value = "cornell")]
    scene: String,
    /// Side of the square image in pixels
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Rays a point for the truth
    #[arg(long, default_value_t = 4096)]
    truth: u32,
    /// What a cone costs, in rays
    #[arg(long, default_value_t = 2.0)]
    cone_cost: f64,
}

fn main() -> Result<(), Error> {
    let args = Args::parse();
    let base = AoSettings { method: Method::Paper, ..AoSettings::default() };
    let mut bench = Bench::new(judged(&args.scene)?, &base, (args.size, args.size), args.truth)?;
    println!("{:>6} {:>6} {:>6} {:>8} {:>8} {:>10}", "N_max", "gamma", "beta", "RMSE", "rays/px", "merit");
    let mut rows = Vec::new();
    for max_rays in [2, 4, 8, 16, 32] {
        for gamma in [0.0, 0.01, 0.02, 0.04, 0.08] {
            for beta in [5.0, 10.0, 20.0, 40.0, 100.0, 200.0, 400.0] {
                let (outcome, m) = bench.run(&AoSettings { max_rays, gamma, beta, ..base.clone() })?;
                let points = outcome.estimates.len() as f64;
                let (rays, cones) = (outcome.work.rays as f64 / points, outcome.work.cones as f64 / points);
                let merit = m.rmse * m.rmse * (rays + args.cone_cost * cones);
                rows.push((merit, max_rays, gamma, beta, m.rmse, rays));
            }
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (merit, max_rays, gamma, beta, rmse, rays) in rows {
        println!("{max_rays:6} {gamma:6} {beta:6} {rmse:8.4} {rays:8.1} {merit:10.6}");
    }
    Ok(())
}
