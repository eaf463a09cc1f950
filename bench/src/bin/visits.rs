//! What bundles of 64 rays do in a scene, in counts that repeat exactly: the ground of `docs/profiles/rays.md`.
//!
//! `cargo run --release -p conray-bench --features visits --bin visits -- [SCENE...] [--rays 64] [--side 160]`
//!
//! One thread, so that `valgrind --tool=callgrind --toggle-collect='*transmittances*'` counts instructions of the same work.

use clap::Parser;
use conray::AoSettings;
use conray_bench::{
    hemispheres::{Hemispheres, Order},
    judged,
};
use conray_bvh::{BUNDLE_RAYS, take_visits};

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Rays per point
    #[arg(long, default_value_t = 64)]
    rays: usize,
    /// Side of the image whose points are taken
    #[arg(long, default_value_t = 160)]
    side: u32,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    for name in &args.scenes {
        let scene = Hemispheres::new(judged(name)?, &AoSettings::default(), args.side)?;
        let mut drawn = conray_bench::hemispheres::Directions::default();
        drawn.draw(&scene.points, args.rays);
        let directions = drawn.ordered(Order::Morton).directions;
        take_visits();
        let (mut bundle, mut open) = (conray_bvh::Directions::new(), 0.0);
        for (point, directions) in scene.points.iter().zip(directions.chunks(args.rays)) {
            for some in directions.chunks(BUNDLE_RAYS) {
                bundle.clear();
                bundle.extend(some.iter().copied());
                let mut passing = [0.0; BUNDLE_RAYS];
                let passing = &mut passing[..some.len()];
                let (origin, normal) = (point.ray_origin(), point.geometric_normal);
                scene.session.bvh().transmittances(origin, normal, &bundle, scene.distance, passing);
                open += passing.iter().map(|&t| f64::from(t)).sum::<f64>();
            }
        }
        let counts = take_visits();
        let rays = (scene.points.len() * args.rays) as f64;
        println!(
            "{}: {} rays, {:.4} open; for each bundle, and for each ray:",
            scene.name,
            rays,
            open / rays
        );
        for (visit, count) in counts {
            let count = count as f64;
            println!("  {visit:?}: {:.2}, {:.3}", count / counts[0].1 as f64, count / rays);
        }
    }
    Ok(())
}
