//! Columns: turned shafts on square plinths, with leaves on the lower capitals.

use super::plan::{LOWER_SPRINGING, PEDESTAL_TOP, Side, UPPER_SPRINGING, corners};
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::part::{Part, USUAL_CREASE_DEG};
use crate::builtin::shapes::{Profile, cuboid, lathe};
use conray_core::{Affine3A, Vec3};
use std::f32::consts::{PI, TAU};

/// Adds the columns of both storeys.
pub(crate) fn add(assembly: &mut Assembly, stone: u32) {
    let (lower_column, upper_column) = (lower_column(), upper_column());
    let (mut lower, mut upper) = (Part::default(), Part::default());
    for side in Side::all() {
        side.inner_columns(1).for_each(|x| lower.place(&lower_column, &side.at(x, 0.0, 0.0)));
        side.inner_columns(2).for_each(|x| upper.place(&upper_column, &side.at(x, PEDESTAL_TOP, 0.0)));
    }
    for corner in corners() {
        lower.place(&lower_column, &Affine3A::from_translation(corner));
        upper.place(&upper_column, &Affine3A::from_translation(corner + PEDESTAL_TOP * Vec3::Y));
    }
    assembly.add("lower columns", lower, stone);
    assembly.add("upper columns", upper, stone);
}

/// A square slab about the y axis.
fn slab(half_width: f32, from: f32, to: f32) -> Faces {
    cuboid(Vec3::new(-half_width, from, -half_width), Vec3::new(half_width, to, half_width))
}

/// A column of the arcade, from the ground to the springing of its arches.
fn lower_column() -> Part {
    let turned = Profile::from_disc(0.42, 0.18)
        .torus(0.035, 0.34, 5)
        .to(0.385, 0.37)
        .spline(&[(0.365, 0.41), (0.375, 0.45)], 2)
        .torus(0.03, 0.53, 4)
        .to(0.345, 0.56)
        // Entasis: the shaft narrows faster the higher it gets.
        .spline(&[(0.342, 1.4), (0.325, 2.5), (0.295, 3.4)], 2)
        .torus(0.03, 3.47, 3)
        .to(0.275, 3.5)
        .flare(0.38, 4.06, 5)
        .ending_on_axis();
    let mut faces = slab(0.44, -0.1, 0.2);
    faces.extend(&lathe(&turned, 20));
    faces.extend(&slab(0.395, 4.03, 4.12));
    faces.extend(&slab(0.435, 4.1, LOWER_SPRINGING + 0.03));
    for i in 0..8 {
        let turn = TAU * i as f32 / 8.0;
        faces.extend(&capital_leaf(0.285, 0.36, 3.5, 0.11).transformed(&Affine3A::from_rotation_y(turn)));
        // The upper leaves stand between the lower ones; every second reaches for a corner of the abacus.
        let reach = if i % 2 == 0 { 0.19 } else { 0.1 };
        let between = Affine3A::from_rotation_y(turn + PI / 4.0);
        faces.extend(&capital_leaf(0.31, 0.5, 3.56, reach).transformed(&between));
    }
    faces.smooth(50.0)
}

/// A leaf that rises `height` from the bell at `radius` and curls outwards by `curl` at its tip; a single sheet about +x.
fn capital_leaf(radius: f32, height: f32, foot: f32, curl: f32) -> Faces {
    Faces::sheet(3, 5, |u, v| {
        let across = 2.0 * u - 1.0;
        let half_width = 0.105 * (1.0 - (1.7 * v - 0.75).abs().powi(3)).max(0.12);
        // Up along the bell, then over: the last third turns through more than a right angle.
        let over = ((v - 0.6) / 0.4).max(0.0);
        let outward = radius + 0.05 * v * v + curl * over * (2.0 - over) - 0.03 * across * across;
        let up = foot + height * (v.min(0.6) + 0.4 * (over * 2.3).sin() / 1.35);
        Vec3::new(outward, up, -across * half_width)
    })
}

/// A column of the gallery, from y = 0 to the springing of its arches.
fn upper_column() -> Part {
    let height = UPPER_SPRINGING - PEDESTAL_TOP;
    let turned = Profile::from_disc(0.17, 0.07)
        .torus(0.025, 0.15, 3)
        .to(0.152, 0.18)
        .spline(&[(0.15, 0.7), (0.128, height - 0.36)], 2)
        .torus(0.02, height - 0.31, 3)
        .to(0.122, height - 0.28)
        .spline(&[(0.135, height - 0.2), (0.2, height - 0.11)], 3)
        .ending_on_axis();
    let mut faces = slab(0.2, -0.04, 0.09);
    faces.extend(&lathe(&turned, 13));
    faces.extend(&slab(0.215, height - 0.13, height + 0.02));
    faces.smooth(USUAL_CREASE_DEG)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_sound, open_edges};

    #[test]
    fn columns_are_sound_and_only_leaves_are_sheets() {
        for (name, column) in [("lower column", lower_column()), ("upper column", upper_column())] {
            assert_sound(&column, name);
        }
        assert_eq!(open_edges(&upper_column()), 0);
        // A sheet of 3 x 5 has a rim of 16 edges.
        assert_eq!(open_edges(&lower_column()), 16 * 16);
    }
}
