//! Where things are: the measures of the building in metres and the coordinates of its four sides.

use conray_core::{Affine3A, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// Distance from column to column in the lower storey; the upper storey has two columns for one.
pub(crate) const BAY: f32 = 3.2;
/// Half the court between the axes of its columns, in x and z.
pub(crate) const COURT: Vec2 = Vec2::new(4.0 * BAY, 1.5 * BAY);
/// Half the space between the outer walls, in x and z.
pub(crate) const INSIDE: Vec2 = Vec2::new(18.0, 10.4);

/// Height at which the lower arches spring from their capitals.
pub(crate) const LOWER_SPRINGING: f32 = 4.25;
/// Height of the gallery's floor.
pub(crate) const GALLERY: f32 = 6.4;
/// Height at which the upper columns stand on their pedestals.
pub(crate) const PEDESTAL_TOP: f32 = GALLERY + 0.98;
/// Height at which the upper arches spring.
pub(crate) const UPPER_SPRINGING: f32 = 9.4;
/// Underside of the gallery's ceiling.
pub(crate) const CEILING: f32 = 10.7;
/// Underside of the eaves.
pub(crate) const EAVES: f32 = 12.4;

/// Half the thickness of the lower and upper arcade walls.
pub(crate) const LOWER_HALF_THICKNESS: f32 = 0.31;
pub(crate) const UPPER_HALF_THICKNESS: f32 = 0.22;

/// One side of the court, with coordinates of its own: x along the columns, y up, z towards the court; the origin is on the
/// ground in the middle of the row of columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// From the side's coordinates to the world.
    pub(crate) world_from_side: Affine3A,
    /// Number of lower bays.
    pub(crate) bays: usize,
    /// Distance from the columns' axis back to the outer wall.
    pub(crate) depth: f32,
}

impl Side {
    /// Both long sides, then both short ones.
    pub(crate) fn all() -> [Self; 4] {
        let side = |turn: f32, distance: f32, bays: usize, depth: f32| Self {
            world_from_side: Affine3A::from_rotation_y(turn)
                * Affine3A::from_translation(Vec3::NEG_Z * distance),
            bays,
            depth,
        };
        let (long, short) = (INSIDE.y - COURT.y, INSIDE.x - COURT.x);
        [
            side(0.0, COURT.y, 8, long),
            side(PI, COURT.y, 8, long),
            side(FRAC_PI_2, COURT.x, 3, short),
            side(-FRAC_PI_2, COURT.x, 3, short),
        ]
    }

    /// True for the sides along x.
    pub(crate) fn is_long(&self) -> bool {
        self.bays == 8
    }

    /// Half the length between the corner columns.
    pub(crate) fn half_length(&self) -> f32 {
        0.5 * BAY * self.bays as f32
    }

    /// Middles of the lower bays.
    pub(crate) fn bay_centres(&self) -> impl Iterator<Item = f32> + use<> {
        let (bays, half) = (self.bays, self.half_length());
        (0..bays).map(move |i| (i as f32 + 0.5) * BAY - half)
    }

    /// Places of the lower columns (`per_bay` 1) or the upper ones (2), without the corners.
    pub(crate) fn inner_columns(&self, per_bay: usize) -> impl Iterator<Item = f32> + use<> {
        let (count, half, step) = (self.bays * per_bay, self.half_length(), BAY / per_bay as f32);
        (1..count).map(move |i| i as f32 * step - half)
    }

    /// The world transform of something made about its own origin, moved to (x, y, z) of the side.
    pub(crate) fn at(&self, x: f32, y: f32, z: f32) -> Affine3A {
        self.world_from_side * Affine3A::from_translation(Vec3::new(x, y, z))
    }
}

/// The four corners of the court on the columns' axes.
pub(crate) fn corners() -> [Vec3; 4] {
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(x, z)| Vec3::new(x * COURT.x, 0.0, z * COURT.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_meet_at_the_corners_and_look_into_the_court() {
        for side in Side::all() {
            for end in [-1.0, 1.0] {
                let corner = side.at(end * side.half_length(), 0.0, 0.0).translation;
                assert!(corners().iter().any(|c| c.distance(corner.into()) < 1e-5), "{corner} is no corner");
            }
            let (on_axis, before) = (side.at(0.0, 0.0, 0.0).translation, side.at(0.0, 0.0, 1.0).translation);
            assert!(before.length() < on_axis.length(), "z points into the court");
            assert_eq!(side.bay_centres().count(), side.bays);
            assert_eq!(side.inner_columns(2).count(), 2 * side.bays - 1);
        }
    }
}
