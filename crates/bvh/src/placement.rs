//! Where a mesh's corners lie in the world: one formula, rounded the same way everywhere.
//!
//! World space corners **are** the scene: whatever rounding they carry is no error but the geometry itself. So the
//! flattened tree, the instanced one (which places corners anew at every triangle test), [`crate::Bvh::surface_point`]
//! and the bounds must agree to the last bit, and they do because they all compute
//! `((x_axis * p.x + y_axis * p.y) + z_axis * p.z) + translation` in single precision, in this order.

use crate::{lanes::Lanes, packet::Packet};
use conray_core::{Affine3A, Vec3};
use fearless_simd::{Simd, f32x16, prelude::*};
use glam::{DMat3, DVec3};

/// World position of a mesh vertex.
#[inline]
pub(crate) fn world_corner(world_from_mesh: &Affine3A, p: Vec3) -> Vec3 {
    let m = &world_from_mesh.matrix3;
    (((m.x_axis * p.x + m.y_axis * p.y) + m.z_axis * p.z) + world_from_mesh.translation).into()
}

/// [`world_corner`] for the corners of a packet.
#[inline(always)]
pub(crate) fn world_packet<S: Simd>(simd: S, world_from_mesh: &Affine3A, packet: &Packet) -> Packet {
    let m = &world_from_mesh.matrix3;
    let mut placed = Packet { corners: [[Lanes::ZERO; 3]; 3] };
    for corner in 0..3 {
        let [x, y, z] = &packet.corners[corner];
        let (x, y, z) = (x.load(simd), y.load(simd), z.load(simd));
        for axis in 0..3 {
            let (ax, ay) = (f32x16::splat(simd, m.x_axis[axis]), f32x16::splat(simd, m.y_axis[axis]));
            let (az, at) =
                (f32x16::splat(simd, m.z_axis[axis]), f32x16::splat(simd, world_from_mesh.translation[axis]));
            placed.corners[corner][axis] = Lanes::of(((x * ax + y * ay) + z * az) + at);
        }
    }
    placed
}

/// The transform in double precision.
pub(crate) fn wide_matrix(world_from_mesh: &Affine3A) -> (DMat3, DVec3) {
    let m = &world_from_mesh.matrix3;
    let axes = [m.x_axis, m.y_axis, m.z_axis].map(|a| Vec3::from(a).as_dvec3());
    (DMat3::from_cols(axes[0], axes[1], axes[2]), Vec3::from(world_from_mesh.translation).as_dvec3())
}

/// Elementwise absolute values.
pub(crate) fn abs_matrix(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn packets_are_placed_as_single_corners_are(m in prop::array::uniform12(-1e3f32..1e3), p in prop::array::uniform9(-1e3f32..1e3)) {
            let transform = Affine3A::from_cols_array(&m);
            let corners = [0, 1, 2].map(|i| Vec3::from_slice(&p[3 * i..]));
            let packet = Packet::new(1, |_| corners);
            let level = fearless_simd::Level::new();
            let placed = fearless_simd::dispatch!(level, simd => world_packet(simd, &transform, &packet));
            for lane in 0..16 {
                prop_assert_eq!(placed.lane(lane), corners.map(|c| world_corner(&transform, c)));
            }
        }
    }
}
