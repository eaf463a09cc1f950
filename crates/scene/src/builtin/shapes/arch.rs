//! Walls with arched openings and the mouldings round them.

use super::{Ends, sweep};
use crate::builtin::faces::Faces;
use conray_core::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use std::f32::consts::PI;

/// One opening of an arcade: half an ellipse above the springing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArchBay {
    /// Middle of the opening along the wall.
    pub(crate) centre: f32,
    /// Half the clear width.
    pub(crate) half_width: f32,
    /// Height of the crown above the springing.
    pub(crate) rise: f32,
}

/// The lower edge of a wall from `from` to `to` that stands on its piers at height `springing` and leaps over the bays,
/// given from left to right: x grows strictly, `steps` per arch.
pub(crate) fn arcade_outline(
    from: f32,
    to: f32,
    springing: f32,
    bays: &[ArchBay],
    steps: usize,
) -> Vec<Vec2> {
    let mut outline = vec![Vec2::new(from, springing)];
    for bay in bays {
        for i in 0..=steps {
            let angle = PI * i as f32 / steps as f32;
            // The ends exactly at the springing, not at the sine of a rounded pi.
            let rise = if i == 0 || i == steps { 0.0 } else { bay.rise * angle.sin() };
            outline.push(Vec2::new(bay.centre - bay.half_width * angle.cos(), springing + rise));
        }
    }
    outline.push(Vec2::new(to, springing));
    outline
}

/// The closed wall above a lower edge (x strictly growing) up to height `top`, from `z.x` to `z.y`.
pub(crate) fn extruded_wall(lower: &[Vec2], top: f32, z: Vec2) -> Faces {
    let low = |i: usize, z: f32| lower[i].extend(z);
    let high = |i: usize, z: f32| Vec3::new(lower[i].x, top, z);
    let (back, front, last) = (z.x, z.y, lower.len() - 1);
    let mut faces = Faces::default();
    for (i, j) in (0..last).map(|i| (i, i + 1)) {
        faces.panel(low(i, front), low(j, front), high(j, front), high(i, front));
        faces.panel(low(j, back), low(i, back), high(i, back), high(j, back));
        faces.panel(low(i, back), low(j, back), low(j, front), low(i, front));
        faces.panel(high(i, front), high(j, front), high(j, back), high(i, back));
    }
    faces.panel(low(0, back), low(0, front), high(0, front), high(0, back));
    faces.panel(low(last, front), low(last, back), high(last, back), high(last, front));
    faces
}

/// A moulding round a bay's arch on the wall face at z = `face`; a profile point is (distance outside the opening,
/// distance before the face). The ends, at the springing, are capped.
pub(crate) fn moulding_round_arch(
    bay: ArchBay,
    springing: f32,
    face: f32,
    profile: &[Vec2],
    steps: usize,
) -> Faces {
    let frame = |i: usize| {
        let angle = PI * (1.0 - i as f32 / steps as f32);
        let (sin, cos) = if i == 0 || i == steps { (0.0, angle.cos().round()) } else { angle.sin_cos() };
        // Outward from an ellipse: its gradient.
        let outward = Vec3A::new(cos / bay.half_width, sin / bay.rise, 0.0).normalize();
        let centre = Vec3A::new(bay.centre + bay.half_width * cos, springing + bay.rise * sin, face);
        Affine3A {
            matrix3: Mat3A::from_cols(outward, Vec3A::Z, outward.cross(Vec3A::Z)),
            translation: centre,
        }
    };
    let frames: Vec<Affine3A> = (0..=steps).map(frame).collect();
    sweep(&frames, profile, Ends::Capped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, volume};

    #[test]
    fn a_wall_lacks_the_half_ellipses_of_its_bays() {
        let bay = |centre: f32| ArchBay { centre, half_width: 0.8, rise: 1.2 };
        let outline = arcade_outline(-2.0, 2.0, 1.0, &[bay(-1.0), bay(1.0)], 64);
        let wall = extruded_wall(&outline, 3.0, Vec2::new(-0.25, 0.25));
        assert_closed(&wall.flat(), "arcade wall");
        let expected = 0.5 * (4.0 * 2.0 - PI * 0.8 * 1.2);
        assert!((volume(&wall) - expected).abs() < 2e-3);
    }

    #[test]
    fn a_moulding_is_closed_and_stands_before_the_wall() {
        let bay = ArchBay { centre: 0.5, half_width: 1.0, rise: 1.0 };
        let profile = [Vec2::new(0.0, -0.1), Vec2::new(0.2, -0.1), Vec2::new(0.2, 0.1), Vec2::new(0.0, 0.1)];
        let moulding = moulding_round_arch(bay, 2.0, 3.0, &profile, 48);
        assert_closed(&moulding.flat(), "moulding");
        let expected = 0.2 * 0.5 * PI * (1.2f32.powi(2) - 1.0);
        assert!((volume(&moulding) - expected).abs() < 2e-3 * expected, "{}", volume(&moulding));
    }
}
