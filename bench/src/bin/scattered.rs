//! Method `hybrid` over points that lie in no image, against as many rays.
//!
//! `cargo run --release -p conray-bench --bin scattered -- [SCENE...] [--points 16384] [--truth 4096]`

use clap::Parser;
use conray::target::Target;
use conray::{AoSettings, Control, Error, Estimate, Method, Session, SurfacePoint, Vec3, View};
use conray_bench::{Judged, judged};
use std::error::Error as StdError;

#[derive(Parser)]
struct Args {
    /// Built-in scenes or files
    #[arg(default_values = ["cornell", "atrium", "grove"])]
    scenes: Vec<String>,
    /// About so many points
    #[arg(long, default_value_t = 16384)]
    points: u32,
    /// Rays a point
    #[arg(long, value_delimiter = ',', default_values = ["16", "64", "256"])]
    rays: Vec<u32>,
    /// Rays a point for the truth
    #[arg(long, default_value_t = 4096)]
    truth: u32,
}

fn main() -> Result<(), Box<dyn StdError>> {
    let args = Args::parse();
    for name in &args.scenes {
        let Judged { name, scene, view } = judged(name)?;
        let mut session = Session::build(scene.geometry, &AoSettings::default())?;
        for (what, points) in [
            ("camera", seen(&session, &view, args.points)?),
            ("triangles", middles(&session, args.points as usize)),
        ] {
            let truth = run(&mut session, &points, Method::Rays, args.truth, 0x7eed)?.0;
            for &rays in &args.rays {
                let (plain, _, plain_seconds) = run(&mut session, &points, Method::Rays, rays, 0)?;
                let (found, expected, seconds) = run(&mut session, &points, Method::Hybrid, rays, 0)?;
                let (plain, error) = (rmse(&plain, &truth), rmse(&found, &truth));
                println!(
                    "{name:10} {what:9} {} points, {rays:4} rays: RMSE {error:.5} in {seconds:.3} s, rays {plain:.5} in \
                     {plain_seconds:.3} s, ratio {:.2}, expected over true {:.2}",
                    points.len(),
                    error / plain,
                    expected / error
                );
            }
        }
    }
    Ok(())
}

/// What the camera sees, in no order.
fn seen(session: &Session, view: &View, count: u32) -> Result<Vec<SurfacePoint>, Error> {
    let side = f64::from(count).sqrt() as u32;
    let mut points = session.camera(view, side, side)?.points().to_vec();
    points.sort_by_key(|point| conray_core::hash_u32(point.id));
    Ok(numbered(points))
}

/// Middles of triangles, large and tiny, some of them inside other parts.
fn middles(session: &Session, count: usize) -> Vec<SurfacePoint> {
    let geometry = session.geometry();
    let every = (geometry.triangle_count() as usize / count).max(1);
    let mut points = Vec::new();
    for (index, instance) in geometry.instances().iter().enumerate() {
        let mesh = geometry.mesh_of(index);
        for triangle in 0..mesh.triangles().len() {
            let [a, b, c] = mesh.corners(triangle).map(|p| instance.world_from_mesh.transform_point3(p));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            if normal != Vec3::ZERO {
                points.push(SurfacePoint::new((a + b + c) / 3.0, normal));
            }
        }
    }
    numbered(points.into_iter().step_by(every))
}

/// The numbers of points choose their rays.
fn numbered(points: impl IntoIterator<Item = SurfacePoint>) -> Vec<SurfacePoint> {
    (0..).zip(points).map(|(id, point)| point.with_id(id)).collect()
}

/// Estimates, their expected RMSE and seconds.
fn run(
    session: &mut Session,
    points: &Vec<SurfacePoint>,
    method: Method,
    rays: u32,
    seed: u32,
) -> Result<(Vec<Estimate>, f64, f64), Error> {
    session.set_plan(&AoSettings { method, rays: Some(rays), seed, ..AoSettings::default() })?;
    let outcome = session.run_target(points, Control::none())?;
    Ok((outcome.estimates, outcome.work.expected_rmse, outcome.work.seconds))
}

fn rmse(found: &[Estimate], truth: &[Estimate]) -> f64 {
    let squares = found.iter().zip(truth).map(|(f, t)| f64::from(f.visibility - t.visibility).powi(2));
    (squares.sum::<f64>() / truth.len().max(1) as f64).sqrt()
}
