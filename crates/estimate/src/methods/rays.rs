//! Method `rays`: cosine-weighted rays in directions that a point set gives.

use super::point_rays::{PointRays, Tally};
use crate::{AoPlan, Sampling};
use conray_bvh::Bvh;
use conray_core::{
    Estimate, JitteredPoints, RandomPoints, SurfacePoint, Vec2, cosine_hemisphere, hash_u32, owen_sobol_2d,
};
use std::ops::Range;

/// The unbiased estimate by rays alone.
pub(crate) struct Rays<'a> {
    pub(crate) plan: &'a AoPlan,
    pub(crate) bvh: &'a Bvh,
    /// Which rays of each point's sequence.
    pub(crate) samples: Range<u32>,
}

impl Rays<'_> {
    pub(crate) fn estimate(&self, point: &SurfacePoint) -> Estimate {
        // Each point has a sequence of its own: hashing keeps neighbours independent.
        let seed = hash_u32(point.id ^ hash_u32(self.plan.seed));
        match self.plan.sampling {
            Sampling::Sobol => self.trace(point, |index| owen_sobol_2d(index, seed)),
            Sampling::Stratified => {
                let points = JitteredPoints::new(self.plan.rays, seed);
                self.trace(point, |index| points.point(index))
            }
            Sampling::Random => {
                let points = RandomPoints::new(seed);
                self.trace(point, |index| points.point(index))
            }
        }
    }

    /// Traces the rays through the points of the unit square.
    #[inline]
    fn trace(&self, point: &SurfacePoint, square: impl Fn(u32) -> Vec2) -> Estimate {
        let rays = PointRays::new(self.plan, self.bvh, point);
        let mut tally = Tally::default();
        for index in self.samples.clone() {
            rays.trace(cosine_hemisphere(square(index)), &mut tally);
        }
        Estimate {
            visibility: tally.mean(),
            error: tally.variance_of_mean().sqrt(),
            rays: tally.rays,
            bent: tally.open / tally.rays.max(1) as f32,
            cone: None,
        }
    }
}
