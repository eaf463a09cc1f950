//! The triangle test: watertight, two-sided, and exact in the last resort.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013: corners are moved to the ray's origin and
//! sheared so that the ray becomes the z axis; the signs of three edge functions then say whether it passes inside.
//! Triangles that share an edge see the same rounded corners and negated edge functions, so no ray slips between them.
//!
//! Two stages differ from the paper.
//!
//! 1. [`candidates`] evaluates sixteen triangles in single precision. A rounded edge function has the right sign or is
//!    zero, because rounding is monotonic; a triangle is dropped only where two functions have opposite signs, or
//!    where it lies wholly behind the origin or beyond the cut.
//! 2. [`crossing`] settles the few that remain, in double precision. The edge functions of the *rounded* corners are
//!    exact in their signs there (products of two 24-bit numbers). A function that is exactly zero belongs to one
//!    of the two triangles at its edge by a rasteriser's fill rule, so a ray through an edge or a corner of a surface
//!    meets it exactly once, and fractional opacity is not counted twice. Distance and barycentrics are then computed
//!    afresh from the unrounded differences; where these put the ray just outside (it passes within rounding of an
//!    edge), the nearest point of the projected outline is taken, so that `t` stays within the triangle's depths.
//!
//! # Which hits are in front
//!
//! A hit counts for `t > delta`, with `delta` a bound on the error of `t` in *double* precision. With m the largest
//! coordinate of the sheared corners and u = 2^-53, a sheared coordinate errs by at most 6 u m, an edge function by
//! 2 (2 * 6 + 1) u m^2 + 2 u m^2 = 28 u m^2, and `t`, a mean of depths up to m weighted by three edge functions, by
//! 3 * 28 u m^3 / det and some roundings: 96 u m^3 / (det |d_z|) (after Pharr, Jakob, Humphreys, "Physically Based
//! Rendering", 4th ed., 2023, 6.8.8). It is a billionth of what single precision would need, so nothing real is
//! rejected: a wall is seen from any distance that a surface point's own uncertainty allows.
//!
//! # Why a surface does not hit itself
//!
//! A ray that starts a height h above its own triangle's plane and does not descend stays above it. Sheared single
//! precision corners err by at most 6 u r per coordinate with u = 2^-24 and r the triangle's reach from the origin, so
//! the first stage errs only where the ray passes within 6 sqrt(2) u r of the triangle; points of it in front of the
//! origin are further away than h. [`crate::position_error`] makes h exceed that.

use crate::lanes::{Lanes, bits};
use crate::packet::Packet;
use crate::ray::PreparedRay;
use conray_core::{Vec2, Vec3};
use fearless_simd::{Simd, f32x16, prelude::*};
use glam::{DVec2, DVec3};

/// Where a ray crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// Distance along the ray, above 0.
    pub(crate) t: f32,
    /// Barycentric weight of corner 1, in [0, 1].
    pub(crate) u: f32,
    /// Barycentric weight of corner 2, in [0, 1].
    pub(crate) v: f32,
}

/// Which of a packet's triangles the ray may cross with `0 < t <= cut`; bit i stands for lane i. Never misses one.
#[inline(always)]
pub(crate) fn candidates<S: Simd>(simd: S, packet: &Packet, ray: &PreparedRay, cut: f32) -> u32 {
    let (ax, ay, at) = sheared(simd, &packet.corners[0], ray);
    let (bx, by, bt) = sheared(simd, &packet.corners[1], ray);
    let (cx, cy, ct) = sheared(simd, &packet.corners[2], ray);
    let u = cx * by - cy * bx;
    let v = ax * cy - ay * cx;
    let w = bx * ay - by * ax;
    let zero = f32x16::splat(simd, 0.0);
    let outside = bits(u.min(v).min(w).simd_lt(zero)) & bits(u.max(v).max(w).simd_gt(zero));
    let behind = bits(at.max(bt).max(ct).simd_le(zero));
    let beyond = bits(at.min(bt).min(ct).simd_gt(f32x16::splat(simd, cut)));
    !(outside | behind | beyond) & 0xffff
}

/// A corner of each triangle, sheared: x, y and the distance along the ray.
#[inline(always)]
fn sheared<S: Simd>(simd: S, corner: &[Lanes; 3], ray: &PreparedRay) -> (f32x16<S>, f32x16<S>, f32x16<S>) {
    let [kx, ky, kz] = ray.axes;
    let [sx, sy, sz] = ray.shear;
    let z = corner[kz].load(simd) - f32x16::splat(simd, ray.origin[kz]);
    let x = (corner[kx].load(simd) - f32x16::splat(simd, ray.origin[kx])) - f32x16::splat(simd, sx) * z;
    let y = (corner[ky].load(simd) - f32x16::splat(simd, ray.origin[ky])) - f32x16::splat(simd, sy) * z;
    (x, y, z * f32x16::splat(simd, sz))
}

/// Where the ray crosses the triangle, if it does with `t > 0`; the caller compares `t` with its own limit.
pub(crate) fn crossing(corners: &[Vec3; 3], ray: &PreparedRay) -> Option<Crossing> {
    let orientation = rounded_orientation(corners, ray)?;
    let exact = Sheared::new(corners, ray);
    let weights = exact.edge_functions() * orientation;
    let det = weights.element_sum();
    let (t, bary) = if weights.min_element() >= 0.0 && det > 0.0 {
        let bary = weights / det;
        let m = exact.largest();
        let delta = 96.0 * (0.5 * f64::EPSILON) * m * m * m / det * exact.inverse_dz.abs();
        let t = bary.dot(exact.depths());
        if t <= delta {
            return None;
        }
        (t, bary)
    } else {
        let bary = exact.nearest_on_outline();
        (bary.dot(exact.depths()), bary)
    };
    let t = t as f32;
    (t > 0.0).then_some(Crossing { t, u: bary.y as f32, v: bary.z as f32 })
}

/// Corners relative to the origin, sheared in double precision.
struct Sheared {
    /// x and y are sheared, z is along the direction's largest axis.
    corners: [DVec3; 3],
    inverse_dz: f64,
}

impl Sheared {
    fn new(corners: &[Vec3; 3], ray: &PreparedRay) -> Self {
        let [kx, ky, kz] = ray.axes;
        let d = ray.direction.as_dvec3();
        let (sx, sy, inverse_dz) = (d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]);
        let corners = corners.map(|corner| {
            let p = corner.as_dvec3() - ray.origin.as_dvec3();
            DVec3::new(p[kx] - sx * p[kz], p[ky] - sy * p[kz], p[kz])
        });
        Self { corners, inverse_dz }
    }

    /// Twice the signed areas opposite to the corners.
    fn edge_functions(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        edge_functions(a.truncate(), b.truncate(), c.truncate())
    }

    /// Distances of the corners along the ray.
    fn depths(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        DVec3::new(a.z, b.z, c.z) * self.inverse_dz
    }

    fn largest(&self) -> f64 {
        self.corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max)
    }

    /// Barycentrics of the point of the projected outline that is nearest to the ray.
    fn nearest_on_outline(&self) -> DVec3 {
        let p = self.corners.map(DVec3::truncate);
        let mut best = (f64::INFINITY, DVec3::X);
        for i in 0..3 {
            let j = (i + 1) % 3;
            let edge = p[j] - p[i];
            let length2 = edge.length_squared();
            let s = if length2 > 0.0 { (-p[i].dot(edge) / length2).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (p[i] + s * edge).length_squared();
            if distance < best.0 {
                let mut bary = DVec3::ZERO;
                (bary[i], bary[j]) = (1.0 - s, s);
                best = (distance, bary);
            }
        }
        best.1
    }
}

fn edge_functions(a: DVec2, b: DVec2, c: DVec2) -> DVec3 {
    DVec3::new(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x)
}

/// The sign that makes the rounded edge functions positive; `None` where the ray passes outside.
fn rounded_orientation(corners: &[Vec3; 3], ray: &PreparedRay) -> Option<f64> {
    let [a, b, c] = corners.map(|corner| rounded_corner(corner, ray));
    let edges = [c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x];
    let sure = edges.iter().all(|e| *e != 0.0 && e.is_finite());
    if !sure {
        return exact_orientation(corners, ray);
    }
    match (edges.iter().all(|&e| e > 0.0), edges.iter().all(|&e| e < 0.0)) {
        (true, _) => Some(1.0),
        (_, true) => Some(-1.0),
        _ => None,
    }
}

/// [`rounded_orientation`] where a rounded edge function is zero or has overflowed: the signs of the edge functions of
/// the rounded corners are exact in double precision, and zeros go to one of the two triangles at an edge.
#[cold]
fn exact_orientation(corners: &[Vec3; 3], ray: &PreparedRay) -> Option<f64> {
    let [a, b, c] = corners.map(|corner| {
        let rounded = rounded_corner(corner, ray);
        if rounded.is_finite() { rounded.as_dvec2() } else { wide_corner(corner, ray) }
    });
    let edges = edge_functions(a, b, c);
    let orientation = match (edges.min_element() < 0.0, edges.max_element() > 0.0) {
        (false, true) => 1.0,
        (true, false) => -1.0,
        // Outside, or seen exactly edge-on.
        _ => return None,
    };
    // The rule is that of a ray moved by an infinitesimal step, the same one for all triangles.
    let owned = |value: f64, from: DVec2, to: DVec2| {
        let edge = (to - from) * orientation;
        value != 0.0 || edge.y > 0.0 || (edge.y == 0.0 && edge.x < 0.0)
    };
    (owned(edges.x, b, c) && owned(edges.y, c, a) && owned(edges.z, a, b)).then_some(orientation)
}

/// A sheared corner with exactly the roundings of [`candidates`].
#[inline]
fn rounded_corner(corner: Vec3, ray: &PreparedRay) -> Vec2 {
    let [kx, ky, kz] = ray.axes;
    let z = corner[kz] - ray.origin[kz];
    let (x, y) = (corner[kx] - ray.origin[kx], corner[ky] - ray.origin[ky]);
    Vec2::new(x - ray.shear[0] * z, y - ray.shear[1] * z)
}

/// The same where single precision overflows; it depends on nothing but the corner and the ray, so triangles that share
/// a corner still agree.
fn wide_corner(corner: Vec3, ray: &PreparedRay) -> DVec2 {
    let [kx, ky, kz] = ray.axes;
    let p = corner.as_dvec3() - ray.origin.as_dvec3();
    DVec2::new(p[kx] - f64::from(ray.shear[0]) * p[kz], p[ky] - f64::from(ray.shear[1]) * p[kz])
}
