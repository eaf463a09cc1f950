//! Method `rays`: cosine-weighted rays in directions that a point set gives.

use super::point_rays::{PointRays, Tally};
use super::quarters::Quarters;
use super::squares::Squares;
use crate::AoPlan;
use conray_bvh::{BUNDLE_RAYS, Bvh, Directions};
use conray_core::{Estimate, Frame, LANES, SurfacePoint, hash_u32};
use fearless_simd::{Simd, dispatch};
use std::ops::Range;

/// From so many rays on, bundles that look into a quarter of the hemisphere each are full, and share more of their way than
/// rays as drawn.
const QUARTERED_RAYS: usize = 4 * BUNDLE_RAYS;

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
        let squares = Squares::new(self.plan, hash_u32(point.id ^ hash_u32(self.plan.seed)));
        let rays = PointRays::new(self.plan, self.bvh, point);
        self.trace(&rays, &squares).estimate()
    }

    fn trace(&self, rays: &PointRays<'_>, squares: &Squares) -> Tally {
        let (level, frame, samples) = (self.bvh.level(), &rays.frame, self.samples.clone());
        let reach = self.plan.reach;
        let mut tally = Tally::default();
        if samples.len() >= QUARTERED_RAYS {
            let mut quarters = Quarters::new();
            for first in samples.clone().step_by(LANES) {
                let drawn = dispatch!(level, simd => squares.sixteen(simd, first, frame, reach).stored(simd));
                let count = LANES.min((samples.end - first) as usize);
                quarters.push(&drawn, count, |bundle| rays.trace(bundle, &mut tally));
            }
            quarters.finish(|bundle| rays.trace(bundle, &mut tally));
        } else {
            let mut bundle = Directions::new();
            for first in samples.clone().step_by(BUNDLE_RAYS) {
                let part = first..samples.end.min(first.saturating_add(BUNDLE_RAYS as u32));
                dispatch!(level, simd => fill(simd, squares, part, (frame, reach), &mut bundle));
                rays.trace(&mut bundle, &mut tally);
            }
        }
        tally
    }
}

/// Puts up to [`BUNDLE_RAYS`] samples into an empty bundle.
#[inline(always)]
fn fill<S: Simd>(
    simd: S,
    squares: &Squares,
    samples: Range<u32>,
    (frame, reach): (&Frame, f32),
    bundle: &mut Directions,
) {
    for first in samples.clone().step_by(LANES) {
        let count = LANES.min((samples.end - first) as usize);
        bundle.push_group(&squares.sixteen(simd, first, frame, reach).world, count);
    }
}
