//! The ground: rolling, with a trodden path.

use crate::builtin::faces::Faces;
use crate::builtin::part::Part;
use crate::builtin::random::value_noise;
use conray_core::{Vec2, Vec3};

/// The ground reaches to plus and minus this in x and z, in metres.
pub(crate) const REACH: f32 = 70.0;
/// Quadrilaterals along one side of the ground.
const CELLS: usize = 180;

/// Where the path crosses a line of constant z.
pub(crate) fn path_x(z: f32) -> f32 {
    4.0 * (z / 15.0).sin() + 1.6 * (z / 6.1 + 1.0).sin()
}

/// Distance from the middle of the path, about (measured along x).
pub(crate) fn path_distance(x: f32, z: f32) -> f32 {
    (x - path_x(z)).abs()
}

/// Height of the ground in metres.
pub(crate) fn height(x: f32, z: f32) -> f32 {
    let p = Vec2::new(x, z);
    let hills = 1.9 * value_noise(p / 24.0, 1) + 0.6 * value_noise(p / 9.0, 2);
    let bumps = 0.10 * value_noise(p / 2.3, 3) + 0.05 * value_noise(p / 1.1, 4);
    // Trodden ground is smoother and lies lower.
    let trodden = (-(path_distance(x, z) / 1.1).powi(2)).exp();
    hills + bumps * (1.0 - 0.7 * trodden) - 0.22 * trodden
}

/// The ground as a single sheet that faces up.
pub(crate) fn mesh() -> Part {
    let sheet = Faces::sheet(CELLS, CELLS, |u, v| {
        let (x, z) = (REACH * (2.0 * u - 1.0), REACH * (1.0 - 2.0 * v));
        Vec3::new(x, height(x, z), z)
    });
    sheet.smooth(80.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::assert_sound;

    #[test]
    fn the_ground_faces_up_and_is_gentle() {
        let ground = mesh();
        assert_eq!(ground.triangles.len(), 2 * CELLS * CELLS);
        assert_sound(&ground, "ground");
        let steepest = ground.normals.iter().map(|n| n.y).fold(1.0, f32::min);
        assert!(steepest > 0.7, "the steepest normal has y = {steepest}");
        assert!(ground.positions.iter().all(|p| p.y.abs() < 4.0));
    }

    #[test]
    fn the_path_lies_lower_than_its_banks() {
        let steps = 200;
        let drop = |z: f32| {
            let x = path_x(z);
            0.5 * (height(x - 3.0, z) + height(x + 3.0, z)) - height(x, z)
        };
        let mean = (0..steps).map(|i| drop(i as f32 * 0.6 - 60.0)).sum::<f32>() / steps as f32;
        assert!((0.1..0.4).contains(&mean), "on average {mean} deep");
    }
}
