//! Method `cones`: the hemisphere as a set of cones marched through the octree.

use super::above_surface::AboveSurface;
use crate::AoPlan;
use conray_bvh::Level;
use conray_core::{Cone, ConeEstimate, Estimate, Frame, SurfacePoint, Vec3};
use conray_voxel::{ConeMarch, ConeResult, MarchOptions, Octree};

/// The estimate by cones alone.
pub(crate) struct Cones<'a> {
    pub(crate) marches: Marches<'a>,
}

impl Cones<'_> {
    pub(crate) fn estimate(&self, point: &SurfacePoint) -> Estimate {
        let (mut visibility, mut error, mut bent) = (0.0, 0.0, Vec3::ZERO);
        for (cone, axis, result) in self.marches.at(point) {
            visibility += cone.weight * result.visibility;
            error += cone.weight * result.error;
            bent += cone.weight * result.visibility * axis;
        }
        let cone = Some(ConeEstimate { visibility, error, alpha: 1.0 });
        Estimate { visibility, error, rays: 0, bent, cone }
    }
}

/// The cones of a plan, prepared for marching.
pub(crate) struct Marches<'a> {
    plan: &'a AoPlan,
    march: ConeMarch<'a>,
    above: AboveSurface,
}

/// Most cones of a set.
const MOST_CONES: usize = 25;

impl<'a> Marches<'a> {
    pub(crate) fn new(plan: &'a AoPlan, octree: &'a Octree, level: Level) -> Self {
        let options = MarchOptions::default();
        let march = octree.cone_march(&plan.cones, plan.distance, plan.falloff, &options).at_level(level);
        Self { plan, march, above: AboveSurface::new(&plan.cones) }
    }

    /// Marches every cone at a point: the cone, its axis in world space and its result.
    pub(crate) fn at(
        &self,
        point: &SurfacePoint,
    ) -> impl Iterator<Item = (&'a Cone, Vec3, ConeResult)> + use<'a> {
        let frame = Frame::from_normal(point.shading_normal);
        let cones = self.plan.cones.cones();
        let mut results = [ConeResult { visibility: 0.0, error: 0.0 }; MOST_CONES];
        self.march.march(point.position, point.geometric_normal, &frame, &mut results[..cones.len()]);
        if point.shading_normal != point.geometric_normal {
            let normal = frame.to_local(point.geometric_normal);
            self.above.scale(normal, &mut results[..cones.len()]);
        }
        cones.iter().zip(results).map(move |(cone, result)| (cone, frame.to_world(cone.axis), result))
    }
}
