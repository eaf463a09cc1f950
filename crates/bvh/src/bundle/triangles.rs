//! Triangles against a bundle: three half-spaces through the origin.
//!
//! With corners a, b, c seen from the origin, a direction d passes inside where d . (b x c), d . (c x a) and d . (a x b) have
//! the sign of the volume a . (b x c), and meets the plane at t = volume / (their sum) (the signed-volume test; Segura and Feito,
//! "Algorithms to Test Ray-Triangle Intersection. Comparative Study", 2001).
//!
//! # What is certain
//!
//! Let m be the largest coordinate of the corners and u = 2^-24. Corners err by u m; a cross product's component, two products
//! of such, by 2 (2 + 2) u m^2 and some; with d of length 1 a half-space value errs by less than 24 u m^2, their sum by
//! 72 u m^2, the volume by 40 u m^3. The exact test decides on rounded sheared corners, whose edge functions err by
//! 28 u m^2 times at most 3 (`triangle.rs`, with |d_z| at least 1 / sqrt 3). [`MARGIN`] covers both together.

use super::rays::{GROUPS, Rays};
use crate::packet::Packet;
use fearless_simd::{Simd, f32x16, prelude::*};
use glam::Vec4;

/// Bound on the errors of half-space values, in units of m^2; of the volume, of m^3. 256 u.
const MARGIN: f32 = 256.0 / 16_777_216.0;

/// Least margin, far above what underflow can lose: lengths are near 1 (`Rays::unit`).
const LEAST_MARGIN: f32 = 1e-30;

/// Four triangles as half-spaces.
pub(super) struct HalfSpaces {
    /// Normals opposite the corners, turned so that inside is positive: by corner, then axis.
    normals: [[Vec4; 3]; 3],
    /// Absolute volume, in units of `Rays::unit`.
    volume: Vec4,
    /// Margin of half-space values; of the volume it is `margin * size`.
    margin: Vec4,
    size: Vec4,
}

/// Which rays of a bundle a triangle blocks for certain, and for which the exact test must tell.
#[derive(Clone, Copy, Default)]
pub(super) struct Decided {
    pub(super) inside: u64,
    pub(super) unsure: u64,
}

impl HalfSpaces {
    #[inline(always)]
    pub(super) fn new(packet: &Packet, rays: &Rays) -> Self {
        let p = &packet.corners;
        let (a, b, c) = (near(&p[0], rays), near(&p[1], rays), near(&p[2], rays));
        let (n0, n1, n2) = (cross(&b, &c), cross(&c, &a), cross(&a, &b));
        let volume = a[0] * n0[0] + a[1] * n0[1] + a[2] * n0[2];
        let turn = Vec4::ONE.copysign(volume);
        let size = largest(&a).max(largest(&b)).max(largest(&c));
        Self {
            normals: [times(&n0, turn), times(&n1, turn), times(&n2, turn)],
            volume: volume.abs(),
            margin: (size * size * MARGIN).max(Vec4::splat(LEAST_MARGIN)),
            size,
        }
    }

    /// Tests the active rays against one triangle.
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, lane: usize, rays: &Rays, active: u64) -> Decided {
        // Written out: a closure would not be compiled for the level of SIMD that this function is.
        let lane = lane & 3;
        let n = &self.normals;
        let (ex, ey, ez) = splat3(simd, &n[0], lane);
        let (fx, fy, fz) = splat3(simd, &n[1], lane);
        let (gx, gy, gz) = splat3(simd, &n[2], lane);
        let (margin, size, volume) = (self.margin[lane], self.size[lane], self.volume[lane]);
        let of_volume = margin * size.max(1e-10);
        // Where the volume's own sign is not certain, neither is the side of anything.
        let turned = volume > of_volume;
        // A length in units; t itself is compared with some ulps to spare.
        let t_max = (rays.t_max * rays.unit).min(f32::MAX);
        let (least_reach, most_reach) = (t_max * (1.0 - 1e-6), t_max * (1.0 + 1e-6));
        let (inner, outer) = (f32x16::splat(simd, margin), f32x16::splat(simd, -margin));
        let three = f32x16::splat(simd, 3.0 * margin);
        let mut decided = Decided::default();
        for group in 0..GROUPS {
            let here = active >> (16 * group) & 0xffff;
            if here == 0 {
                continue;
            }
            let d = &rays.direction[group];
            let dx = f32x16::from_slice(simd, &d[0].0);
            let dy = f32x16::from_slice(simd, &d[1].0);
            let dz = f32x16::from_slice(simd, &d[2].0);
            let e = ez.mul_add(dz, ey.mul_add(dy, ex * dx));
            let f = fz.mul_add(dz, fy.mul_add(dy, fx * dx));
            let g = gz.mul_add(dz, gy.mul_add(dy, gx * dx));
            let least = e.min(f).min(g);
            if turned {
                let not_outside = least.simd_ge(outer).to_bitmask() & here;
                if not_outside == 0 {
                    continue;
                }
                let sum = e + f + g;
                let before_end = (f32x16::splat(simd, least_reach) * (sum - three))
                    .simd_gt(f32x16::splat(simd, volume + of_volume));
                let beyond = (f32x16::splat(simd, most_reach) * (sum + three))
                    .simd_lt(f32x16::splat(simd, volume - of_volume));
                let inside = least.simd_gt(inner).to_bitmask() & before_end.to_bitmask() & not_outside;
                let outside = beyond.to_bitmask();
                decided.inside |= inside << (16 * group);
                decided.unsure |= (not_outside & !inside & !outside) << (16 * group);
            } else {
                let most = e.max(f).max(g);
                let outside = least.simd_lt(outer).to_bitmask() & most.simd_gt(inner).to_bitmask();
                decided.unsure |= (here & !outside) << (16 * group);
            }
        }
        decided
    }
}

#[inline(always)]
fn splat3<S: Simd>(simd: S, n: &[Vec4; 3], lane: usize) -> (f32x16<S>, f32x16<S>, f32x16<S>) {
    (f32x16::splat(simd, n[0][lane]), f32x16::splat(simd, n[1][lane]), f32x16::splat(simd, n[2][lane]))
}

/// A corner seen from the origin, in units of [`Rays::unit`].
#[inline(always)]
fn near(corner: &[Vec4; 3], rays: &Rays) -> [Vec4; 3] {
    let (o, unit) = (rays.origin, rays.unit);
    [(corner[0] - o.x) * unit, (corner[1] - o.y) * unit, (corner[2] - o.z) * unit]
}

#[inline(always)]
fn largest(p: &[Vec4; 3]) -> Vec4 {
    p[0].abs().max(p[1].abs()).max(p[2].abs())
}

#[inline(always)]
fn times(p: &[Vec4; 3], factor: Vec4) -> [Vec4; 3] {
    [p[0] * factor, p[1] * factor, p[2] * factor]
}

#[inline(always)]
fn cross(p: &[Vec4; 3], q: &[Vec4; 3]) -> [Vec4; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}
