//! Boxes.

use crate::builtin::faces::Faces;
use conray_core::Vec3;

/// A closed box between two corners.
pub(crate) fn cuboid(min: Vec3, max: Vec3) -> Faces {
    let p = |x: usize, y: usize, z: usize| {
        let pick = |i: usize, axis: usize| if i == 0 { min[axis] } else { max[axis] };
        Vec3::new(pick(x, 0), pick(y, 1), pick(z, 2))
    };
    let mut faces = Faces::default();
    faces.panel(p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1));
    faces.panel(p(1, 0, 0), p(0, 0, 0), p(0, 1, 0), p(1, 1, 0));
    faces.panel(p(1, 0, 1), p(1, 0, 0), p(1, 1, 0), p(1, 1, 1));
    faces.panel(p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0));
    faces.panel(p(0, 1, 1), p(1, 1, 1), p(1, 1, 0), p(0, 1, 0));
    faces.panel(p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1));
    faces
}

/// A closed block of `width` by `height` about the origin, from z = 0 to z = `depth`, whose front edges are bevelled by
/// `chamfer` in all three directions: an ashlar, a floor slab, a door panel.
pub(crate) fn chamfered_block(width: f32, height: f32, depth: f32, chamfer: f32) -> Faces {
    let rectangle = |inset: f32, z: f32| {
        let (x, y) = (0.5 * width - inset, 0.5 * height - inset);
        [Vec3::new(-x, -y, z), Vec3::new(x, -y, z), Vec3::new(x, y, z), Vec3::new(-x, y, z)]
    };
    let (back, edge, front) =
        (rectangle(0.0, 0.0), rectangle(0.0, depth - chamfer), rectangle(chamfer, depth));
    let mut faces = Faces::default();
    for i in 0..4 {
        let j = (i + 1) % 4;
        faces.panel(back[i], back[j], edge[j], edge[i]);
        faces.panel(edge[i], edge[j], front[j], front[i]);
    }
    faces.panel(front[0], front[1], front[2], front[3]);
    faces.panel(back[3], back[2], back[1], back[0]);
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, volume};

    #[test]
    fn boxes_are_closed_and_have_their_volume() {
        let faces = cuboid(Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 3.0, 6.0));
        assert_closed(&faces.flat(), "cuboid");
        assert!((volume(&faces) - 24.0).abs() < 1e-4);
        let block = chamfered_block(2.0, 1.0, 0.5, 0.1);
        assert_closed(&block.flat(), "chamfered block");
        // A prism of height 0.4 below a frustum: (h / 6) (bottom + top + 4 middle).
        let frustum = 0.1 / 6.0 * (2.0 + 1.8 * 0.8 + 4.0 * 1.9 * 0.9);
        assert!((volume(&block) - (0.8 + frustum)).abs() < 1e-4);
    }
}
