//! Ground, paving and the gallery's floor and ceiling.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::part::Part;
use crate::builtin::random::Random;
use crate::builtin::shapes::{chamfered_block, cuboid, mitred_ring};
use conray_core::{Affine3A, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Height of the court's paving; the arcades are a step higher, at 0.
const COURT_LEVEL: f32 = -0.16;
/// The court's paving reaches to this distance inside the columns' axes.
const STEP: f32 = 0.62;
/// Usual side of a paving slab.
const SLAB: f32 = 0.95;

/// Adds all floors, and the ceiling of the gallery with its beams.
pub(crate) fn add(assembly: &mut Assembly, paving: u32) {
    assembly.add("ground", ground().flat(), paving);
    let mut random = Random::new(21);
    let mut slabs = Part::default();
    let court = COURT - STEP;
    pave(&mut slabs, -court, court, COURT_LEVEL, &mut random);
    pave_ring(&mut slabs, court + 0.05, INSIDE, 0.0, &mut random);
    pave_ring(&mut slabs, COURT - 0.2, INSIDE, GALLERY, &mut random);
    assembly.add("paving", slabs, paving);

    let mut gallery = rectangle_ring(COURT, -0.35, GALLERY - 0.58, 6.0, GALLERY - 0.015);
    gallery.extend(&rectangle_ring(COURT, 0.0, CEILING, 6.0, CEILING + 0.25));
    assembly.add("gallery floor and ceiling", gallery.flat(), paving);
    assembly.add("beams", beams(), paving);
}

/// A ring round a rectangle with a rectangular section from `from` to `to` outside it and from y = `low` to y = `high`.
fn rectangle_ring(half: Vec2, from: f32, low: f32, to: f32, high: f32) -> Faces {
    mitred_ring(half, &[(from, low), (to, low), (to, high), (from, high)].map(|(x, y)| Vec2::new(x, y)))
}

/// The bed of the court's paving, and the arcades' floor with its rounded step.
fn ground() -> Faces {
    let (x, z) = (INSIDE.x + 0.5, INSIDE.y + 0.5);
    let mut faces = cuboid(Vec3::new(-x, -0.4, -z), Vec3::new(x, COURT_LEVEL - 0.018, z));
    let edge = [
        (-STEP, -0.3),
        (0.3, -0.3),
        (0.3, -0.02),
        (0.15 - STEP, -0.005),
        (0.03 - STEP, -0.012),
        (-STEP, -0.05),
    ];
    faces.extend(&mitred_ring(COURT, &edge.map(|(x, y)| Vec2::new(x, y))));
    faces.extend(&rectangle_ring(COURT, 0.2, -0.31, 5.9, -0.016));
    faces
}

/// Paves what lies between two rectangles about the origin, as four strips.
fn pave_ring(part: &mut Part, inner: Vec2, outer: Vec2, level: f32, random: &mut Random) {
    for sign in [-1.0, 1.0] {
        let span = |a: f32, b: f32| if sign < 0.0 { (-b, -a) } else { (a, b) };
        let (near, far) = span(inner.y, outer.y);
        pave(part, Vec2::new(-outer.x, near), Vec2::new(outer.x, far), level, random);
        let (left, right) = span(inner.x, outer.x);
        pave(part, Vec2::new(left, -inner.y), Vec2::new(right, inner.y), level, random);
    }
}

/// Paves a rectangle (x, z) with bevelled slabs whose tops lie up to four millimetres below `level`.
fn pave(part: &mut Part, min: Vec2, max: Vec2, level: f32, random: &mut Random) {
    let size = max - min;
    let count = (size / SLAB).round().max(Vec2::ONE);
    let cell = size / count;
    let joint = 0.014;
    let slab = chamfered_block(cell.x - joint, cell.y - joint, 0.05, 0.008).flat();
    let up = Affine3A::from_rotation_x(-FRAC_PI_2);
    for row in 0..count.y as usize {
        for column in 0..count.x as usize {
            let centre = min + cell * (Vec2::new(column as f32, row as f32) + 0.5);
            let top = level - random.between(0.0, 0.004);
            let at = Affine3A::from_translation(Vec3::new(centre.x, top - 0.05, centre.y));
            part.place(&slab, &(at * up));
        }
    }
}

/// Timbers under the gallery's ceiling, from the arcade to the outer wall.
fn beams() -> Part {
    let mut part = Part::default();
    for side in Side::all() {
        let beam = |half_width: f32, low: f32| {
            let (near, far) = (-side.depth - 0.1, 0.1);
            cuboid(Vec3::new(-half_width, low, near), Vec3::new(half_width, CEILING + 0.05, far)).flat()
        };
        let (main, joist) = (beam(0.13, CEILING - 0.28), beam(0.06, CEILING - 0.12));
        side.inner_columns(2).for_each(|x| part.place(&main, &side.at(x, 0.0, 0.0)));
        let step = 0.5 * BAY;
        for panel in 0..2 * side.bays {
            let middle = (panel as f32 + 0.5) * step - side.half_length();
            for shift in [-0.33, 0.0, 0.33] {
                part.place(&joist, &side.at(middle + shift, 0.0, 0.0));
            }
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn floors_are_closed_and_paving_fills_its_rectangle() {
        assert_closed(&ground().flat(), "ground");
        assert_sound(&ground().flat(), "ground");
        assert_closed(&beams(), "beams");
        let mut part = Part::default();
        pave(&mut part, Vec2::new(-2.0, 1.0), Vec2::new(3.0, 4.0), 1.0, &mut Random::new(0));
        assert_closed(&part, "paving");
        assert_sound(&part, "paving");
        let area = |y: f32| -> f32 {
            let flat = part.triangles.iter().map(|t| t.map(|v| part.positions[v as usize]));
            flat.filter(|t| t.iter().all(|p| p.y > y)).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).y).sum()
        };
        let covered = area(1.0 - 0.0045) / 15.0;
        assert!((0.9..0.98).contains(&covered), "slabs cover {covered}");
    }
}
