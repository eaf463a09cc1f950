//! Measures building and single-thread ray speed: `cargo run --release -p conray-bvh --example rays_per_second [FILE.obj]`.
//!
//! Without a file: a generated hall of wavy floors and columns. Rays are those of ambient occlusion: they start at
//! random surface points, cosine-weighted, incoherent. Of an OBJ file only vertices and faces are read.

#[path = "../tests/common/obj.rs"]
mod obj;

use conray_bvh::{Bvh, Hit};
use conray_core::{
    Affine3A, Falloff, Frame, Geometry, Ray, SurfacePoint, TriangleMesh, Vec3, cosine_hemisphere, hash_u32,
    owen_sobol_2d,
};
use std::hint::black_box;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

fn main() {
    let mesh = match std::env::args().nth(1) {
        Some(path) => obj::read(&std::fs::read_to_string(path).expect("the file can be read")),
        None => hall(),
    };
    let mut geometry = Geometry::default();
    let mesh = geometry.add_mesh(mesh).expect("there are no materials");
    geometry.add_instance(mesh, Affine3A::IDENTITY).expect("the mesh exists");
    let geometry = Arc::new(geometry);
    let builds = (0..3).map(|_| {
        let start = Instant::now();
        black_box(Bvh::build(geometry.clone()).expect("the scene is sound"));
        start.elapsed()
    });
    let build = builds.min().expect("three builds");
    let bvh = Bvh::build(geometry).expect("the scene is sound");
    println!("built in {build:.0?} on {} threads: {:?}", rayon::current_num_threads(), bvh.stats());
    let size = bvh.bounds().diagonal();
    for (name, distance) in [("0.05", 0.05 * size), ("0.2", 0.2 * size), ("inf", f32::INFINITY)] {
        for (what, points, per_point, scattered) in
            [("16 rays a point, points in order", 1 << 15, 16, false), ("scattered rays", 1 << 19, 1, true)]
        {
            let rays = ambient_rays(&bvh, distance, points, per_point, scattered);
            let (transmittance, open) = speed(&rays, |ray| bvh.transmittance(ray));
            let (falloff, _) = speed(&rays, |ray| bvh.visibility(ray, Falloff::Linear, distance));
            let (nearest, _) = speed(&rays, |ray| bvh.nearest(ray).map_or(0.0, |hit| hit.t));
            println!(
                "distance {name} of the diagonal, {what}: transmittance {transmittance:.2}, with falloff \
                 {falloff:.2}, nearest {nearest:.2} Mrays/s; mean visibility {open:.4}"
            );
        }
    }
}

/// Best of three rates in million rays a second, and the mean result.
fn speed(rays: &[Ray], query: impl Fn(&Ray) -> f32) -> (f64, f64) {
    let mut best = 0f64;
    let mut mean = 0.0;
    for _ in 0..3 {
        let start = thread_secs();
        let sum: f64 = rays.iter().map(|ray| f64::from(query(ray))).sum();
        best = best.max(rays.len() as f64 / (thread_secs() - start) / 1e6);
        mean = sum / rays.len() as f64;
    }
    (best, mean)
}

/// Time that this thread has had a processor, where the system tells (Linux); else the time of day. A busy machine
/// then does not look like slow code.
fn thread_secs() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let scheduled = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = scheduled.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.get_or_init(Instant::now).elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// Rays from `points` points, `per_point` from each, all incoherent in direction. Points lie on triangles in the order
/// of the mesh, as neighbours in an image or an atlas do, or scattered at random: then every ray also misses the
/// caches.
fn ambient_rays(bvh: &Bvh, distance: f32, points: u32, per_point: u32, scattered: bool) -> Vec<Ray> {
    let triangles = bvh.geometry().mesh_of(0).triangles().len() as u32;
    let rays = |i: u32| {
        let [a, b] = owen_sobol_2d(i, 1).to_array();
        let (u, v) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
        let in_order = (u64::from(i) * u64::from(triangles) / u64::from(points)) as u32;
        let triangle = if scattered { hash_u32(i) % triangles } else { in_order };
        let hit = Hit { t: 1.0, instance: 0, triangle, u, v };
        let from = Vec3::new(0.3, -0.9, 0.2) * if hash_u32(!i) & 1 == 0 { 1.0 } else { -1.0 };
        let viewer = Ray { origin: Vec3::ZERO, direction: from, t_max: f32::INFINITY };
        let point: SurfacePoint = bvh.surface_point(&hit, &viewer);
        let frame = Frame::from_normal(point.geometric_normal);
        (0..per_point).map(move |k| {
            let direction = frame.to_world(cosine_hemisphere(owen_sobol_2d(k, hash_u32(i))));
            Ray { origin: point.ray_origin(), direction, t_max: distance }
        })
    };
    (0..points).flat_map(rays).collect()
}

/// A hall of about 200,000 triangles: wavy floor and ceiling, four walls, rows of round columns.
fn hall() -> TriangleMesh {
    let mut hall = Surface::default();
    let wave = |x: f32, y: f32| 0.1 * (7.0 * x).sin() * (5.0 * y).cos();
    hall.add(200, 100, |u, v| Vec3::new(20.0 * u, wave(20.0 * u, 10.0 * v), 10.0 * v));
    hall.add(200, 100, |u, v| Vec3::new(20.0 * u, 6.0 + wave(20.0 * u, 10.0 * v), 10.0 * v));
    for z in [0.0, 10.0] {
        hall.add(60, 20, |u, v| Vec3::new(20.0 * u, 6.0 * v, z));
    }
    for x in [0.0, 20.0] {
        hall.add(30, 20, |u, v| Vec3::new(x, 6.0 * v, 10.0 * u));
    }
    for i in 0..24 {
        let (x, z) = (1.5 + 1.5 * (i % 12) as f32, if i < 12 { 2.5 } else { 7.5 });
        hall.add(64, 36, |u, v| {
            let (sin, cos) = (std::f32::consts::TAU * u).sin_cos();
            let r = 0.35 + 0.05 * (9.0 * v).cos();
            Vec3::new(x + r * cos, 6.0 * v, z + r * sin)
        });
    }
    TriangleMesh::new(hall.positions, hall.triangles).expect("all indices are in range")
}

#[derive(Default)]
struct Surface {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// A grid of `2 columns rows` triangles over the unit square.
    fn add(&mut self, columns: u32, rows: u32, at: impl Fn(f32, f32) -> Vec3) {
        let first = self.positions.len() as u32;
        for j in 0..=rows {
            for i in 0..=columns {
                self.positions.push(at(i as f32 / columns as f32, j as f32 / rows as f32));
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let a = first + j * (columns + 1) + i;
                let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
                self.triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
}
