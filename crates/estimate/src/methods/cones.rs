//! Method `cones`: the hemisphere as a set of cones marched through the octree.

use super::above_surface::AboveSurface;
use crate::{AoPlan, epsilon::expected_error};
use conray_bvh::Level;
use conray_core::{Cone, ConeEstimate, Estimate, SurfacePoint, Vec3};
use conray_voxel::{ConeMarch, ConePoint, ConeResult, MarchOptions, Octree};

/// The estimate by cones alone.
pub(crate) struct Cones<'a> {
    pub(crate) marches: Marches<'a>,
}

impl Cones<'_> {
    /// The estimate at a point from what its cones found.
    pub(crate) fn estimate(&self, point: &SurfacePoint, results: &[ConeResult]) -> Estimate {
        self.marches.answers.summed(point, results)
    }
}

/// What the cones of points come to, whoever marched them.
pub struct ConeAnswers<'a> {
    plan: &'a AoPlan,
    above: AboveSurface,
}

impl<'a> ConeAnswers<'a> {
    /// For the cones of a plan.
    pub fn new(plan: &'a AoPlan) -> Self {
        Self { plan, above: AboveSurface::new(&plan.cones) }
    }

    /// The estimate of method `cones` at a point from what its cones, marched from there about the shading normal, found; in the plan's order.
    pub fn estimate(&self, point: &SurfacePoint, results: &mut [ConeResult]) -> Estimate {
        self.scale(point, results);
        self.summed(point, results)
    }

    /// Takes from cones what is below the geometric surface.
    pub(super) fn scale(&self, point: &SurfacePoint, results: &mut [ConeResult]) {
        if point.shading_normal != point.geometric_normal {
            let frame = cone_point(point).frame;
            self.above.scale(frame.to_local(point.geometric_normal), results);
        }
    }

    fn summed(&self, point: &SurfacePoint, results: &[ConeResult]) -> Estimate {
        let (mut visibility, mut epsilon, mut error, mut bent) = (0.0, 0.0, 0.0, Vec3::ZERO);
        for (cone, axis, result) in self.of(point, results.iter().copied()) {
            visibility += cone.weight * result.visibility;
            epsilon += cone.weight * result.error;
            error += cone.weight * expected_error(&result);
            bent += cone.weight * result.visibility * axis;
        }
        let cone = Some(ConeEstimate { visibility, error: epsilon, alpha: 1.0 });
        Estimate { visibility, error, rays: 0, bent, cone }
    }

    /// The cones of a point, each with its axis in world space and its result.
    pub(super) fn of<R: IntoIterator<Item = ConeResult>>(
        &self,
        point: &SurfacePoint,
        results: R,
    ) -> impl Iterator<Item = (&'a Cone, Vec3, ConeResult)> + use<'a, R> {
        let frame = cone_point(point).frame;
        let cones = self.plan.cones.cones().iter().zip(results);
        cones.map(move |(cone, result)| (cone, frame.to_world(cone.axis), result))
    }
}

/// The cones of a plan, prepared for marching.
pub(crate) struct Marches<'a> {
    march: ConeMarch<'a>,
    answers: ConeAnswers<'a>,
}

impl<'a> Marches<'a> {
    pub(crate) fn new(plan: &'a AoPlan, octree: &'a Octree, level: Level) -> Self {
        let options = MarchOptions::default();
        let march = octree.cone_march(&plan.cones, plan.distance, plan.falloff, &options).at_level(level);
        Self { march, answers: ConeAnswers::new(plan) }
    }

    /// Cones of a point.
    pub(crate) fn count(&self) -> usize {
        self.answers.plan.cones.cones().len()
    }

    /// Marches every cone at some points; the results of one point after those of the other.
    pub(crate) fn march(&self, points: &[SurfacePoint]) -> Vec<ConeResult> {
        let count = self.count();
        let set: Vec<_> = points.iter().map(cone_point).collect();
        let mut results = vec![ConeResult { visibility: 0.0, error: 0.0 }; points.len() * count];
        self.march.march(&set, &mut results);
        for (point, results) in points.iter().zip(results.chunks_mut(count)) {
            self.answers.scale(point, results);
        }
        results
    }

    /// The cones of a point, each with its axis in world space and its result.
    pub(crate) fn of<R: IntoIterator<Item = ConeResult>>(
        &self,
        point: &SurfacePoint,
        results: R,
    ) -> impl Iterator<Item = (&'a Cone, Vec3, ConeResult)> + use<'a, R> {
        self.answers.of(point, results)
    }
}

/// Where the cones of a surface point stand.
fn cone_point(point: &SurfacePoint) -> ConePoint {
    ConePoint::about(point.shading_normal, point.position, point.geometric_normal)
}
