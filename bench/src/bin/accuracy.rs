//! RMSE of each method against many rays.
//!
//! `cargo run --release -p conray-bench --bin accuracy -- cornell atrium PATH...`

use clap::Parser;
use conray::{AoSettings, Error, Method};
use conray_bench::{Bench, judged};

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Side of the square image in pixels
    #[arg(long, default_value_t = 512)]
    size: u32,
    /// Rays a point for the truth
    #[arg(long, default_value_t = 4096)]
    truth: u32,
    /// Octree leaves along the longest side
    #[arg(long, default_value_t = 512)]
    voxels: u32,
}

fn main() -> Result<(), Error> {
    let args = Args::parse();
    let base = AoSettings { voxels: args.voxels, ..AoSettings::default() };
    println!("{0} x {0} pixels, truth by {1} rays, {2} voxels", args.size, args.truth, args.voxels);
    println!(
        "{:20} {:22} {:>8} {:>8} {:>8} {:>8} {:>7}",
        "scene", "method", "RMSE", "bias", "p95", "rays/px", "s"
    );
    for name in &args.scenes {
        let mut bench = Bench::new(judged(name)?, &base, (args.size, args.size), args.truth)?;
        let mut row = |label: &str, settings: &AoSettings| -> Result<(), Error> {
            let (outcome, m) = bench.run(settings)?;
            let rays = outcome.work.rays as f64 / outcome.estimates.len() as f64;
            println!(
                "{:20} {label:22} {:8.4} {:+8.4} {:8.4} {rays:8.1} {:7.2}",
                bench.name, m.rmse, m.bias, m.p95, outcome.work.seconds
            );
            Ok(())
        };
        for cones in [6, 9, 16, 25] {
            row(&format!("cones, {cones}"), &AoSettings { method: Method::Cones, cones, ..base.clone() })?;
        }
        row("paper", &AoSettings { method: Method::Paper, ..base.clone() })?;
        for rays in [1, 4, 16, 64] {
            row(
                &format!("rays, {rays}"),
                &AoSettings { method: Method::Rays, rays: Some(rays), ..base.clone() },
            )?;
        }
    }
    Ok(())
}
