//! Times reading and writing: PLY points in each encoding, PNG and EXR of one image.
//!
//! `cargo run --release -p conray-target --example measure [VERTICES]` (10 million unless said; a tenth of it as ASCII).

use conray_core::{Estimate, SurfacePoint, Vec3, View, hash_u32};
use conray_target::{
    Camera, CameraTarget, PngDepth, PointsTarget, Target, read_exr_channels, write_exr, write_png,
};
use std::{
    error::Error,
    fs::{self, File},
    io::{BufWriter, Write},
    path::Path,
    time::Instant,
};

fn main() -> Result<(), Box<dyn Error>> {
    let vertices: u32 = std::env::args().nth(1).map_or(Ok(10_000_000), |text| text.parse())?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("points.ply");
    for (encoding, count) in [("binary_little_endian", vertices), ("ascii", vertices / 10)] {
        write_cloud(&path, encoding, count)?;
        let target = timed(&format!("read {count} {encoding} vertices"), || PointsTarget::read(&path))?;
        let estimates: Vec<_> = target.points().iter().map(estimate).collect();
        timed("write them with estimates", || target.write(&path, &estimates))?;
        println!("  {:.0} MB", fs::metadata(&path)?.len() as f64 / 1e6);
    }
    let target = timed("camera rays of 1920x1080 to a plane", camera_target)?;
    let estimates: Vec<_> = target.points().iter().map(estimate).collect();
    let layers = timed("resolve", || target.resolve(&estimates))?;
    let path = folder.path().join("image");
    timed("write PNG, 8 bit", || write_png(&path, &layers, PngDepth::Eight))?;
    timed("write PNG, 16 bit", || write_png(&path, &layers, PngDepth::Sixteen))?;
    timed("write EXR, 18 channels", || write_exr(&path, &layers, &[]))?;
    timed("read EXR, 18 channels", || read_exr_channels(&path))?;
    println!("  {:.0} MB", fs::metadata(&path)?.len() as f64 / 1e6);
    Ok(())
}

fn timed<T, E>(what: &str, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    let start = Instant::now();
    let result = work();
    println!("{what}: {:.3} s", start.elapsed().as_secs_f64());
    result
}

/// A number in [0, 1) for an index.
fn unit(i: u32) -> f32 {
    (hash_u32(i) >> 8) as f32 / (1 << 24) as f32
}

fn estimate(p: &SurfacePoint) -> Estimate {
    let cone = conray_core::ConeEstimate { visibility: unit(p.id), error: 0.1, alpha: 0.5 };
    Estimate { visibility: unit(!p.id), error: 0.01, rays: 64, bent: Vec3::Z, cone: Some(cone) }
}

/// Random points with upward normals and a colour.
fn write_cloud(path: &Path, encoding: &str, count: u32) -> Result<(), Box<dyn Error>> {
    let mut file = BufWriter::new(File::create(path)?);
    let floats = ["x", "y", "z", "nx", "ny", "nz"].map(|n| format!("property float {n}\n")).concat();
    write!(
        file,
        "ply\nformat {encoding} 1.0\nelement vertex {count}\n{floats}property uchar red\nend_header\n"
    )?;
    for i in 0..count {
        let values = [unit(3 * i), unit(3 * i + 1), unit(3 * i + 2), 0.0, 0.6, 0.8];
        if encoding == "ascii" {
            let [x, y, z, nx, ny, nz] = values;
            writeln!(file, "{x} {y} {z} {nx} {ny} {nz} 7")?;
        } else {
            file.write_all(values.map(f32::to_le_bytes).as_flattened())?;
            file.write_all(&[7])?;
        }
    }
    Ok(file.flush()?)
}

fn camera_target() -> Result<CameraTarget, Box<dyn Error>> {
    let (eye, look_at, up) = (Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y);
    let view = View { name: "front".into(), eye, look_at, up, vertical_fov_deg: 60.0 };
    Ok(CameraTarget::trace(Camera::new(&view, 1920, 1080)?, |ray| {
        let t = -ray.origin.z / ray.direction.z;
        Some(SurfacePoint::new(ray.origin + t * ray.direction, Vec3::Z))
    }))
}
