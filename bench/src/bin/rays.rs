//! Rays a second: our kernels against Embree, on the same triangles and the same rays.
//!
//! `cargo run --release -p conray-bench --bin rays -- cornell atrium PATH... [--rays 64] [--json FILE]`
//!
//! `bench/fetch-rivals` fetches Embree; without it the program fails, as a comparison with nothing is none.

use clap::Parser;
use conray::{AoSettings, Distance, SurfacePoint, Vec3};
use conray_bench::{
    embree::{Embree, Ray1, Ray16},
    hemispheres::{CHUNK, Hemispheres, directions},
    judged,
};
use conray_bvh::BUNDLE_RAYS;
use conray_core::Ray;
use rayon::prelude::*;
use std::time::Instant;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Rays per point
    #[arg(long, value_delimiter = ',', default_values_t = [16, 64, 256])]
    rays: Vec<u32>,
    /// Side of the image whose points are taken
    #[arg(long, default_value_t = 256)]
    side: u32,
    /// Timed rounds
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// AO distance
    #[arg(long, default_value_t = Distance::Auto)]
    distance: Distance,
}

/// A way to count open rays: name, and the open rays of some points.
type Kernel<'a> = (&'static str, Box<dyn Fn(&[SurfacePoint], &[Vec3], u32) -> u64 + Sync + 'a>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    let library = Embree::find().ok_or("Embree is not there: run bench/fetch-rivals")?;
    println!("{} threads", rayon::current_num_threads());
    for name in &args.scenes {
        let settings = AoSettings { distance: args.distance, ..AoSettings::default() };
        let scene = Hemispheres::new(judged(name)?, &settings, args.side)?;
        let start = Instant::now();
        let embree = Embree::build(&library, scene.session.geometry(), false)?;
        println!(
            "{}: {} triangles, {} points, distance {}; BVH {:.3} s, Embree's {:.3} s",
            scene.name,
            scene.session.geometry().triangle_count(),
            scene.points.len(),
            scene.distance,
            scene.session.report().bvh_seconds,
            start.elapsed().as_secs_f64()
        );
        let distance = scene.distance;
        let kernels: Vec<Kernel<'_>> = vec![
            (
                "conray, one by one",
                Box::new(|points, directions, rays| {
                    each(points, directions, rays, |point, directions| {
                        let origin = point.ray_origin();
                        let open = |&direction: &Vec3| {
                            scene.session.bvh().transmittance(&Ray { origin, direction, t_max: distance })
                                > 0.5
                        };
                        directions.iter().filter(|d| open(d)).count() as u64
                    })
                }),
            ),
            (
                "conray, bundles",
                Box::new(|points, directions, rays| {
                    each(points, directions, rays, |point, directions| {
                        let (origin, normal) = (point.ray_origin(), point.geometric_normal);
                        let mut open = [0.0; BUNDLE_RAYS];
                        let bundle = |directions: &[Vec3]| {
                            let open = &mut open[..directions.len()];
                            scene.session.bvh().transmittances(origin, normal, directions, distance, open);
                            open.iter().filter(|&&t| t > 0.5).count() as u64
                        };
                        directions.chunks(BUNDLE_RAYS).map(bundle).sum()
                    })
                }),
            ),
            (
                "Embree, one by one",
                Box::new(|points, directions, rays| {
                    each(points, directions, rays, |point, directions| {
                        let origin = point.ray_origin();
                        let open = |&direction: &Vec3| {
                            !embree.occluded1(&mut Ray1::new(&Ray { origin, direction, t_max: distance }))
                        };
                        directions.iter().filter(|d| open(d)).count() as u64
                    })
                }),
            ),
            (
                "Embree, 16",
                Box::new(|points, directions, rays| {
                    packets(&embree, points, directions, rays, distance, false)
                }),
            ),
            (
                "Embree, 16 coherent",
                Box::new(|points, directions, rays| {
                    packets(&embree, points, directions, rays, distance, true)
                }),
            ),
        ];
        for &rays in &args.rays {
            let mut seconds = vec![vec![0.0f64; args.rounds]; kernels.len()];
            let mut open = vec![0u64; kernels.len()];
            let mut made = Vec::new();
            for round in 0..args.rounds + 1 {
                open.fill(0);
                for points in scene.points.chunks(CHUNK) {
                    directions(points, rays, &mut made);
                    for step in 0..kernels.len() {
                        let k = (step + round) % kernels.len();
                        let start = Instant::now();
                        open[k] += kernels[k].1(points, &made, rays);
                        // Round 0 warms up.
                        if round > 0 {
                            seconds[k][round - 1] += start.elapsed().as_secs_f64();
                        }
                    }
                }
            }
            let count = scene.points.len() as f64 * f64::from(rays);
            for (k, (name, _)) in kernels.iter().enumerate() {
                seconds[k].sort_by(f64::total_cmp);
                let median = seconds[k][args.rounds / 2];
                println!(
                    "  {rays:4} rays  {name:22} {:7.2} Mrays/s ({:.2} to {:.2}), open {:.6}",
                    count / median / 1e6,
                    count / seconds[k][args.rounds - 1] / 1e6,
                    count / seconds[k][0] / 1e6,
                    open[k] as f64 / count
                );
            }
        }
    }
    Ok(())
}

/// Open rays of all points, point by point on all threads.
fn each(
    points: &[SurfacePoint],
    directions: &[Vec3],
    rays: u32,
    open: impl Fn(&SurfacePoint, &[Vec3]) -> u64 + Sync,
) -> u64 {
    points
        .par_chunks(64)
        .zip(directions.par_chunks(64 * rays as usize))
        .map(|(points, directions)| {
            let pairs = points.iter().zip(directions.chunks(rays as usize));
            pairs.map(|(point, directions)| open(point, directions)).sum::<u64>()
        })
        .sum()
}

fn packets(
    embree: &Embree,
    points: &[SurfacePoint],
    directions: &[Vec3],
    rays: u32,
    distance: f32,
    coherent: bool,
) -> u64 {
    each(points, directions, rays, |point, directions| {
        let origin = point.ray_origin();
        let packets = directions.chunks_exact(16);
        let open = |packet: &[Vec3]| {
            let hit = embree.occluded16(&mut Ray16::new(origin, packet, distance), coherent);
            u64::from(hit.count_zeros())
        };
        packets.map(open).sum()
    })
}
