//! The scene as a plain grey model under a sky and a lamp, for the figures that show what AO does.

use crate::Case;

/// Grey of the surfaces.
const ALBEDO: f32 = 0.85;
/// Share of the sky's light; the lamp gives the rest.
const SKY: f32 = 0.6;

/// Shade of each pixel in [0, 1]; the sky's light is dimmed by the visibility of each point, 1 for no AO at all.
///
/// The lamp stands above the viewer's left shoulder and casts no shadows; both sides of a surface are alike.
pub(super) fn shade(case: &Case, visibility: impl Fn(usize) -> f32) -> Vec<f32> {
    let view = &case.view;
    let towards_eye = (view.eye - view.look_at).normalize_or_zero();
    let left = towards_eye.cross(view.up).normalize_or_zero();
    let lamp = (towards_eye + 0.6 * view.up.normalize_or_zero() + 0.4 * left).normalize_or_zero();
    let values: Vec<f32> = (case.points().iter().enumerate())
        .map(|(index, point)| {
            let direct = point.shading_normal.dot(lamp).max(0.0);
            ALBEDO * (SKY * visibility(index) + (1.0 - SKY) * direct)
        })
        .collect();
    case.pixels(&values, 1.0)
}
