//! The probed point: its cones as a fan, and some of its rays.

use super::Viewer;
use crate::{colour::Map, engine::Probe};
use conray::Vec3;
use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, vec2};
use std::f32::consts::TAU;

/// Length of the fan as a share of the picture's height.
const REACH: f32 = 0.2;
/// Corners of a cone's rim.
const RIM: usize = 20;

/// Draws what is known of the probed point.
pub(super) fn draw(painter: &Painter, viewer: &Viewer, rect: Rect) {
    let (Some(probe), Some(look)) = (&viewer.shown.probe, viewer.choices.look) else { return };
    let size = [rect.width(), rect.height()];
    let project = |at: Vec3| look.project(at, size).map(|[x, y]| rect.min + vec2(x, y));
    let position = Vec3::from(probe.position);
    let Some(centre) = project(position) else { return };
    let painter = painter.with_clip_rect(painter.clip_rect().intersect(rect));
    // As long as can be read on the screen, but no longer than occluders count.
    let depth = (position - Vec3::from(look.eye)).dot(look.basis().forward);
    let tall = 2.0 * depth * (0.5 * look.vertical_fov_deg.to_radians()).tan();
    let reach = (REACH * tall).min(probe.distance);
    if viewer.fields.shows_rays {
        rays(&painter, probe, &project, reach, centre);
    }
    if viewer.fields.shows_cones {
        cones(&painter, probe, &project, reach, centre);
    }
    painter.circle(centre, 4.0, Color32::WHITE, Stroke::new(1.5, Color32::BLACK));
}

fn rays(painter: &Painter, probe: &Probe, project: &dyn Fn(Vec3) -> Option<Pos2>, reach: f32, centre: Pos2) {
    for (direction, hit) in &probe.rays {
        let length = hit.map_or(reach, |hit| hit.min(reach));
        let Some(end) = project(Vec3::from(probe.position) + length * Vec3::from(*direction)) else {
            continue;
        };
        let is_open = hit.is_none();
        let colour = if is_open { Color32::from_rgb(120, 200, 255) } else { Color32::from_rgb(255, 110, 90) };
        painter.line_segment([centre, end], Stroke::new(1.0, colour));
        if hit.is_some_and(|hit| hit <= reach) {
            painter.circle_filled(end, 2.0, colour);
        }
    }
}

fn cones(painter: &Painter, probe: &Probe, project: &dyn Fn(Vec3) -> Option<Pos2>, reach: f32, centre: Pos2) {
    for cone in &probe.cones {
        let axis = Vec3::from(cone.axis);
        let (across, other) = axis.any_orthonormal_pair();
        let (sin, cos) = cone.half_angle_rad.sin_cos();
        let rim = (0..=RIM).filter_map(|k| {
            let (s, c) = (TAU * k as f32 / RIM as f32).sin_cos();
            let direction = axis * cos + (across * c + other * s) * sin;
            project(Vec3::from(probe.position) + reach * direction)
        });
        let rim: Vec<Pos2> = rim.collect();
        let colour = Map::Sequential.colour(cone.visibility);
        if let Some(tip) = project(Vec3::from(probe.position) + reach * axis) {
            painter.line_segment([centre, tip], Stroke::new(1.5, colour));
        }
        painter.add(Shape::line(rim, Stroke::new(2.0, colour)));
    }
}
