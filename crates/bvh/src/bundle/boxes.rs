//! Boxes against a bundle: four children for the cheap tests, sixteen rays for the tight one.

use super::rays::{GROUPS, Rays};
use crate::{node::Node, ray::Slab};
use fearless_simd::{Simd, f32x16, prelude::*};
use glam::Vec4;

/// Grows what is compared with a sum of three rounded products; far more than its rounding.
const ROUNDING: f32 = 1e-5;

/// The boxes of a node, moved to the origin.
pub(super) struct NearBoxes {
    /// By axis: lowest and highest planes of the four children.
    planes: [[Vec4; 2]; 3],
    /// Squared distance of each box from the origin.
    pub(super) distance: Vec4,
    /// Children that some ray may reach.
    pub(super) reachable: u32,
}

impl NearBoxes {
    #[inline(always)]
    pub(super) fn new(node: &Node, rays: &Rays) -> Self {
        let (x, y, z) = (Vec4::splat(rays.origin.x), Vec4::splat(rays.origin.y), Vec4::splat(rays.origin.z));
        let p = &node.planes;
        let (low_x, high_x) = (p[0][0] - x, p[0][1] - x);
        let (low_y, high_y) = (p[1][0] - y, p[1][1] - y);
        let (low_z, high_z) = (p[2][0] - z, p[2][1] - z);
        let gap_x = low_x.max(-high_x).max(Vec4::ZERO);
        let gap_y = low_y.max(-high_y).max(Vec4::ZERO);
        let gap_z = low_z.max(-high_z).max(Vec4::ZERO);
        let distance = gap_x * gap_x + gap_y * gap_y + gap_z * gap_z;
        let n = rays.normal;
        let height = (low_x * n.x).max(high_x * n.x)
            + (low_y * n.y).max(high_y * n.y)
            + (low_z * n.z).max(high_z * n.z);
        let size =
            low_x.abs().max(high_x.abs()) + low_y.abs().max(high_y.abs()) + low_z.abs().max(high_z.abs());
        let planes = [[low_x, high_x], [low_y, high_y], [low_z, high_z]];
        // Beyond the reach of every ray, or wholly below the surface. An unused slot is an empty box: its distance is
        // infinite or NaN.
        let limit = rays.t_max * rays.t_max * (1.0 + ROUNDING);
        let near = distance.cmple(Vec4::splat(limit));
        let above = (height + size * ROUNDING).cmpge(Vec4::ZERO);
        Self { planes, distance, reachable: (near & above).bitmask() }
    }

    /// The active rays that meet the box of a child.
    #[inline(always)]
    pub(super) fn met_by<S: Simd>(&self, simd: S, child: usize, rays: &Rays, active: u64) -> u64 {
        // Written out: a closure would not be compiled for the level of SIMD that this function is.
        let child = child & 3;
        let p = &self.planes;
        let low_x = f32x16::splat(simd, p[0][0][child]);
        let high_x = f32x16::splat(simd, p[0][1][child]);
        let low_y = f32x16::splat(simd, p[1][0][child]);
        let high_y = f32x16::splat(simd, p[1][1][child]);
        let low_z = f32x16::splat(simd, p[2][0][child]);
        let high_z = f32x16::splat(simd, p[2][1][child]);
        let zero = f32x16::splat(simd, 0.0);
        let t_max = f32x16::splat(simd, rays.t_max);
        let grown = f32x16::splat(simd, Slab::FAR);
        let mut met = 0;
        for group in 0..GROUPS {
            let here = active >> (16 * group) & 0xffff;
            if here == 0 {
                continue;
            }
            let inverse = &rays.inverse[group];
            let ix = f32x16::from_slice(simd, &inverse[0].0);
            let iy = f32x16::from_slice(simd, &inverse[1].0);
            let iz = f32x16::from_slice(simd, &inverse[2].0);
            let (ax, bx) = (low_x * ix, high_x * ix);
            let (ay, by) = (low_y * iy, high_y * iy);
            let (az, bz) = (low_z * iz, high_z * iz);
            let near = ax.min(bx).max(ay.min(by)).max(az.min(bz)).max(zero);
            let far = ax.max(bx).min(ay.max(by)).min(az.max(bz)) * grown;
            let hit = near.simd_le(far.min(t_max));
            met |= (hit.to_bitmask() & here) << (16 * group);
        }
        met
    }
}
