//! Method `rays`: cosine-weighted rays in Owen-scrambled Sobol order.

use super::point_rays::{PointRays, Tally};
use crate::AoPlan;
use conray_bvh::Bvh;
use conray_core::{Estimate, SurfacePoint, cosine_hemisphere, hash_u32, owen_sobol_2d};
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
        let rays = PointRays::new(self.plan, self.bvh, point);
        // Each point has a sequence of its own: hashing keeps neighbours independent.
        let seed = hash_u32(point.id ^ hash_u32(self.plan.seed));
        let mut tally = Tally::default();
        for index in self.samples.clone() {
            rays.trace(cosine_hemisphere(owen_sobol_2d(index, seed)), &mut tally);
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
