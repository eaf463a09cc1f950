//! Cornices, string-courses and dentils: what runs round the whole court or round its walls.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::part::{Part, USUAL_CREASE_DEG};
use crate::builtin::shapes::{cuboid, mitred_ring};
use conray_core::{Vec2, Vec3};

/// Adds them.
pub(crate) fn add(assembly: &mut Assembly, stone: u32) {
    let mut rings = Faces::default();
    for profile in [gallery_cornice(), attic_course(), eaves_cornice()] {
        rings.extend(&mitred_ring(COURT, &profile));
    }
    for profile in [wall_plinth(), wall_string(LOWER_SPRINGING - 0.12), wall_string(GALLERY + 0.95)] {
        rings.extend(&mitred_ring(INSIDE, &profile));
    }
    let mut part = rings.smooth(USUAL_CREASE_DEG);
    add_dentils(&mut part, GALLERY - 0.4, LOWER_HALF_THICKNESS, [0.13, 0.14, 0.13], 0.32);
    add_dentils(&mut part, EAVES - 0.36, UPPER_HALF_THICKNESS, [0.12, 0.18, 0.26], 0.4);
    assembly.add("mouldings", part, stone);
}

/// Turns distances into the court into distances outside the columns' axis.
fn into_court(points: &[(f32, f32)]) -> Vec<Vec2> {
    points.iter().map(|&(inward, y)| Vec2::new(-inward, y)).collect()
}

fn gallery_cornice() -> Vec<Vec2> {
    let y = GALLERY;
    into_court(&[
        (0.20, y - 0.55),
        (0.37, y - 0.55),
        (0.38, y - 0.47),
        (0.43, y - 0.40),
        (0.43, y - 0.27),
        (0.54, y - 0.22),
        (0.62, y - 0.12),
        (0.63, y + 0.02),
        (0.20, y + 0.02),
    ])
}

fn attic_course() -> Vec<Vec2> {
    let y = CEILING + 0.15;
    into_court(&[(0.1, y), (0.26, y), (0.29, y + 0.06), (0.33, y + 0.1), (0.33, y + 0.16), (0.1, y + 0.2)])
}

fn eaves_cornice() -> Vec<Vec2> {
    let y = EAVES;
    into_court(&[
        (0.1, y - 0.42),
        (0.27, y - 0.42),
        (0.30, y - 0.34),
        (0.30, y - 0.18),
        (0.56, y - 0.15),
        (0.62, y - 0.02),
        (0.70, y + 0.08),
        (0.1, y + 0.12),
    ])
}

fn wall_plinth() -> Vec<Vec2> {
    into_court(&[(-0.1, -0.1), (0.12, -0.1), (0.12, 0.32), (0.08, 0.38), (0.07, 0.42), (-0.1, 0.45)])
}

fn wall_string(y: f32) -> Vec<Vec2> {
    into_court(&[
        (-0.1, y),
        (0.06, y),
        (0.09, y + 0.05),
        (0.13, y + 0.07),
        (0.13, y + 0.13),
        (-0.1, y + 0.16),
    ])
}

/// A row of small blocks (width, height, depth before the wall) under a cornice, all round the court.
fn add_dentils(part: &mut Part, y: f32, face: f32, [width, height, depth]: [f32; 3], spacing: f32) {
    let block = cuboid(Vec3::new(-0.5 * width, 0.0, -0.05), Vec3::new(0.5 * width, height, depth)).flat();
    for side in Side::all() {
        // None in the corners, where the rows of two sides would run into each other.
        let reach = side.half_length() - face - depth;
        let steps = (2.0 * (reach - 0.5 * width) / spacing).floor();
        for i in 0..=steps as usize {
            let x = (i as f32 - 0.5 * steps) * spacing;
            part.place(&block, &side.at(x, y, face));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn mouldings_are_closed_and_sound() {
        for profile in [gallery_cornice(), attic_course(), eaves_cornice(), wall_plinth(), wall_string(1.0)] {
            let ring = mitred_ring(COURT, &profile).smooth(USUAL_CREASE_DEG);
            assert_closed(&ring, "moulding");
            assert_sound(&ring, "moulding");
        }
    }
}
