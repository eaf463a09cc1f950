//! What sixteen filters find, side by side.

use super::lanes::{LANES, Lanes};
use crate::lookup::Slope;
use fearless_simd::{Simd, f32x16, prelude::*};

/// Slopes of sixteen cones on one level, in 65535ths and nodes; zero where nothing was looked up.
pub(super) struct Slopes {
    /// Mean, SD, and the change of the mean along each axis.
    members: [Lanes<f32>; 5],
}

/// The same in opacities and leaves.
#[derive(Clone, Copy)]
pub(super) struct WideSlope<S: Simd> {
    pub(super) mean: f32x16<S>,
    pub(super) sd: f32x16<S>,
    pub(super) gradient: [f32x16<S>; 3],
}

impl Slopes {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { members: [Lanes([0.0; LANES]); 5] }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, slope: &Slope) {
        self.members[0].0[lane] = slope.sample.mean;
        self.members[1].0[lane] = slope.sample.sd;
        self.members[2].0[lane] = slope.gradient.x;
        self.members[3].0[lane] = slope.gradient.y;
        self.members[4].0[lane] = slope.gradient.z;
    }

    /// [`Slope::in_leaves`], sixteen times.
    #[inline(always)]
    pub(super) fn in_leaves<S: Simd>(&self, simd: S, level: usize) -> WideSlope<S> {
        let unit = f32x16::splat(simd, Slope::UNIT);
        let gradient_unit = f32x16::splat(simd, Slope::gradient_unit(level));
        let m = &self.members;
        WideSlope {
            mean: f32x16::from_slice(simd, &m[0].0) * unit,
            sd: f32x16::from_slice(simd, &m[1].0) * unit,
            gradient: [
                f32x16::from_slice(simd, &m[2].0) * gradient_unit,
                f32x16::from_slice(simd, &m[3].0) * gradient_unit,
                f32x16::from_slice(simd, &m[4].0) * gradient_unit,
            ],
        }
    }
}

impl<S: Simd> WideSlope<S> {
    /// [`Slope::lerp`], sixteen times.
    #[inline(always)]
    pub(super) fn lerp(self, simd: S, other: Self, share: f32) -> Self {
        let share = f32x16::splat(simd, share);
        let (a, b) = (&self.gradient, &other.gradient);
        Self {
            mean: self.mean + share * (other.mean - self.mean),
            sd: self.sd + share * (other.sd - self.sd),
            gradient: [
                a[0] + share * (b[0] - a[0]),
                a[1] + share * (b[1] - a[1]),
                a[2] + share * (b[2] - a[2]),
            ],
        }
    }
}
