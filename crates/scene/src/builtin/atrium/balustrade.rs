//! The balustrade of the gallery, between the pedestals of its columns.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::part::{Part, USUAL_CREASE_DEG};
use crate::builtin::shapes::{Profile, cuboid, lathe, mitred_ring};
use conray_core::{Affine3A, Vec2, Vec3};

/// Adds balusters, rails and pedestals.
pub(crate) fn add(assembly: &mut Assembly, stone: u32) {
    let (baluster, pedestal) = (baluster(), pedestal());
    let mut part = Part::default();
    for side in Side::all() {
        side.inner_columns(2).for_each(|x| part.place(&pedestal, &side.at(x, GALLERY, 0.0)));
        let (panels, half) = (2 * side.bays, side.half_length());
        for panel in 0..panels {
            let middle = (panel as f32 + 0.5) * 0.5 * BAY - half;
            for i in 0..4 {
                part.place(&baluster, &side.at(middle + 0.27 * (i as f32 - 1.5), GALLERY, 0.0));
            }
        }
    }
    for corner in corners() {
        part.place(&pedestal, &Affine3A::from_translation(corner + GALLERY * Vec3::Y));
    }
    for rail in [&lower_rail()[..], &upper_rail()[..]] {
        part.add(&mitred_ring(COURT, rail).smooth(USUAL_CREASE_DEG));
    }
    assembly.add("balustrade", part, stone);
}

fn lower_rail() -> [Vec2; 6] {
    let y = GALLERY;
    [(-0.13, -0.03), (0.13, -0.03), (0.13, 0.1), (0.1, 0.14), (-0.1, 0.14), (-0.13, 0.1)]
        .map(|(x, up)| Vec2::new(x, y + up))
}

fn upper_rail() -> [Vec2; 8] {
    let y = GALLERY + 0.76;
    [
        (-0.09, 0.0),
        (0.09, 0.0),
        (0.15, 0.05),
        (0.16, 0.12),
        (0.12, 0.15),
        (-0.12, 0.15),
        (-0.16, 0.12),
        (-0.15, 0.05),
    ]
    .map(|(x, up)| Vec2::new(x, y + up))
}

/// A turned baluster between the rails, running into both.
fn baluster() -> Part {
    let profile = Profile::from_disc(0.07, 0.12)
        .to(0.07, 0.2)
        .spline(&[(0.045, 0.24), (0.085, 0.38), (0.04, 0.58), (0.038, 0.64)], 2)
        .to(0.065, 0.68)
        .to(0.065, 0.77)
        .ending_on_axis();
    lathe(&profile, 7).smooth(50.0)
}

fn pedestal() -> Part {
    let block =
        |half: f32, from: f32, to: f32| cuboid(Vec3::new(-half, from, -half), Vec3::new(half, to, half));
    let mut faces = block(0.19, -0.05, 0.95);
    faces.extend(&block(0.225, -0.04, 0.17));
    faces.extend(&block(0.23, 0.88, PEDESTAL_TOP - GALLERY));
    faces.flat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn balusters_and_pedestals_are_closed_and_sound() {
        for (name, part) in [("baluster", baluster()), ("pedestal", pedestal())] {
            assert_closed(&part, name);
            assert_sound(&part, name);
        }
    }
}
