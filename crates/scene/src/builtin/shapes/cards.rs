//! Masked leaves: flat or bent pieces whose texture says where the leaf is.

use crate::builtin::faces::{Faces, corner};
use conray_core::Vec3;

/// A rectangle that carries a leaf texture from its stalk (v = 0) to its tip (v = 1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Card {
    /// Middle of the edge at the stalk.
    pub(crate) base: Vec3,
    /// From the base to the middle of the far edge.
    pub(crate) along: Vec3,
    /// From the middle to the right edge, seen from the front.
    pub(crate) right: Vec3,
    /// How far the left and right edges are lifted to the front, which folds the card along its middle; 0 keeps it flat.
    pub(crate) fold: f32,
}

impl Card {
    /// Adds the card: two triangles when flat, four when folded.
    pub(crate) fn add_to(&self, faces: &mut Faces) {
        let front = self.right.cross(self.along).normalize_or_zero() * self.fold;
        let at = |u: f32, v: f32, lift: Vec3| {
            corner(self.base + (2.0 * u - 1.0) * self.right + v * self.along + lift, u, v)
        };
        if self.fold == 0.0 {
            let z = Vec3::ZERO;
            faces.quad(at(0.0, 0.0, z), at(1.0, 0.0, z), at(1.0, 1.0, z), at(0.0, 1.0, z));
            return;
        }
        let (low, high) = (at(0.5, 0.0, Vec3::ZERO), at(0.5, 1.0, Vec3::ZERO));
        faces.quad(at(0.0, 0.0, front), low, high, at(0.0, 1.0, front));
        faces.quad(low, at(1.0, 0.0, front), at(1.0, 1.0, front), high);
    }
}

/// A strip of `steps` by 2 quadrilaterals that rises from `base` and bows over: a fern frond, a long leaf.
///
/// It starts `lift_rad` above the horizontal in the horizontal unit direction `outward` and bends down by `droop_rad` over its length;
/// its edges hang `sag` times the half width below its middle.
pub(crate) fn frond(
    base: Vec3,
    outward: Vec3,
    [length, half_width]: [f32; 2],
    [lift_rad, droop_rad]: [f32; 2],
    sag: f32,
    steps: usize,
) -> Faces {
    let across = outward.cross(Vec3::Y);
    let step = length / steps as f32;
    let mut spine = vec![base];
    for i in 0..steps {
        let angle = lift_rad - droop_rad * (i as f32 + 0.5) / steps as f32;
        spine.push(spine[i] + step * (angle.cos() * outward + angle.sin() * Vec3::Y));
    }
    Faces::sheet(2, steps, |u, v| {
        let side = 2.0 * u - 1.0;
        let i = (v * steps as f32).round() as usize;
        spine[i] + side * half_width * across - side.abs() * sag * half_width * Vec3::Y
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::assert_sound;

    #[test]
    fn cards_cover_their_texture_and_fold_to_the_front() {
        for (fold, triangles) in [(0.0, 2), (0.2, 4)] {
            let mut faces = Faces::default();
            Card { base: Vec3::ZERO, along: Vec3::Y, right: 0.5 * Vec3::X, fold }.add_to(&mut faces);
            assert_eq!(faces.triangles.len(), triangles);
            assert_sound(&faces.flat(), "card");
            let uv_area: f32 =
                faces.triangles.iter().map(|[a, b, c]| 0.5 * (b.uv - a.uv).perp_dot(c.uv - a.uv)).sum();
            assert!((uv_area - 1.0).abs() < 1e-6);
            let highest = faces.triangles.iter().flatten().map(|c| c.position.z).fold(0.0, f32::max);
            assert!((highest - fold).abs() < 1e-6);
        }
    }

    #[test]
    fn a_frond_has_its_length_and_bows_down() {
        let faces = frond(Vec3::Y, Vec3::X, [2.0, 0.2], [1.0, 1.5], 0.3, 6);
        assert_eq!(faces.triangles.len(), 24);
        assert_sound(&faces.smooth(60.0), "frond");
        let reach = faces.triangles.iter().flatten().map(|c| c.position.x).fold(0.0, f32::max);
        assert!(reach > 1.0 && reach < 2.0);
    }
}
