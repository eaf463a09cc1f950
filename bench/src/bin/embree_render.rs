//! What `conray render --method rays --alpha opaque` does, done with Embree: the rival of the whole program.
//!
//! `cargo run --release -p conray-bench --bin embree_render -- SCENE --size 1280x720 --rays 64 -o x.png`
//!
//! Loader, camera, sampling and the writing of the image are conray's, as Embree has none; hierarchy and rays are
//! Embree's in its best mode, packets of 16 in cells of the hemisphere. Prints the seconds of each step.

use clap::Parser;
use conray::{
    Estimate, Ray, SurfacePoint, Vec3,
    target::{Camera, CameraTarget, PngDepth, Target, write_png},
};
use conray_bench::{
    embree::{Device, Embree, Nearest, Packet, SceneFlags},
    judged,
};
use conray_bvh::{position_error, triangle_point};
use conray_core::{Frame, Geometry, LANES, cosine_hemisphere_lanes, hash_u32, owen_sobol_2d_lanes};
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use std::{path::PathBuf, time::Instant};

const PACKET: usize = LANES;

#[derive(Parser)]
struct Args {
    /// A built-in scene or a file
    scene: String,
    /// Size of the image in pixels
    #[arg(long, default_value = "1280x720", value_parser = parse_size)]
    size: (u32, u32),
    /// Rays per pixel, a multiple of 16
    #[arg(long, default_value_t = 64)]
    rays: u32,
    /// PNG to write
    #[arg(short, long, default_value = "embree.png")]
    output: PathBuf,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args = Args::parse();
    if args.rays == 0 || !args.rays.is_multiple_of(PACKET as u32) {
        return Err(format!("--rays: expected a multiple of {PACKET}").into());
    }
    let mut clock = Clock(Instant::now());
    let loaded = judged(&args.scene)?;
    let geometry = loaded.scene.geometry;
    clock.step("load");
    let embree = Embree::build(&Device::new("")?, &geometry, SceneFlags::default())?;
    clock.step("build");
    let camera = Camera::new(&loaded.view, args.size.0, args.size.1)?;
    let hit = |ray: &Ray| embree.nearest(ray).map(|hit| surface_point(&geometry, &hit, ray));
    let target = CameraTarget::trace(camera, hit);
    clock.step("primary rays");
    let distance = conray::AUTO_DISTANCE_SHARE * geometry.bounds().diagonal();
    let points = target.points().par_chunks(PACKET);
    let estimate = |point: &SurfacePoint| Estimate {
        visibility: visibility(&embree, point, args.rays, distance),
        rays: args.rays,
        ..Estimate::PENDING
    };
    let estimates: Vec<Estimate> = points.flat_map_iter(|points| points.iter().map(estimate)).collect();
    clock.step("occlusion");
    write_png(&args.output, &target.resolve(&estimates)?, PngDepth::Eight)?;
    clock.step("write");
    Ok(())
}

/// Share of the rays of a point that are open: conray's directions, made as conray makes them, sorted into cells of sixteen.
///
/// Sorting by counting in kept memory, or into full Morton order, was tried and did not pay.
fn visibility(embree: &Embree, point: &SurfacePoint, rays: u32, distance: f32) -> f32 {
    let (origin, frame) = (point.ray_origin(), Frame::from_normal(point.shading_normal));
    // As conray draws them with its default seed.
    let seed = hash_u32(point.id ^ hash_u32(conray::AoSettings::default().seed));
    let side = (rays as f32 / PACKET as f32).sqrt().floor();
    let level = Level::new();
    let mut cells: Vec<(u32, Vec3)> = Vec::with_capacity(rays as usize);
    for first in (0..rays).step_by(PACKET) {
        let ([u, v], [x, y, z]) = dispatch!(level, simd => sixteen(simd, first, seed, &frame));
        cells.extend((0..PACKET).map(|i| {
            let cell = (u[i] * side) as u32 * side as u32 + (v[i] * side) as u32;
            (cell, Vec3::new(x[i], y[i], z[i]))
        }));
    }
    cells.sort_unstable_by_key(|cell| cell.0);
    let mut packets: Vec<Packet<PACKET>> = cells
        .chunks_exact(PACKET)
        .map(|cells| Packet::new([origin; PACKET], std::array::from_fn(|i| cells[i].1), distance))
        .collect();
    embree.occluded(&mut packets, false);
    let open = packets.iter().flat_map(Packet::open);
    // Below its own surface a point sees nothing, whatever is there.
    let above = cells.iter().map(|cell| cell.1.dot(point.geometric_normal) > 0.0);
    open.zip(above).filter(|(open, above)| *open && *above).count() as f32 / rays as f32
}

/// Sixteen samples as conray makes them: points of the square, and directions.
#[inline(always)]
fn sixteen<S: Simd>(
    simd: S,
    first: u32,
    seed: u32,
    frame: &Frame,
) -> ([[f32; PACKET]; 2], [[f32; PACKET]; 3]) {
    let square = owen_sobol_2d_lanes(simd, first, seed);
    let [x, y, z] = frame.to_world_lanes(simd, cosine_hemisphere_lanes(simd, square));
    (square.map(Into::into), [x.into(), y.into(), z.into()])
}

/// The surface point of a hit, on the side that the ray came from.
fn surface_point(geometry: &Geometry, hit: &Nearest, ray: &Ray) -> SurfacePoint {
    let (instance, mesh) = (&geometry.instances()[hit.instance], geometry.mesh_of(hit.instance));
    let place = &instance.world_from_mesh;
    let corners = mesh.corners(hit.triangle).map(|p| place.transform_point3(p));
    let [u, v] = hit.barycentric;
    let position = triangle_point(&corners, u, v);
    let position_error = position_error(&corners, position);
    let facing = |n: Vec3| if n.dot(ray.direction) > 0.0 { -n } else { n };
    let plane = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let geometric_normal = facing(plane.normalize_or_zero());
    let shading_normal = if mesh.normals().is_empty() {
        geometric_normal
    } else {
        let [a, b, c] = mesh.triangles()[hit.triangle].map(|i| mesh.normals()[i as usize]);
        let normal = place.matrix3.inverse().transpose() * (a * (1.0 - u - v) + b * u + c * v);
        let normal = normal.normalize_or_zero();
        let turned = if normal.dot(geometric_normal) < 0.0 { -normal } else { normal };
        if turned.length_squared() > 0.5 { turned } else { geometric_normal }
    };
    SurfacePoint { position, geometric_normal, shading_normal, footprint: 0.0, position_error, id: 0 }
}

/// Prints the seconds since the last step.
struct Clock(Instant);

impl Clock {
    fn step(&mut self, name: &str) {
        println!("{name:14} {:.3} s", self.0.elapsed().as_secs_f64());
        self.0 = Instant::now();
    }
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    sides.ok_or_else(|| "expected WIDTHxHEIGHT, such as 1280x720".into())
}
