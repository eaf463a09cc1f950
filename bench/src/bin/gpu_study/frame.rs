//! Pictures made wholly on the device: the fewest rays a pixel for a true error, and what they take.

use crate::runs::{Run, Stage, median, rmse};
use conray::{Estimate, SurfacePoint, target::Camera};
use conray_estimate::{Method, RayErrors};
use conray_gpu::{FrameCamera, Frames, GpuError};
use std::{error::Error, time::Instant};

/// Rays a pixel that are tried, the fewest first.
const RAYS: [f32; 8] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];

/// A picture of so many rays a pixel.
fn picture(
    stage: &Stage,
    frames: &mut Frames,
    camera: &FrameCamera,
    errors: &RayErrors,
    rays: f32,
    points: &[SurfacePoint],
) -> Result<Run, GpuError> {
    let gpu = stage.device.gpu();
    gpu.kernel_times();
    let start = Instant::now();
    let found = frames.render(camera, rays, errors)?;
    let seconds = start.elapsed().as_secs_f64();
    let kernels = gpu.kernel_times();
    let pixels = frames.pixels()?;
    let estimate = |point: &SurfacePoint| {
        let known = pixels[point.id as usize].map(|pixel| [pixel.visibility, pixel.error]);
        known.map_or(Estimate::INVALID, |[visibility, error]| Estimate {
            visibility,
            error,
            ..Estimate::PENDING
        })
    };
    let estimates = points.iter().map(estimate).collect();
    Ok(Run { seconds, kernels, estimates, rays: found.rays, errors: None })
}

/// The first picture that is as right as that, and its rays a pixel; the last one tried where none is.
pub(crate) fn fewest(
    stage: &Stage,
    camera: &Camera,
    errors: &RayErrors,
    (error, repeats): (f32, usize),
    points: &[SurfacePoint],
    truth: &[Estimate],
) -> Result<(f32, Run), Box<dyn Error>> {
    let plan = stage.plan(Method::Hybrid, 1)?;
    let mut frames = stage.device.frames(&plan, stage.bounds, stage.size)?;
    let [right, up, forward] = camera.basis();
    let camera = FrameCamera { eye: camera.eye(), right, up, forward, pixel_side: camera.pixel_side() };
    let mut of = |rays: f32| picture(stage, &mut frames, &camera, errors, rays, points);
    for rays in RAYS {
        if rays == RAYS[RAYS.len() - 1] || rmse(&of(rays)?.estimates, truth) <= f64::from(error) {
            return Ok((rays, median(repeats, || of(rays))?));
        }
    }
    Err("no rays are tried".into())
}

/// Rays alone in the time of a picture: how many a pixel, and their error; of one ray where there is no time for it.
pub(crate) fn rays_alone(
    stage: &Stage,
    seconds: f64,
    rays_a_second: f64,
    points: &[SurfacePoint],
    truth: &[Estimate],
) -> Result<(f64, f64), Box<dyn Error>> {
    let rays = seconds * rays_a_second / points.len().max(1) as f64;
    let run = stage.run(Method::Rays, (rays.round() as u32).max(1), points)?;
    Ok((rays, run.rmse(truth)))
}
