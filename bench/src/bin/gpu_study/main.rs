//! What a graphics processor takes for each method on a scene: seconds of kernels by the device's own clock, rays a second, milliseconds of a pass of
//! cones, errors against many rays of another seed; and a picture made wholly there, beside rays alone in the same time.
//!
//! `cargo run --release -p conray-bench --bin gpu_study -- [SCENE] [--view NAME] [--size 1920x1080] [--adapter NAME]`
//!
//! One program, with scene files beside it: it can be carried to a machine with a device.

mod frame;
mod runs;

use clap::Parser;
use conray::{Method, scene::Limits, target::Target};
use conray_bvh::Bvh;
use conray_estimate::RayErrors;
use conray_gpu::{Gpu, GpuBackend};
use conray_voxel::{Octree, OctreeOptions};
use runs::{Stage, median, tell};
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
    /// Leave out method `paper`, whose rays take long on a program on the CPU
    #[arg(long)]
    without_paper: bool,
    /// Times that each method runs; the median counts
    #[arg(long, default_value_t = 3)]
    repeats: usize,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|side| *side > 0)).ok_or_else(|| "WIDTHxHEIGHT is expected".into())
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
    let bounds = scene.geometry.bounds();
    let (geometry, start) = (Arc::new(scene.geometry), Instant::now());
    let bvh = Arc::new(Bvh::build(Arc::clone(&geometry))?);
    let bvh_seconds = start.elapsed().as_secs_f64();
    let camera = conray::target::Camera::new(&view, args.size[0], args.size[1])?;
    let hit = |ray: &conray_core::Ray| bvh.nearest(ray).map(|hit| bvh.surface_point(&hit, ray));
    let start = Instant::now();
    let target = conray::target::CameraTarget::trace(camera, hit);
    let points = target.points();
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
    let stage = Stage { bvh, device: Arc::new(device), bounds, size: args.size, voxels: args.voxels };
    let truth = stage.truth(args.truth, points)?;
    println!(
        "\n{:8} {:>10} {:>10} {:>9} {:>9} {:>8}  kernels",
        "method", "seconds", "on device", "Mrays", "Mrays/s", "RMSE"
    );
    let mut runs = Vec::new();
    let methods = [Method::Cones, Method::Rays, Method::Hybrid, Method::Paper];
    for method in methods.into_iter().filter(|method| !(args.without_paper && *method == Method::Paper)) {
        let run = median(args.repeats, || match method {
            Method::Hybrid => stage.refine(args.error, points),
            _ => stage.run(method, args.rays, points),
        })?;
        tell(&method.to_string(), &run, &truth);
        runs.push(run);
    }
    let [cones, rays, hybrid, ..] = &runs[..] else { return Err("a method is missing".into()) };
    let errors = hybrid.errors.unwrap_or(RayErrors::UNKNOWN);
    let asked = (args.error, args.repeats);
    let (of_picture, picture) = frame::fewest(&stage, target.camera(), &errors, asked, points, &truth)?;
    tell("picture", &picture, &truth);
    println!(
        "\npicture   wholly on the device, {of_picture} rays a pixel: {:.3} ms there, true RMSE {:.4}, asked for {}",
        1e3 * picture.on_device(),
        picture.rmse(&truth),
        args.error
    );
    let rate = rays.rays as f64 / rays.on_device().max(f64::MIN_POSITIVE);
    let (alone, alone_rmse) = frame::rays_alone(&stage, picture.on_device(), rate, points, &truth)?;
    println!(
        "rays      alone in that time: {alone:.2} a pixel, RMSE {alone_rmse:.4}{}; picture / rays {:.3}",
        if alone < 1.0 { " with one" } else { "" },
        picture.rmse(&truth) / alone_rmse
    );
    let Some(paper) = runs.get(3) else { return Ok(()) };
    let [of_cones, of_rays, of_paper] = [cones, rays, paper].map(|run| run.rmse(&truth));
    println!(
        "blend     paper / cones {:.3}, with {:.1} rays a pixel; paper / rays {:.3}, with {}",
        of_paper / of_cones,
        paper.rays as f64 / points.len().max(1) as f64,
        of_paper / of_rays,
        args.rays
    );
    Ok(())
}
