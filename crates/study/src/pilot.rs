//! The pilot: the cones of a sample of points, one by one, each judged by many rays inside it.
//!
//! It says what no image can: how far each cone is from the truth, how that compares with its epsilon, and what the
//! rays inside it meet.

mod features;

use crate::{Case, StudyError};
use conray::{AoSettings, ConeViews, Method, Ray, SurfacePoint, Vec3};
use conray_core::{Cone, Frame, hash_u32, owen_sobol_2d};
pub(crate) use features::OccluderFacts;
use features::Occluders;
use rayon::prelude::*;

/// Rays inside each cone.
pub(crate) const PILOT_RAYS: u32 = 256;

/// Sizes of sets of rays whose variance is known: 1, 2, 4 to 2 to the power of this less 1.
const VARIANCES: usize = 8;

/// A sample of points with their cones.
#[derive(Clone, Debug)]
pub struct Pilot {
    /// Spread evenly over the image, in the order of the case's points.
    pub points: Vec<PilotPoint>,
}

/// One point of the sample.
#[derive(Clone, Debug)]
pub struct PilotPoint {
    /// Index into the case's points.
    pub index: usize,
    /// Its cones, in the order of the set.
    pub cones: Vec<PilotCone>,
}

/// One cone: what the march says and what rays say.
#[derive(Clone, Copy, Debug)]
pub struct PilotCone {
    /// Share of the cosine-weighted hemisphere.
    pub weight: f32,
    /// As marched.
    pub visibility: f32,
    /// Epsilon.
    pub epsilon: f32,
    /// The voxels prove that nothing is in the way.
    pub certified: bool,
    /// By 256 rays inside it.
    pub truth: f32,
    /// Variance of the mean of 2^k rays of the cone's own sequence, for k from 0.
    pub ray_variance: [f32; VARIANCES],
    /// What the rays met.
    pub(crate) occluders: OccluderFacts,
}

impl PilotCone {
    /// Variance of the mean of that many rays, at least one; linear in logarithms between the known ones.
    pub fn variance_of_mean(&self, rays: u32) -> f32 {
        let level = (rays.max(1) as f32).log2();
        let low = level as usize;
        let known = &self.ray_variance;
        if low + 1 >= VARIANCES {
            // Beyond the measured sizes: as of independent rays, which is never too little.
            return known[VARIANCES - 1] * (1 << (VARIANCES - 1)) as f32 / rays as f32;
        }
        let share = level - low as f32;
        known[low] * (1.0 - share) + known[low + 1] * share
    }
}

impl Pilot {
    /// Looks at about `count` points.
    ///
    /// # Errors
    /// A session without an octree.
    pub fn trace(case: &Case, count: usize) -> Result<Self, StudyError> {
        let all = case.points().len();
        let count = count.min(all);
        let picked: Vec<usize> = (0..count).map(|i| (2 * i + 1) * all / (2 * count)).collect();
        let points = trace_points(case, &picked)?;
        Ok(Self { points })
    }
}

/// Looks at chosen points.
pub(crate) fn trace_points(case: &Case, picked: &[usize]) -> Result<Vec<PilotPoint>, StudyError> {
    let settings = AoSettings { method: Method::Paper, ..case.settings.clone() };
    let plan = case.session.plan_for(&settings)?;
    let octree = case.session.octree().ok_or_else(|| {
        StudyError::Request("the study's session has no octree; build it for method paper".into())
    })?;
    let views = ConeViews::new(&plan, octree);
    Ok(case.session.install(|| {
        picked
            .par_iter()
            .map(|&index| {
                let point = &case.points()[index];
                let frame = Frame::from_normal(point.shading_normal);
                let cones = views
                    .at(point)
                    .enumerate()
                    .map(|(number, view)| {
                        let rays =
                            ConeRays { case, point, frame: &frame, cone: view.cone, distance: plan.distance };
                        let (truth, ray_variance, occluders) = rays.trace(number as u32);
                        let open = view.visibility == 1.0 && view.error == 0.0;
                        PilotCone {
                            weight: view.cone.weight,
                            visibility: view.visibility,
                            epsilon: view.error,
                            certified: open
                                && features::path_is_empty(
                                    octree,
                                    point,
                                    view.axis,
                                    view.cone,
                                    plan.distance,
                                ),
                            truth,
                            ray_variance,
                            occluders,
                        }
                    })
                    .collect();
                PilotPoint { index, cones }
            })
            .collect()
    }))
}

/// The rays inside one cone of one point.
struct ConeRays<'a> {
    case: &'a Case,
    point: &'a SurfacePoint,
    frame: &'a Frame,
    cone: &'a Cone,
    distance: f32,
}

impl ConeRays<'_> {
    /// Mean visibility, variance of the mean by number of rays, and what was met.
    fn trace(&self, number: u32) -> (f32, [f32; VARIANCES], OccluderFacts) {
        let session = &self.case.session;
        let origin = self.point.ray_origin();
        // Random numbers of their own: neither those of the truth nor those of a contender.
        let seed = hash_u32(hash_u32(self.point.id ^ 0x9107_51ed).wrapping_add(number));
        let mut seen = [0.0f32; PILOT_RAYS as usize];
        let mut occluders = Occluders::new(session, self.point);
        for (index, visibility) in (0..).zip(&mut seen) {
            let direction: Vec3 = self.frame.to_world(self.cone.sample(owen_sobol_2d(index, seed)));
            if direction.dot(self.point.geometric_normal) <= 0.0 {
                continue;
            }
            let ray = Ray { origin, direction, t_max: self.distance };
            *visibility = session.bvh().visibility(&ray, self.case.settings.falloff, self.distance);
            if *visibility < 1.0 && index < features::RAYS_LOOKED_AT {
                occluders.look(&ray);
            }
        }
        (mean(&seen), variances(&seen), occluders.facts())
    }
}

fn mean(values: &[f32]) -> f32 {
    (values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64) as f32
}

/// Variance of the mean of 2^k consecutive rays: aligned blocks of the sequence are point sets of their own.
///
/// With as many rays as there are, the variance of the largest blocks is carried on as of independent rays.
fn variances(seen: &[f32]) -> [f32; VARIANCES] {
    std::array::from_fn(|k| {
        let block = 1 << k;
        let means: Vec<f64> = seen.chunks_exact(block).map(|c| f64::from(mean(c))).collect();
        let all = means.iter().sum::<f64>() / means.len() as f64;
        let squares: f64 = means.iter().map(|m| (m - all) * (m - all)).sum();
        (squares / (means.len() - 1) as f64) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_are_those_of_block_means() {
        // Alternating 0 and 1: single rays have variance about 1/4, pairs none.
        let seen: Vec<f32> = (0..PILOT_RAYS).map(|i| (i % 2) as f32).collect();
        let found = variances(&seen);
        assert!((found[0] - 0.25 * 256.0 / 255.0).abs() < 1e-6, "{found:?}");
        assert!(found[1..].iter().all(|&v| v == 0.0), "{found:?}");
    }

    #[test]
    fn between_known_sizes_the_variance_is_interpolated_and_beyond_them_it_falls() {
        let mut cone = PilotCone {
            weight: 1.0,
            visibility: 0.0,
            epsilon: 0.0,
            certified: false,
            truth: 0.0,
            ray_variance: [0.0; VARIANCES],
            occluders: OccluderFacts::default(),
        };
        cone.ray_variance = std::array::from_fn(|k| 1.0 / (1 << k) as f32);
        assert_eq!(cone.variance_of_mean(1), 1.0);
        assert_eq!(cone.variance_of_mean(4), 0.25);
        let three = cone.variance_of_mean(3);
        assert!(three > 0.25 && three < 0.5, "{three}");
        assert!((cone.variance_of_mean(512) - 1.0 / 512.0).abs() < 1e-7);
    }
}
