//! The walls over the columns, with their arches and archivolts.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::part::{Part, USUAL_CREASE_DEG};
use crate::builtin::shapes::{
    ArchBay, Profile, arcade_outline, cuboid, extruded_wall, lathe, moulding_round_arch,
};
use conray_core::{Affine3A, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Half the clear width of the lower arches.
pub(crate) const LOWER_RADIUS: f32 = 1.24;
/// Half the clear width of the upper arches.
pub(crate) const UPPER_RADIUS: f32 = 0.61;

/// Adds both storeys of arches and the closed bays at the ends of the court.
pub(crate) fn add(assembly: &mut Assembly, stone: u32) {
    let (mut lower, mut upper) = (Part::default(), Part::default());
    for side in Side::all() {
        lower.place(&lower_arcade(&side).smooth(USUAL_CREASE_DEG), &side.world_from_side);
        upper.place(&upper_arcade(&side).smooth(USUAL_CREASE_DEG), &side.world_from_side);
        if !side.is_long() {
            lower.place(&fountain_wall().flat(), &side.world_from_side);
        }
    }
    assembly.add("lower arches", lower, stone);
    assembly.add("upper arches", upper, stone);
}

/// Where the wall of a side ends: those of the long sides reach a little past the faces of the short ones, which end inside
/// them.
fn wall_end(side: &Side, half_thickness: f32) -> f32 {
    side.half_length() + if side.is_long() { half_thickness + 0.012 } else { 0.05 - half_thickness }
}

fn lower_arcade(side: &Side) -> Faces {
    let bays: Vec<ArchBay> = side
        .bay_centres()
        .map(|centre| ArchBay { centre, half_width: LOWER_RADIUS, rise: LOWER_RADIUS })
        .collect();
    let end = wall_end(side, LOWER_HALF_THICKNESS);
    let outline = arcade_outline(-end, end, LOWER_SPRINGING, &bays, 18);
    let mut faces =
        extruded_wall(&outline, GALLERY - 0.3, Vec2::new(-LOWER_HALF_THICKNESS, LOWER_HALF_THICKNESS));
    let profile = [
        (-0.0, -0.04),
        (0.0, 0.05),
        (0.06, 0.06),
        (0.09, 0.035),
        (0.2, 0.04),
        (0.23, 0.09),
        (0.27, 0.09),
        (0.27, -0.04),
    ]
    .map(|(out, before)| Vec2::new(out, before));
    for &bay in &bays {
        // A little outside the opening, so that its underside is not in one plane with the wall's.
        let moulding = ArchBay { half_width: bay.half_width + 0.03, rise: bay.rise + 0.03, ..bay };
        let ring = moulding_round_arch(moulding, LOWER_SPRINGING + 0.02, 0.0, &profile, 16);
        for turn in [0.0, std::f32::consts::PI] {
            let face = Affine3A::from_translation(bay.centre * Vec3::X)
                * Affine3A::from_rotation_y(turn)
                * Affine3A::from_translation(Vec3::new(-bay.centre, 0.0, LOWER_HALF_THICKNESS));
            faces.extend(&ring.transformed(&face));
        }
        faces.extend(&keystone().transformed(&Affine3A::from_translation(Vec3::new(
            bay.centre,
            LOWER_SPRINGING + LOWER_RADIUS,
            LOWER_HALF_THICKNESS,
        ))));
    }
    let roundel = roundel();
    for x in side.inner_columns(1) {
        let at = Affine3A::from_translation(Vec3::new(x, LOWER_SPRINGING + 1.14, LOWER_HALF_THICKNESS));
        faces.extend(&roundel.transformed(&at));
    }
    faces
}

/// A wedge at the crown of an arch, about the crown.
fn keystone() -> Faces {
    let (low, high) = (0.09, 0.14);
    let corner = |half: f32, y: f32, z: f32| [Vec3::new(-half, y, z), Vec3::new(half, y, z)];
    let rings = [
        (corner(low, -0.03, -0.05), corner(low, -0.03, 0.12)),
        (corner(high, 0.38, -0.05), corner(high, 0.38, 0.17)),
    ]
    .map(|([back_left, back_right], [front_left, front_right])| {
        vec![back_left, front_left, front_right, back_right]
    });
    crate::builtin::shapes::loft(&rings, crate::builtin::shapes::Ends::Capped)
}

/// A turned ornament facing +z, a little sunk into the wall.
fn roundel() -> Faces {
    let profile = Profile::from_disc(0.3, -0.04)
        .to(0.3, 0.03)
        .torus(0.025, 0.08, 3)
        .to(0.25, 0.085)
        .spline(&[(0.21, 0.03), (0.15, 0.025), (0.11, 0.08), (0.03, 0.12)], 2)
        .ending_on_axis();
    lathe(&profile, 16).transformed(&Affine3A::from_rotation_x(FRAC_PI_2))
}

fn upper_arcade(side: &Side) -> Faces {
    let step = 0.5 * BAY;
    let half = side.half_length();
    let bays: Vec<ArchBay> = (0..2 * side.bays)
        .map(|i| ArchBay {
            centre: (i as f32 + 0.5) * step - half,
            half_width: UPPER_RADIUS,
            rise: UPPER_RADIUS,
        })
        .collect();
    let end = wall_end(side, UPPER_HALF_THICKNESS);
    let outline = arcade_outline(-end, end, UPPER_SPRINGING, &bays, 12);
    let thickness = Vec2::new(-UPPER_HALF_THICKNESS, UPPER_HALF_THICKNESS);
    let mut faces = extruded_wall(&outline, EAVES + 0.1, thickness);
    let profile = [(0.0, -0.04), (0.0, 0.03), (0.08, 0.03), (0.1, 0.06), (0.13, 0.06), (0.13, -0.04)]
        .map(|(out, before)| Vec2::new(out, before));
    for &bay in &bays {
        let moulding = ArchBay { half_width: bay.half_width + 0.02, rise: bay.rise + 0.02, ..bay };
        faces.extend(&moulding_round_arch(
            moulding,
            UPPER_SPRINGING + 0.015,
            UPPER_HALF_THICKNESS,
            &profile,
            12,
        ));
    }
    faces
}

/// The wall that closes the middle bay of a short side below the springing; a relief hangs on it.
fn fountain_wall() -> Faces {
    let mut faces = cuboid(Vec3::new(-1.5, -0.2, -0.19), Vec3::new(1.5, 3.92, 0.17));
    faces.extend(&cuboid(Vec3::new(-1.45, 3.88, -0.24), Vec3::new(1.45, 4.05, 0.24)));
    faces.extend(&cuboid(Vec3::new(-1.46, -0.1, 0.1), Vec3::new(1.46, 0.55, 0.23)));
    for x in [-1.1, 1.1] {
        faces.extend(&cuboid(Vec3::new(x - 0.13, 0.5, 0.1), Vec3::new(x + 0.13, 3.9, 0.21)));
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn arcades_are_closed_and_sound() {
        let side = Side::all()[2];
        for (name, faces) in [
            ("lower arcade", lower_arcade(&side)),
            ("upper arcade", upper_arcade(&side)),
            ("fountain wall", fountain_wall()),
        ] {
            let part = faces.smooth(USUAL_CREASE_DEG);
            assert_closed(&part, name);
            assert_sound(&part, name);
        }
    }
}
