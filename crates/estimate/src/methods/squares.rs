//! From points of the unit square to directions, sixteen at a time, whatever point set they come from.

use crate::{AoPlan, Sampling};
use conray_bvh::Level;
use conray_core::{
    Frame, JitteredPoints, LANES, RandomPoints, Vec2, cosine_hemisphere_lanes, owen_sobol_2d_lanes,
};
use fearless_simd::{Simd, dispatch, f32x16, prelude::*};

/// The points of the unit square that a surface point's rays go through.
pub(super) enum Squares {
    Sobol { seed: u32 },
    Stratified(JitteredPoints),
    Random(RandomPoints),
}

/// Sixteen samples: where in the square, and in which direction.
pub(super) struct Sixteen {
    pub(super) square: [[f32; LANES]; 2],
    pub(super) world: [[f32; LANES]; 3],
}

impl Squares {
    /// Those of the sequence `seed`.
    pub(super) fn new(plan: &AoPlan, seed: u32) -> Self {
        match plan.sampling {
            Sampling::Sobol => Self::Sobol { seed },
            Sampling::Stratified => Self::Stratified(JitteredPoints::new(plan.rays, seed)),
            Sampling::Random => Self::Random(RandomPoints::new(seed)),
        }
    }

    /// Samples `first` to `first + 15`, cosine-weighted about a frame's third axis.
    #[inline]
    pub(super) fn sixteen(&self, level: Level, first: u32, frame: &Frame) -> Sixteen {
        match self {
            Self::Sobol { seed } => dispatch!(level, simd => sobol(simd, first, *seed, frame)),
            Self::Stratified(points) => one_by_one(level, frame, |lane| points.point(first + lane)),
            Self::Random(points) => one_by_one(level, frame, |lane| points.point(first + lane)),
        }
    }
}

#[inline(always)]
fn sobol<S: Simd>(simd: S, first: u32, seed: u32, frame: &Frame) -> Sixteen {
    directed(simd, owen_sobol_2d_lanes(simd, first, seed), frame)
}

/// Points that are drawn one by one; only their directions are made together.
#[inline]
fn one_by_one(level: Level, frame: &Frame, point: impl Fn(u32) -> Vec2) -> Sixteen {
    let points: [Vec2; LANES] = std::array::from_fn(|lane| point(lane as u32));
    let (x, y) = (points.map(|p| p.x), points.map(|p| p.y));
    dispatch!(level, simd => directed(simd, [f32x16::simd_from(simd, x), f32x16::simd_from(simd, y)], frame))
}

#[inline(always)]
fn directed<S: Simd>(simd: S, square: [f32x16<S>; 2], frame: &Frame) -> Sixteen {
    let [x, y, z] = frame.to_world_lanes(simd, cosine_hemisphere_lanes(simd, square));
    let [u, v] = square;
    Sixteen { square: [u.into(), v.into()], world: [x.into(), y.into(), z.into()] }
}
