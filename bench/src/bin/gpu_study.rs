//! What a graphics processor takes for each method on a scene: seconds of kernels by the device's own clock, rays a second, milliseconds of a pass of
//! cones, errors against many rays of another seed.
//!
//! `cargo run --release -p conray-bench --bin gpu_study -- [SCENE] [--view NAME] [--size 1920x1080] [--adapter NAME]`
//!
//! One program, with scene files beside it: it can be carried to a machine with a device.

use clap::Parser;
use conray::{AoSettings, Control, Estimate, Method, SurfacePoint, scene::Limits};
use conray_bvh::Bvh;
use conray_estimate::{AoPlan, Backend, Budget, Hybrid};
use conray_gpu::{Gpu, GpuBackend, KernelTime};
use conray_voxel::{Octree, OctreeOptions};
use std::{error::Error, path::Path, sync::Arc, time::Instant};

#[derive(Parser)]
struct Args {
    /// A built-in scene or a file
    #[arg(default_value = "atrium")]
    scene: String,
    /// Name of the view; the first one otherwise
    #[arg(long)]
    view: Option<String>,
    /// Pixels
    #[arg(long, default_value = "1920x1080", value_parser = size)]
    size: [u32; 2],
    /// Part of the adapter's name
    #[arg(long)]
    adapter: Option<String>,
    /// Leaves of the octree along the longest side
    #[arg(long, default_value_t = 512)]
    voxels: u32,
    /// Rays a point of method `rays`
    #[arg(long, default_value_t = 64)]
    rays: u32,
    /// Error that `hybrid` is asked for
    #[arg(long, default_value_t = 0.05)]
    error: f32,
    /// Rays a point of the truth
    #[arg(long, default_value_t = 1024)]
    truth: u32,
    /// Times that each method runs; the median counts
    #[arg(long, default_value_t = 3)]
    repeats: usize,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|side| *side > 0)).ok_or_else(|| "WIDTHxHEIGHT is expected".into())
}

/// What one run of a method came to.
struct Run {
    seconds: f64,
    kernels: Vec<KernelTime>,
    estimates: Vec<Estimate>,
    /// Traced, also those that are in no estimate.
    rays: u64,
}

impl Run {
    fn on_device(&self) -> f64 {
        self.kernels.iter().map(|time| time.seconds).sum()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let scene = match conray_scene::builtin(&args.scene) {
        Some(scene) => scene,
        None => conray::scene::load(Path::new(&args.scene), &Limits::default())?,
    };
    let view = match &args.view {
        None => scene.views.first(),
        Some(name) => scene.views.iter().find(|view| view.name == *name),
    };
    let view = view.ok_or("there is no such view")?.clone();
    let settings =
        |method| AoSettings { method, voxels: args.voxels, rays: Some(args.rays), ..AoSettings::default() };
    let bounds = scene.geometry.bounds();
    let plan = |method| AoPlan::new(&settings(method), bounds);
    let (geometry, start) = (Arc::new(scene.geometry), Instant::now());
    let bvh = Bvh::build(Arc::clone(&geometry))?;
    let bvh_seconds = start.elapsed().as_secs_f64();
    let camera = conray::target::Camera::new(&view, args.size[0], args.size[1])?;
    let hit = |ray: &conray_core::Ray| bvh.nearest(ray).map(|hit| bvh.surface_point(&hit, ray));
    let start = Instant::now();
    let target = conray::target::CameraTarget::trace(camera, hit);
    let points = conray::target::Target::points(&target);
    let seen_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let options = OctreeOptions { resolution: args.voxels, ..OctreeOptions::default() };
    let octree = Octree::build(&geometry, &options)?;
    let octree_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let device = GpuBackend::new(Gpu::open_timed(args.adapter.as_deref())?, Some(&geometry), Some(&octree))?;
    let upload_seconds = start.elapsed().as_secs_f64();
    let facts = device.gpu().facts();
    println!("adapter   {} ({}, {})", facts.name, facts.backend, facts.driver);
    if facts.is_software {
        println!("          a program on the CPU: times below are not those of a graphics processor");
    }
    println!(
        "scene     {}, view {}, {} x {}: {} points, {} triangles, {} voxels",
        args.scene,
        view.name,
        args.size[0],
        args.size[1],
        points.len(),
        geometry.stored_triangle_count(),
        octree.resolution()
    );
    println!(
        "apart     BVH {bvh_seconds:.3} s, octree {octree_seconds:.3} s, primary visibility {seen_seconds:.3} s, all on the CPU; trees, upload and shaders {upload_seconds:.3} s"
    );
    let truth_plan = AoPlan { seed: 0x7e57, ..plan(Method::Rays)? };
    let truth = estimated(&device, &truth_plan, args.truth, points)?;
    println!(
        "\n{:8} {:>10} {:>10} {:>9} {:>9} {:>8}  kernels",
        "method", "seconds", "on device", "Mrays", "Mrays/s", "RMSE"
    );
    for method in [Method::Cones, Method::Rays, Method::Paper, Method::Hybrid] {
        let plan = plan(method)?;
        let mut runs = Vec::new();
        for _ in 0..args.repeats.max(1) {
            device.gpu().kernel_times();
            let start = Instant::now();
            let (estimates, rays) = match method {
                Method::Hybrid => refined(&device, &bvh, &plan, args.error, args.size, points)?,
                _ => {
                    let found = estimated(&device, &plan, plan.samples(), points)?;
                    let rays = found.iter().map(|e| u64::from(e.rays)).sum();
                    (found, rays)
                }
            };
            let seconds = start.elapsed().as_secs_f64();
            runs.push(Run { seconds, kernels: device.gpu().kernel_times(), estimates, rays });
        }
        runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        tell(method, &runs[runs.len() / 2], &truth);
    }
    Ok(())
}

fn estimated(
    device: &GpuBackend,
    plan: &AoPlan,
    samples: u32,
    points: &[SurfacePoint],
) -> Result<Vec<Estimate>, Box<dyn Error>> {
    let mut estimates = vec![Estimate::PENDING; points.len()];
    device.estimate(plan, 0..samples, points, &mut estimates, Control::none())?;
    Ok(estimates)
}

fn refined(
    device: &GpuBackend,
    bvh: &Bvh,
    plan: &AoPlan,
    error: f32,
    size: [u32; 2],
    points: &[SurfacePoint],
) -> Result<(Vec<Estimate>, u64), Box<dyn Error>> {
    let mut hybrid = Hybrid::of_image(plan, points, 0, size);
    let budget = Budget { error: Some(error), ..Budget::rays(1 << 16) };
    hybrid.refine_on(device.hybrid_device(), plan, bvh, points, budget, Control::none());
    match hybrid.failure() {
        Some(failure) => Err(failure.to_string().into()),
        None => Ok((hybrid.estimates(), hybrid.rays())),
    }
}

fn tell(method: Method, run: &Run, truth: &[Estimate]) {
    let rays = run.rays as f64 / 1e6;
    let squares =
        run.estimates.iter().zip(truth).map(|(a, b)| f64::from(a.visibility - b.visibility).powi(2));
    let rmse = (squares.sum::<f64>() / truth.len().max(1) as f64).sqrt();
    let on_device = run.on_device();
    let kernels: Vec<String> = run
        .kernels
        .iter()
        .map(|time| format!("{} {:.3} ms in {}", time.kernel, 1e3 * time.seconds, time.runs))
        .collect();
    println!(
        "{:8} {:>10.4} {on_device:>10.4} {rays:>9.2} {:>9.1} {rmse:>8.4}  {}",
        method.to_string(),
        run.seconds,
        if on_device > 0.0 { rays / on_device } else { 0.0 },
        if kernels.is_empty() { "the adapter has no clock".into() } else { kernels.join(", ") }
    );
}
