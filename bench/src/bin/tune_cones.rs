//! Searches the constants of the cone march on the built-in scenes.
//!
//! `cargo run --release -p conray-bench --bin tune_cones`
//!
//! For each choice of node width, step and lift: RMSE of the cones' visibility against many rays, a scene at a time, and
//! look-ups are cheaper the wider the nodes and the longer the steps.

use clap::Parser;
use conray::{AoSettings, Error, Falloff, Method, target::Target};
use conray_bench::{Bench, judged};
use conray_voxel::{ConePoint, ConeResult, MarchOptions};
use std::time::Instant;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "cornell-blocks", "atrium"])]
    scenes: Vec<String>,
    /// Side of the square image in pixels
    #[arg(long, default_value_t = 64)]
    size: u32,
    /// Rays a point for the truth
    #[arg(long, default_value_t = 1024)]
    truth: u32,
}

fn main() -> Result<(), Error> {
    let args = Args::parse();
    let base = AoSettings { method: Method::Cones, ..AoSettings::default() };
    let mut benches = Vec::new();
    for name in &args.scenes {
        let mut bench = Bench::new(judged(name)?, &base, (args.size, args.size), args.truth)?;
        bench.session.set_plan(&base)?;
        benches.push(bench);
    }
    let names: Vec<String> = benches.iter().map(|b| format!("{:>15}", b.name)).collect();
    println!("{:>6} {:>5} {:>5} {} {:>8} {:>7}", "width", "step", "lift", names.join(" "), "mean", "s");
    let mut rows = Vec::new();
    for width in [0.1, 0.15, 0.2, 0.25, 0.3, 0.5, 1.0] {
        for step in [0.75, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5] {
            for lift in [1.0, 1.5, 1.75, 2.0, 2.5] {
                let options = MarchOptions { width, step, lift, ..MarchOptions::default() };
                let start = Instant::now();
                let errors: Vec<f64> = benches.iter().map(|b| cone_rmse(b, &options)).collect();
                let mean = errors.iter().sum::<f64>() / errors.len() as f64;
                rows.push((mean, width, step, lift, errors, start.elapsed().as_secs_f64()));
            }
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (mean, width, step, lift, errors, seconds) in rows {
        let errors: Vec<String> = errors.iter().map(|e| format!("{e:15.4}")).collect();
        println!("{width:6} {step:5} {lift:5} {} {mean:8.4} {seconds:7.2}", errors.join(" "));
    }
    Ok(())
}

/// RMSE over the image of the weighted sum of the cones, about the geometric normal where the two agree.
fn cone_rmse(bench: &Bench, options: &MarchOptions) -> f64 {
    let (plan, octree) = (bench.session.plan(), bench.session.octree().expect("cones were planned"));
    let cones = plan.cones.cones();
    let march = octree.cone_march(&plan.cones, plan.distance, Falloff::None, options);
    let mut results = vec![ConeResult { visibility: 0.0, error: 0.0 }; cones.len()];
    let (mut sum, mut count) = (0.0, 0u32);
    for (point, truth) in bench.target.points().iter().zip(&bench.truth) {
        if point.shading_normal.dot(point.geometric_normal) < 0.99 {
            continue;
        }
        let at = ConePoint::about(point.shading_normal, point.position, point.geometric_normal);
        march.march(&[at], &mut results);
        let visibility: f32 = cones.iter().zip(&results).map(|(c, r)| c.weight * r.visibility).sum();
        sum += f64::from(visibility - truth).powi(2);
        count += 1;
    }
    (sum / f64::from(count)).sqrt()
}
