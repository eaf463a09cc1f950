//! Method `rays`: cosine-weighted rays in directions that a point set gives.

use super::point_rays::{PointRays, Tally};
use super::quarters::Quarters;
use crate::{AoPlan, Sampling};
use conray_bvh::{BUNDLE_RAYS, Bvh, Directions};
use conray_core::{
    Estimate, Frame, JitteredPoints, LANES, RandomPoints, SurfacePoint, Vec2, cosine_hemisphere,
    cosine_hemisphere_lanes, hash_u32, owen_sobol_2d_lanes,
};
use fearless_simd::{Simd, dispatch};
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
        let rays = PointRays::new(self.plan, self.bvh, point);
        let mut tally = Tally::default();
        match self.plan.sampling {
            Sampling::Sobol => self.trace_sobol(&rays, seed, &mut tally),
            Sampling::Stratified => {
                let points = JitteredPoints::new(self.plan.rays, seed);
                self.trace(&rays, |index| points.point(index), &mut tally);
            }
            Sampling::Random => {
                let points = RandomPoints::new(seed);
                self.trace(&rays, |index| points.point(index), &mut tally);
            }
        }
        Estimate {
            visibility: tally.mean(),
            error: tally.variance_of_mean().sqrt(),
            rays: tally.rays,
            bent: tally.open / tally.rays.max(1) as f32,
            cone: None,
        }
    }

    /// Traces rays of the Sobol sequence, sixteen made at a time.
    fn trace_sobol(&self, rays: &PointRays<'_>, seed: u32, tally: &mut Tally) {
        let samples = self.samples.clone();
        if samples.len() > BUNDLE_RAYS {
            // Bundles that look into a quarter of the hemisphere each share more of their way.
            let mut quarters = Quarters::new();
            for first in samples.clone().step_by(LANES) {
                let sixteen = sixteen_at(self.bvh, first, seed, &rays.frame);
                quarters.push(&sixteen, (samples.end - first) as usize, |bundle| rays.trace(bundle, tally));
            }
            quarters.finish(|bundle| rays.trace(bundle, tally));
        } else {
            let mut bundle = Directions::new();
            for first in samples.clone().step_by(LANES) {
                let sixteen = sixteen_at(self.bvh, first, seed, &rays.frame);
                bundle.push_group(sixteen.world, LANES.min((samples.end - first) as usize));
            }
            rays.trace(&mut bundle, tally);
        }
    }

    /// Traces the rays through the points of the unit square.
    fn trace(&self, rays: &PointRays<'_>, square: impl Fn(u32) -> Vec2, tally: &mut Tally) {
        let mut bundle = Directions::new();
        for index in self.samples.clone() {
            bundle.push(rays.frame.to_world(cosine_hemisphere(square(index))));
            if bundle.len() == BUNDLE_RAYS {
                rays.trace(&mut bundle, tally);
            }
        }
        rays.trace(&mut bundle, tally);
    }
}

/// Sixteen samples: where in the square, and in which direction.
pub(super) struct Sixteen {
    pub(super) square: [[f32; LANES]; 2],
    pub(super) world: [[f32; LANES]; 3],
}

fn sixteen_at(bvh: &Bvh, first: u32, seed: u32, frame: &Frame) -> Sixteen {
    dispatch!(bvh.level(), simd => sixteen(simd, first, seed, frame))
}

#[inline(always)]
fn sixteen<S: Simd>(simd: S, first: u32, seed: u32, frame: &Frame) -> Sixteen {
    let square = owen_sobol_2d_lanes(simd, first, seed);
    let [x, y, z] = frame.to_world_lanes(simd, cosine_hemisphere_lanes(simd, square));
    let [u, v] = square;
    Sixteen { square: [u.into(), v.into()], world: [x.into(), y.into(), z.into()] }
}
