//! Triangles against a bundle: three half-spaces through the origin.
//!
//! With corners a, b, c seen from the origin, a direction d passes inside where d . (b x c), d . (c x a) and d . (a x b) have
//! the sign of the volume a . (b x c), and meets the plane at t = volume / (their sum) (the signed-volume test; Segura and Feito,
//! "Algorithms to Test Ray-Triangle Intersection. Comparative Study", 2001).
//!
//! # What is certain
//!
//! Let m be the largest coordinate of the corners as seen from the origin, u = 2^-24, and d of length 1. The exact test of
//! `triangle.rs` decides by the signs of edge functions of rounded corners, and what is compared here are values of the same
//! rounded differences, so their rounding cancels. Its shear rounds each coordinate by up to 4 u m, of values up to 2 m, so its
//! edge functions, times |d_z| <= 1, are off by 32 u m^2. Here a component of a cross product errs by up to 4 u m^2, a value by
//! 4 sqrt(3) u m^2 and 9 u m^2 in its own sums: 16 u m^2. Together 48 u m^2; [`MARGIN`] is 64 u.
//!
//! Distances are compared with the exact test's, which starts from unrounded corners: the sum of the values errs by
//! 3 (16 + 7) u m^2, for which three margins are taken, the volume by 48 u m^3.

use super::boxes::HEIGHT_ROUNDING;
use super::directions::GROUPS;
use super::rays::Rays;
use crate::lanes::{Lanes, WIDTH, bits};
use crate::packet::Packet;
use conray_core::Vec3;
use fearless_simd::{Simd, f32x16, prelude::*};

/// Bound on the errors of half-space values, in units of m^2, and of the volume, in units of m^3.
const MARGIN: f32 = 64.0 / 16_777_216.0;

/// Least margin, far above what underflow can lose (`rays.rs` holds lengths between 1e-9 and 1e9).
const LEAST_MARGIN: f32 = 1e-30;

/// A packet as half-spaces.
pub(super) struct HalfSpaces {
    /// Normals opposite the corners, turned so that inside is positive: by corner, then axis.
    normals: [[Lanes; 3]; 3],
    /// Absolute volume, and the bound on its error.
    volume: Lanes,
    of_volume: Lanes,
    /// Margin of half-space values.
    margin: Lanes,
    /// Triangles that are not wholly below the surface.
    pub(super) possible: u32,
    /// Triangles whose volume's sign is certain.
    turned: u32,
    /// `t_max`, less and more some ulps.
    reach: [f32; 2],
}

/// Which of sixteen pairs of a ray and a triangle meet for certain, and for which the exact test must tell.
#[derive(Clone, Copy, Default)]
pub(super) struct Decided {
    pub(super) inside: u64,
    pub(super) unsure: u64,
}

type Vector<S> = [f32x16<S>; 3];

impl HalfSpaces {
    /// `used` has a bit for each triangle that there is.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, packet: &Packet, used: u32, rays: &Rays<'_>) -> Self {
        let p = &packet.corners;
        let (a, b, c) = (near(simd, &p[0], rays), near(simd, &p[1], rays), near(simd, &p[2], rays));
        let size = largest(&a).max(largest(&b)).max(largest(&c));
        let normal = rays.boxes.normal;
        let height = height(simd, &a, normal).max(height(simd, &b, normal)).max(height(simd, &c, normal));
        // The bound of boxes, with the largest coordinate in place of each.
        let rounding = f32x16::splat(simd, -HEIGHT_ROUNDING * normal.abs().element_sum()) * size;
        let possible = !bits(height.simd_lt(rounding)) & used;

        let n0 = cross(&b, &c);
        let volume = a[2].mul_add(n0[2], a[1].mul_add(n0[1], a[0] * n0[0]));
        let turn = f32x16::splat(simd, 1.0).copysign(volume);
        let a = times(&a, turn);
        let (n0, n1, n2) = (times(&n0, turn), cross(&c, &a), cross(&a, &b));
        let volume = volume.abs();
        let margin = (size * size * f32x16::splat(simd, MARGIN)).max(f32x16::splat(simd, LEAST_MARGIN));
        let of_volume = margin * size.max(f32x16::splat(simd, 1e-10));
        // Finite, so that it times zero is a number; t itself is compared with some ulps to spare.
        let t_max = rays.t_max.min(f32::MAX);
        Self {
            normals: [stored(&n0), stored(&n1), stored(&n2)],
            volume: Lanes::of(volume),
            of_volume: Lanes::of(of_volume),
            margin: Lanes::of(margin),
            possible,
            turned: bits(volume.simd_gt(of_volume)),
            reach: [t_max * (1.0 - 1e-6), t_max * (1.0 + 1e-6)],
        }
    }

    /// Sixteen triangles against one ray; bits stand for triangles.
    #[inline(always)]
    pub(super) fn met_by_ray<S: Simd>(&self, simd: S, direction: Vec3) -> Decided {
        let d = [direction.x, direction.y, direction.z].map(|x| f32x16::splat(simd, x));
        let n = &self.normals;
        let values = [
            along(&loaded(simd, &n[0]), &d),
            along(&loaded(simd, &n[1]), &d),
            along(&loaded(simd, &n[2]), &d),
        ];
        let (margin, turned) = (self.margin.load(simd), self.turned);
        let least = values[0].min(values[1]).min(values[2]);
        // Everything is worked out for every ray: branches that depend on it would often be mispredicted.
        let (ends_behind, ends_before) =
            self.ends(simd, &values, margin, self.volume.load(simd), self.of_volume.load(simd));
        let not_outside = bits(least.simd_ge(-margin)) & self.possible;
        let inside = not_outside & turned & bits(least.simd_gt(margin)) & ends_behind;
        let mut unsure = not_outside & turned & !inside & !ends_before;
        let edge_on = self.possible & !turned;
        if edge_on != 0 {
            let most = values[0].max(values[1]).max(values[2]);
            unsure |= edge_on & !(bits(least.simd_lt(-margin)) & bits(most.simd_gt(margin)));
        }
        Decided { inside: u64::from(inside), unsure: u64::from(unsure) }
    }

    /// All active rays against one triangle; bits stand for rays.
    #[inline(always)]
    pub(super) fn met_by_groups<S: Simd>(
        &self,
        simd: S,
        triangle: usize,
        rays: &Rays<'_>,
        active: u64,
    ) -> Decided {
        let n = &self.normals;
        let (n0, n1, n2) =
            (splat3(simd, &n[0], triangle), splat3(simd, &n[1], triangle), splat3(simd, &n[2], triangle));
        let margin = f32x16::splat(simd, self.margin.0[triangle]);
        let volume = f32x16::splat(simd, self.volume.0[triangle]);
        let of_volume = f32x16::splat(simd, self.of_volume.0[triangle]);
        let turned = self.turned >> triangle & 1 == 1;
        let mut decided = Decided::default();
        for group in 0..GROUPS {
            let here = (active >> (WIDTH * group) & 0xffff) as u32;
            if here == 0 {
                continue;
            }
            let d = loaded(simd, &rays.directions[group]);
            let values = [along(&n0, &d), along(&n1, &d), along(&n2, &d)];
            let least = values[0].min(values[1]).min(values[2]);
            let (inside, unsure);
            if turned {
                let here = bits(least.simd_ge(-margin)) & here;
                if here == 0 {
                    continue;
                }
                let (ends_behind, ends_before) = self.ends(simd, &values, margin, volume, of_volume);
                inside = here & bits(least.simd_gt(margin)) & ends_behind;
                unsure = here & !inside & !ends_before;
            } else {
                let most = values[0].max(values[1]).max(values[2]);
                (inside, unsure) = (0, here & !(bits(least.simd_lt(-margin)) & bits(most.simd_gt(margin))));
            }
            decided.inside |= u64::from(inside) << (WIDTH * group);
            decided.unsure |= u64::from(unsure) << (WIDTH * group);
        }
        decided
    }

    /// Where the ray certainly ends behind the plane, and where before it.
    #[inline(always)]
    fn ends<S: Simd>(
        &self,
        simd: S,
        values: &Vector<S>,
        margin: f32x16<S>,
        volume: f32x16<S>,
        of_volume: f32x16<S>,
    ) -> (u32, u32) {
        let sum = values[0] + values[1] + values[2];
        let three = margin * f32x16::splat(simd, 3.0);
        let behind = (f32x16::splat(simd, self.reach[0]) * (sum - three)).simd_gt(volume + of_volume);
        let before = (f32x16::splat(simd, self.reach[1]) * (sum + three)).simd_lt(volume - of_volume);
        (bits(behind), bits(before))
    }
}

#[inline(always)]
fn splat3<S: Simd>(simd: S, n: &[Lanes; 3], lane: usize) -> Vector<S> {
    [f32x16::splat(simd, n[0].0[lane]), f32x16::splat(simd, n[1].0[lane]), f32x16::splat(simd, n[2].0[lane])]
}

#[inline(always)]
fn loaded<S: Simd>(simd: S, n: &[Lanes; 3]) -> Vector<S> {
    [n[0].load(simd), n[1].load(simd), n[2].load(simd)]
}

#[inline(always)]
fn stored<S: Simd>(n: &Vector<S>) -> [Lanes; 3] {
    [Lanes::of(n[0]), Lanes::of(n[1]), Lanes::of(n[2])]
}

/// A corner seen from the origin.
#[inline(always)]
fn near<S: Simd>(simd: S, corner: &[Lanes; 3], rays: &Rays<'_>) -> Vector<S> {
    let o = rays.origin;
    [
        corner[0].load(simd) - f32x16::splat(simd, o.x),
        corner[1].load(simd) - f32x16::splat(simd, o.y),
        corner[2].load(simd) - f32x16::splat(simd, o.z),
    ]
}

#[inline(always)]
fn largest<S: Simd>(p: &Vector<S>) -> f32x16<S> {
    p[0].abs().max(p[1].abs()).max(p[2].abs())
}

#[inline(always)]
fn height<S: Simd>(simd: S, p: &Vector<S>, normal: Vec3) -> f32x16<S> {
    let (x, y, z) =
        (f32x16::splat(simd, normal.x), f32x16::splat(simd, normal.y), f32x16::splat(simd, normal.z));
    p[2].mul_add(z, p[1].mul_add(y, p[0] * x))
}

#[inline(always)]
fn along<S: Simd>(n: &Vector<S>, d: &Vector<S>) -> f32x16<S> {
    n[2].mul_add(d[2], n[1].mul_add(d[1], n[0] * d[0]))
}

#[inline(always)]
fn times<S: Simd>(p: &Vector<S>, factor: f32x16<S>) -> Vector<S> {
    [p[0] * factor, p[1] * factor, p[2] * factor]
}

#[inline(always)]
fn cross<S: Simd>(p: &Vector<S>, q: &Vector<S>) -> Vector<S> {
    [p[1].mul_sub(q[2], p[2] * q[1]), p[2].mul_sub(q[0], p[0] * q[2]), p[0].mul_sub(q[1], p[1] * q[0])]
}
