//! Answers to questions about what is shown.

use super::{
    Boxes, Fault, Probe, Trouble, Truth, Wish,
    job::Job,
    order::Source,
    report::ProbedCone,
    scenes::{Held, trouble_of},
};
use conray::{
    AoSettings, Session, Vec3,
    target::{self, Camera, CameraTarget, Layers, Target, TargetError},
};
use std::{collections::HashMap, path::Path, sync::Arc};

/// Rays that a probe shows.
const PROBE_RAYS: u32 = 64;
/// Boxes that are shown at most: more are a thicket, and take long to draw.
const MOST_BOXES: usize = 1500;

/// What a pixel sees; `None` where that is nothing.
pub(super) fn probe(
    held: &Held,
    wish: &Wish,
    pixel: [u32; 2],
    side: usize,
) -> Result<Option<Probe>, Trouble> {
    let Some(session) = held.sessions.get(side).or(held.sessions.first()) else { return Ok(None) };
    let [width, height] = wish.size;
    let [px, py] = [pixel[0].min(width - 1), pixel[1].min(height - 1)];
    let camera = Camera::new(&wish.look.view("view"), width, height).map_err(|e| trouble_of(&e.into()))?;
    let ray = camera.ray(px, py);
    let Some(hit) = session.bvh().nearest(&ray) else { return Ok(None) };
    let point = session.bvh().surface_point(&hit, &ray).with_id(py * width + px);
    let cones = held.with_octree(side).and_then(|with| cones_by(with, session, &point)).unwrap_or_default();
    let rays = session.rays_at(&point, PROBE_RAYS);
    Ok(Some(Probe {
        pixel: [px, py],
        position: point.position.into(),
        normal: point.shading_normal.into(),
        footprint: camera.footprint(point.position),
        distance: session.plan().distance,
        cones,
        rays: rays.iter().map(|ray| (ray.direction.into(), ray.hit)).collect(),
    }))
}

/// The cones of a point by a session's plan through the octree that a session has.
fn cones_by(with: &Session, by: &Session, point: &conray::SurfacePoint) -> Option<Vec<ProbedCone>> {
    let octree = with.octree()?;
    let views = conray::ConeViews::new(by.plan(), octree);
    let cone = |view: conray::ConeView<'_>| ProbedCone {
        axis: view.axis.into(),
        half_angle_rad: view.cone.half_angle_rad,
        weight: view.cone.weight,
        visibility: view.visibility,
        error: view.error,
        alpha: view.alpha,
        rays: view.rays,
    };
    point.is_valid().then(|| views.at(point).map(cone).collect())
}

/// The nodes of a level that the seen surfaces lie in.
pub(super) fn boxes(held: &Held, job: &Job, level: u32) -> Option<Boxes> {
    let octree = held.with_octree(0)?.octree()?;
    let level = level.min(octree.levels().saturating_sub(1));
    let edge = octree.voxel_size() * (1u64 << level) as f32;
    let origin = octree.origin();
    let mut counts: HashMap<[i32; 3], u32> = HashMap::new();
    for point in job.target()?.points() {
        let cell = ((point.position - origin) / edge).floor().as_ivec3();
        *counts.entry(cell.into()).or_default() += 1;
    }
    let mut cells: Vec<([i32; 3], u32)> = counts.into_iter().collect();
    // Ties by place, so that the same picture has the same boxes.
    cells.sort_unstable_by_key(|&(cell, count)| (std::cmp::Reverse(count), cell));
    let found = cells.len();
    cells.truncate(MOST_BOXES);
    let node = |&(cell, _): &([i32; 3], u32)| {
        let corner = origin + edge * Vec3::new(cell[0] as f32, cell[1] as f32, cell[2] as f32);
        (corner.into(), octree.mean_sd(level, cell.into()).0)
    };
    Some(Boxes { level, edge, nodes: cells.iter().map(node).collect(), found })
}

/// All layers of a side, with its settings as attributes.
pub(super) fn layers(
    held: &Held,
    job: &Job,
    side: usize,
    scene: &str,
) -> Result<(Layers, Vec<(String, String)>), Trouble> {
    let (Some(target), Some(estimates)) = (job.target(), job.estimates(side)) else {
        return Err(request("there is no whole picture yet; try again in a moment"));
    };
    let mut layers = target.resolve(&estimates).map_err(|e| trouble_of(&e.into()))?;
    if job.is_drawn(side) {
        layers.leave_out("bent");
    }
    let mut attributes = conray::settings_text(&job.wish.sides[side]);
    attributes.push(("scene".into(), scene.into()));
    if let Some(session) = held.sessions.get(side) {
        attributes.push(("world-distance".into(), session.plan().distance.to_string()));
    }
    attributes.push(("version".into(), env!("CARGO_PKG_VERSION").into()));
    Ok((layers, attributes))
}

/// The visibility of an EXR image, as a truth.
pub(super) fn truth_of_exr(key: String, source: &Source) -> Result<Truth, Trouble> {
    let trouble = |e: TargetError| Trouble { fault: Fault::Input, message: e.to_string(), scene: None };
    let image = match source {
        Source::Bytes(file, _) => target::decode_exr_channels(&file.name, &file.bytes),
        Source::File(path) => target::read_exr_channels(path),
        Source::Builtin(name) => target::read_exr_channels(Path::new(name)),
    };
    let image = image.map_err(trouble)?;
    let Some(red) = image.channel("R") else {
        let message = format!("{}: it has no channel R, which holds the visibility", source.word());
        return Err(Trouble { fault: Fault::Input, message, scene: None });
    };
    let covered = image.channel("A");
    let value = |(index, &value): (usize, &f32)| {
        if covered.is_none_or(|a| a[index] > 0.0) { value } else { f32::NAN }
    };
    let visibility = Arc::new(red.iter().enumerate().map(value).collect());
    let size = [image.width, image.height];
    Ok(Truth { key, size, visibility, origin: format!("from {}", source.word()), done: 1.0 })
}

/// The settings of a truth: rays alone, of another seed than what is judged by it.
pub(super) fn truth_settings(judged: &AoSettings, rays: u32) -> AoSettings {
    AoSettings {
        method: conray::Method::Rays,
        rays: Some(rays),
        time: None,
        error: None,
        sampling: conray::Sampling::Sobol,
        seed: judged.seed ^ 0x5eed_7274,
        ..judged.clone()
    }
}

/// A truth so far, as planes.
pub(super) fn truth_so_far(
    key: &str,
    target: &CameraTarget,
    estimates: &[conray::Estimate],
    rays: [u32; 2],
    rmse: f64,
) -> Truth {
    let size = [target.camera().width(), target.camera().height()];
    let planes = super::planes::of_estimates(target.points(), estimates, size);
    let origin = format!("by {} rays a pixel of another seed, expected error {rmse:.4}", rays[0]);
    let done = rays[0] as f32 / rays[1].max(1) as f32;
    Truth { key: key.into(), size, visibility: planes.visibility, origin, done }
}

/// A request that cannot be met now.
pub(super) fn request(message: &str) -> Trouble {
    Trouble { fault: Fault::Request, message: message.into(), scene: None }
}
