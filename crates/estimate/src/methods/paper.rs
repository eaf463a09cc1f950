//! Method `paper`: cones where their error is small, rays inside the cone where it is not.
//!
//! Podee, Dobashi, Yamamoto, "Combining Cone and Ray Tracing for Ambient Occlusion Computation", equations 1 to 3.
//! What the paper leaves open is settled so: the number of rays is rounded to the nearest whole; where it rounds to
//! none the cone is taken alone; rays follow an Owen-scrambled Sobol sequence per cone.

use super::{
    cones::{ConeAnswers, Marches},
    point_rays::{PointRays, RayQueue, Tally},
};
use crate::{AoPlan, epsilon::expected_error};
use conray_bvh::Bvh;
use conray_core::{
    Cone, ConeEstimate, Estimate, Frame, LANES, SurfacePoint, Vec3, hash_u32, owen_sobol_2d_lanes,
};
use conray_voxel::ConeResult;
use fearless_simd::{Simd, dispatch};
use std::ops::Range;

/// The published blend of cones and rays.
pub(crate) struct Paper<'a> {
    pub(crate) plan: &'a AoPlan,
    pub(crate) bvh: &'a Bvh,
    pub(crate) marches: Marches<'a>,
    /// Which frames; each has rays of its own, and their mean is the estimate.
    pub(crate) frames: Range<u32>,
}

impl Paper<'_> {
    /// The estimate at a point from what its cones found.
    pub(crate) fn estimate(&self, point: &SurfacePoint, results: &[ConeResult]) -> Estimate {
        let plan = self.plan;
        let point_rays = PointRays::new(plan, self.bvh, point);
        let seed = hash_u32(point.id ^ hash_u32(plan.seed));
        let marched: Vec<_> = self.marches.of(point, results.iter().copied()).collect();
        let tallies = self.trace(&point_rays, seed, &marched);
        blended(plan, &marched, &tallies)
    }

    /// Traces the rays of all cones, those of neighbouring cones in one bundle; a tally for each cone.
    fn trace(&self, rays: &PointRays<'_>, seed: u32, marched: &[(&Cone, Vec3, ConeResult)]) -> Vec<Tally> {
        let mut tallies = vec![Tally::default(); marched.len()];
        let mut queue = RayQueue::new(rays);
        for (index, (cone, _, result)) in marched.iter().enumerate() {
            let per_frame = ray_count(cone_share(result, self.plan), self.plan.max_rays);
            let cone_seed = hash_u32(seed.wrapping_add(index as u32));
            let samples = self.frames.start * per_frame..self.frames.end * per_frame;
            for first in samples.clone().step_by(LANES) {
                let count = LANES.min((samples.end - first) as usize);
                let level = self.bvh.level();
                let world = dispatch!(level, simd => sixteen(simd, cone, first, cone_seed, &rays.frame));
                queue.push(&world, count, index, &mut tallies);
            }
        }
        queue.trace(&mut tallies);
        tallies
    }
}

/// The estimate at a point whose cones, each with its axis in world space, were marched and traced.
fn blended(plan: &AoPlan, marched: &[(&Cone, Vec3, ConeResult)], tallies: &[Tally]) -> Estimate {
    let mut all = ConeEstimate { visibility: 0.0, error: 0.0, alpha: 0.0 };
    let (mut visibility, mut bent, mut rays) = (0.0, Vec3::ZERO, 0);
    let (mut trusted_error, mut ray_variance) = (0.0, 0.0);
    for ((cone, axis, result), tally) in marched.iter().zip(tallies) {
        let alpha = if tally.rays > 0 { cone_share(result, plan) } else { 1.0 };
        visibility += cone.weight * (alpha * result.visibility + (1.0 - alpha) * tally.mean());
        trusted_error += cone.weight * alpha * expected_error(result);
        if tally.rays > 0 {
            ray_variance += (cone.weight * (1.0 - alpha)).powi(2) * tally.variance_of_mean();
        }
        let open_by_rays = tally.open / tally.rays.max(1) as f32;
        bent += cone.weight * (alpha * result.visibility * *axis + (1.0 - alpha) * open_by_rays);
        rays += tally.rays;
        all.visibility += cone.weight * result.visibility;
        all.error += cone.weight * result.error;
        all.alpha += cone.weight * alpha;
    }
    // Cone errors are taken as fully correlated, those of rays as independent.
    let error = trusted_error + ray_variance.sqrt();
    Estimate { visibility, error, rays, bent, cone: Some(all) }
}

/// What the cones and the rays of points come to, whoever marched and traced them.
pub struct BlendAnswers<'a> {
    plan: &'a AoPlan,
    cones: ConeAnswers<'a>,
}

impl<'a> BlendAnswers<'a> {
    /// For the cones of a plan.
    pub fn new(plan: &'a AoPlan) -> Self {
        Self { plan, cones: ConeAnswers::new(plan) }
    }

    /// Takes from cones, marched from a point about the shading normal, what is below the geometric surface there, and tells how many rays each is to get in
    /// a frame: those of its sequence from as many times the number of the frame on.
    pub fn ray_counts(&self, point: &SurfacePoint, results: &mut [ConeResult]) -> Vec<u32> {
        self.cones.scale(point, results);
        results.iter().map(|result| ray_count(cone_share(result, self.plan), self.plan.max_rays)).collect()
    }

    /// The estimate from those cones and what their rays met.
    pub fn estimate(&self, point: &SurfacePoint, results: &[ConeResult], tallies: &[Tally]) -> Estimate {
        let marched: Vec<_> = self.cones.of(point, results.iter().copied()).collect();
        blended(self.plan, &marched, tallies)
    }
}

/// Sixteen directions of a cone's sequence, in world space.
#[inline(always)]
fn sixteen<S: Simd>(simd: S, cone: &Cone, first: u32, seed: u32, frame: &Frame) -> [[f32; LANES]; 3] {
    let local = cone.sample_lanes(simd, owen_sobol_2d_lanes(simd, first, seed));
    let [x, y, z] = frame.to_world_lanes(simd, local);
    [x.into(), y.into(), z.into()]
}

/// Equation 1: the cone's share in the blend, 1 up to the threshold.
pub(crate) fn cone_share(cone: &ConeResult, plan: &AoPlan) -> f32 {
    let epsilon = plan.epsilon.of(cone.visibility, cone.error);
    if epsilon == f32::INFINITY {
        // An unusable cone is left to rays, whatever beta says.
        return 0.0;
    }
    (-plan.beta * (epsilon - plan.gamma)).exp().clamp(0.0, 1.0)
}

/// Equation 2, rounded to the nearest whole.
pub(crate) fn ray_count(alpha: f32, max_rays: u32) -> u32 {
    ((1.0 - alpha) * max_rays as f32).round() as u32
}
