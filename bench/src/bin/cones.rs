//! Time of the cones of a point: our sets against as many of Embree's rays, at the points that an image sees.
//!
//! `cargo run --release -p conray-bench --bin cones -- cornell atrium PATH... [--voxels 512,1024]`
//!
//! `bench/fetch-rivals` fetches Embree; without it the program fails, as a comparison with nothing is none. Every surface
//! is opaque, for cones as for rays. A set's time includes turning its axes to the point's normal; that of the rays leaves
//! the making of their directions out.

use clap::Parser;
use conray::{AoSettings, Distance, SurfacePoint, Vec3};
use conray_bench::{
    cone_sets::ConeSets,
    embree::{Device, Embree, Ray1, SceneFlags},
    hemispheres::{CHUNK, Directions, Hemispheres, Order},
    judged,
};
use conray_core::{ConeSet, Falloff, Frame, HemisphereCones, Ray};
use conray_voxel::{ConeQuery, Octree, OctreeOptions};
use rayon::prelude::*;
use std::time::Instant;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium"])]
    scenes: Vec<String>,
    /// Leaves along the octree's longest side
    #[arg(long, value_delimiter = ',', default_values_t = [512])]
    voxels: Vec<u32>,
    /// Cones per point, and rays
    #[arg(long, default_value_t = 16)]
    cones: u32,
    /// Side of the image whose points are taken
    #[arg(long, default_value_t = 256)]
    side: u32,
    /// Timed rounds
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// AO distance
    #[arg(long, default_value_t = Distance::Auto)]
    distance: Distance,
}

/// A way to find the mean visibility of some points: name, and the sum over them.
type Kernel<'a> = (&'static str, Box<dyn Fn(&[SurfacePoint], &[Vec3]) -> f64 + Sync + 'a>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    let device = Device::new("")?;
    let set = ConeSet::from_count(args.cones).ok_or("6, 9, 16 or 25 cones")?;
    println!("{} threads, {:?}", rayon::current_num_threads(), conray_voxel::SimdLevel::new());
    for name in &args.scenes {
        let settings = AoSettings { distance: args.distance, ..AoSettings::default() };
        let scene = Hemispheres::new(judged(name)?, &settings, args.side)?;
        let embree = Embree::build(&device, scene.session.geometry(), SceneFlags::default())?;
        println!(
            "{}: {} triangles, {} points, distance {}",
            scene.name,
            scene.session.geometry().triangle_count(),
            scene.points.len(),
            scene.distance
        );
        for &resolution in &args.voxels {
            let options = OctreeOptions { resolution, ..OctreeOptions::default() };
            let octree = Octree::build(scene.session.geometry(), &options)?;
            compare(&args, &scene, &octree, set, &embree);
        }
    }
    Ok(())
}

/// Times all kernels in turns and prints a row for each.
fn compare(args: &Args, scene: &Hemispheres, octree: &Octree, set: ConeSet, embree: &Embree) {
    let cones = &HemisphereCones::new(set);
    let distance = scene.distance;
    let half_angle_rad = cones.half_angle_rad();
    let sets = ConeSets::new(octree, set, distance);
    let kernels: Vec<Kernel<'_>> = vec![
        (
            "Embree, rays one by one",
            Box::new(|points, directions| {
                each(points, directions, args.cones, |point, directions| {
                    let origin = point.ray_origin();
                    let open = |&direction: &Vec3| {
                        let mut ray = [Ray1::new(&Ray { origin, direction, t_max: distance })];
                        embree.occluded1(&mut ray);
                        ray[0].is_open()
                    };
                    directions.iter().filter(|d| open(d)).count() as f32 / args.cones as f32
                })
            }),
        ),
        (
            "conray, set of cones",
            Box::new(|points, _| points.par_chunks(64).map(|points| sets.visibility(points)).sum()),
        ),
        (
            "conray, cones one by one",
            Box::new(|points, directions| {
                each(points, directions, args.cones, |point, _| {
                    singly(octree, cones, half_angle_rad, distance, point)
                })
            }),
        ),
    ];
    let (seconds, sums) = time(args, scene, &kernels);
    let threads = rayon::current_num_threads() as f64;
    let to_ns = threads * 1e9 / scene.points.len() as f64;
    let rival = median(&seconds[0]);
    for (k, (name, _)) in kernels.iter().enumerate() {
        let (least, most) = (seconds[k][0], seconds[k][args.rounds - 1]);
        println!(
            "  {:4} voxels  {name:24} {:8.0} ns a point and thread ({:.0} to {:.0}), {:.2} of Embree, visibility {:.4}",
            octree.resolution(),
            median(&seconds[k]) * to_ns,
            least * to_ns,
            most * to_ns,
            median(&seconds[k]) / rival,
            sums[k] / scene.points.len() as f64
        );
    }
}

/// Seconds of each kernel's rounds, ascending, and the sums of visibility.
fn time(args: &Args, scene: &Hemispheres, kernels: &[Kernel<'_>]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut seconds = vec![vec![0.0f64; args.rounds]; kernels.len()];
    let mut sums = vec![0.0; kernels.len()];
    let mut drawn = Directions::default();
    for round in 0..args.rounds + 1 {
        sums.fill(0.0);
        for points in scene.points.chunks(CHUNK) {
            drawn.draw(points, args.cones as usize);
            let made = drawn.ordered(Order::Morton).directions;
            for step in 0..kernels.len() {
                let k = (step + round) % kernels.len();
                let start = Instant::now();
                sums[k] += kernels[k].1(points, &made);
                // Round 0 warms up.
                if round > 0 {
                    seconds[k][round - 1] += start.elapsed().as_secs_f64();
                }
            }
        }
    }
    seconds.iter_mut().for_each(|s| s.sort_by(f64::total_cmp));
    (seconds, sums)
}

fn median(sorted: &[f64]) -> f64 {
    sorted[sorted.len() / 2]
}

/// Sum of a function of all points and their directions, on all threads.
fn each(
    points: &[SurfacePoint],
    directions: &[Vec3],
    rays: u32,
    visibility: impl Fn(&SurfacePoint, &[Vec3]) -> f32 + Sync,
) -> f64 {
    points
        .par_chunks(64)
        .zip(directions.par_chunks(64 * rays as usize))
        .map(|(points, directions)| {
            let pairs = points.iter().zip(directions.chunks(rays as usize));
            pairs.map(|(point, directions)| f64::from(visibility(point, directions))).sum::<f64>()
        })
        .sum()
}

fn singly(
    octree: &Octree,
    cones: &HemisphereCones,
    half_angle_rad: f32,
    distance: f32,
    point: &SurfacePoint,
) -> f32 {
    let frame = Frame::from_normal(point.geometric_normal);
    let one = |cone: &conray_core::Cone| {
        let query = ConeQuery {
            apex: point.position,
            axis: frame.to_world(cone.axis),
            half_angle_rad,
            normal: point.geometric_normal,
            distance,
            falloff: Falloff::None,
        };
        cone.weight * octree.march(&query).visibility
    };
    cones.cones().iter().map(one).sum()
}
