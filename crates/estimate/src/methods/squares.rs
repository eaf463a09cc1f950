//! From points of the unit square to directions, sixteen at a time, whatever point set they come from.

use crate::{AoPlan, Sampling};
use conray_core::{Frame, JitteredPoints, LANES, RandomPoints, Vec2, cosine_cone_lanes, owen_sobol_2d_lanes};
use fearless_simd::{Simd, f32x16, prelude::*, u32x16};

/// The points of the unit square that a surface point's rays go through.
pub(crate) enum Squares {
    Sobol { seed: u32 },
    Stratified(JitteredPoints),
    Random(RandomPoints),
}

/// Sixteen samples: where in the square, and in which direction.
pub(crate) struct Sixteen<S: Simd> {
    pub(crate) square: [f32x16<S>; 2],
    pub(crate) world: [f32x16<S>; 3],
}

/// The same in memory.
pub(super) struct Drawn {
    /// Which quarter of the square each lies in, 0 to 3.
    pub(super) quarter: [u32; LANES],
    pub(super) world: [[f32; LANES]; 3],
}

impl<S: Simd> Sixteen<S> {
    #[inline(always)]
    pub(super) fn stored(self, simd: S) -> Drawn {
        let ([u, v], [x, y, z]) = (self.square, self.world);
        let (half, zero) = (f32x16::splat(simd, 0.5), u32x16::splat(simd, 0));
        let right = u.simd_ge(half).select(u32x16::splat(simd, 1), zero);
        let upper = v.simd_ge(half).select(u32x16::splat(simd, 2), zero);
        Drawn { quarter: (right | upper).into(), world: [x.into(), y.into(), z.into()] }
    }
}

impl Squares {
    /// Those of the sequence `seed`.
    pub(crate) fn new(plan: &AoPlan, seed: u32) -> Self {
        match plan.sampling {
            Sampling::Sobol => Self::Sobol { seed },
            Sampling::Stratified => Self::Stratified(JitteredPoints::new(plan.budget.rays, seed)),
            Sampling::Random => Self::Random(RandomPoints::new(seed)),
        }
    }

    /// Samples `first` to `first + 15`, cosine-weighted about a frame's third axis, within the cone whose half-angle has the sine `reach`.
    #[inline(always)]
    pub(crate) fn sixteen<S: Simd>(&self, simd: S, first: u32, frame: &Frame, reach: f32) -> Sixteen<S> {
        let square = match self {
            Self::Sobol { seed } => owen_sobol_2d_lanes(simd, first, *seed),
            Self::Stratified(points) => one_by_one(simd, |lane| points.point(first + lane)),
            Self::Random(points) => one_by_one(simd, |lane| points.point(first + lane)),
        };
        Sixteen { square, world: frame.to_world_lanes(simd, cosine_cone_lanes(simd, square, reach)) }
    }
}

/// Points that are drawn one by one.
#[inline(always)]
fn one_by_one<S: Simd>(simd: S, point: impl Fn(u32) -> Vec2) -> [f32x16<S>; 2] {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        [x[lane], y[lane]] = point(lane as u32).to_array();
    }
    [f32x16::simd_from(simd, x), f32x16::simd_from(simd, y)]
}
