//! Method `paper`: cones where their error is small, rays inside the cone where it is not.
//!
//! Podee, Dobashi, Yamamoto, "Combining Cone and Ray Tracing for Ambient Occlusion Computation", equations 1 to 3.
//! What the paper leaves open is settled so: the number of rays is rounded to the nearest whole; where it rounds to
//! none the cone is taken alone; rays follow an Owen-scrambled Sobol sequence per cone.

use super::{
    cones::Marches,
    point_rays::{PointRays, Tally},
};
use crate::AoPlan;
use conray_bvh::Bvh;
use conray_core::{ConeEstimate, Estimate, SurfacePoint, Vec3, hash_u32, owen_sobol_2d};
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
    pub(crate) fn estimate(&self, point: &SurfacePoint) -> Estimate {
        let plan = self.plan;
        let point_rays = PointRays::new(plan, self.bvh, point);
        let seed = hash_u32(point.id ^ hash_u32(plan.seed));
        let mut all = ConeEstimate { visibility: 0.0, error: 0.0, alpha: 0.0 };
        let (mut visibility, mut bent, mut rays) = (0.0, Vec3::ZERO, 0);
        let (mut trusted_error, mut ray_variance) = (0.0, 0.0);
        for ((cone, axis, result), cone_index) in self.marches.at(point).zip(0u32..) {
            let share = cone_share(result.error, plan);
            let per_frame = ray_count(share, plan.max_rays);
            let mut tally = Tally::default();
            let cone_seed = hash_u32(seed.wrapping_add(cone_index));
            for index in self.frames.start * per_frame..self.frames.end * per_frame {
                point_rays.trace(cone.sample(owen_sobol_2d(index, cone_seed)), &mut tally);
            }
            let alpha = if per_frame > 0 { share } else { 1.0 };
            visibility += cone.weight * (alpha * result.visibility + (1.0 - alpha) * tally.mean());
            trusted_error += cone.weight * alpha * result.error;
            if per_frame > 0 {
                ray_variance += (cone.weight * (1.0 - alpha)).powi(2) * tally.variance_of_mean();
            }
            let open_by_rays = tally.open / tally.rays.max(1) as f32;
            bent += cone.weight * (alpha * result.visibility * axis + (1.0 - alpha) * open_by_rays);
            rays += tally.rays;
            all.visibility += cone.weight * result.visibility;
            all.error += cone.weight * result.error;
            all.alpha += cone.weight * alpha;
        }
        // Cone errors are taken as fully correlated, those of rays as independent.
        let error = trusted_error + ray_variance.sqrt();
        Estimate { visibility, error, rays, bent, cone: Some(all) }
    }
}

/// Equation 1: the cone's share in the blend, 1 up to the threshold.
pub(crate) fn cone_share(error: f32, plan: &AoPlan) -> f32 {
    if error == f32::INFINITY {
        // An unusable cone is left to rays, whatever beta says.
        return 0.0;
    }
    (-plan.beta * (error - plan.gamma)).exp().clamp(0.0, 1.0)
}

/// Equation 2, rounded to the nearest whole.
pub(crate) fn ray_count(alpha: f32, max_rays: u32) -> u32 {
    ((1.0 - alpha) * max_rays as f32).round() as u32
}
