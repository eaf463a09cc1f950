//! Method `cones`: the hemisphere as a set of cones marched through the octree.

use crate::AoPlan;
use conray_core::{Cone, ConeEstimate, Estimate, Frame, SurfacePoint, Vec2, Vec3};
use conray_voxel::{ConeQuery, ConeResult, Octree};

/// The estimate by cones alone.
pub(crate) struct Cones<'a> {
    pub(crate) plan: &'a AoPlan,
    pub(crate) octree: &'a Octree,
}

impl Cones<'_> {
    pub(crate) fn estimate(&self, point: &SurfacePoint) -> Estimate {
        let (mut visibility, mut error, mut bent) = (0.0, 0.0, Vec3::ZERO);
        for (cone, axis, result) in march_all(self.plan, self.octree, point) {
            visibility += cone.weight * result.visibility;
            error += cone.weight * result.error;
            bent += cone.weight * result.visibility * axis;
        }
        let cone = Some(ConeEstimate { visibility, error, alpha: 1.0 });
        Estimate { visibility, error, rays: 0, bent, cone }
    }
}

/// Marches every cone of the plan at a point: the cone, its axis in world space and its result.
pub(crate) fn march_all<'a>(
    plan: &'a AoPlan,
    octree: &'a Octree,
    point: &SurfacePoint,
) -> impl Iterator<Item = (&'a Cone, Vec3, ConeResult)> {
    let frame = Frame::from_normal(point.shading_normal);
    let point = *point;
    plan.cones.cones().iter().map(move |cone| {
        let axis = frame.to_world(cone.axis);
        let mut result = octree.march(&ConeQuery {
            apex: point.position,
            axis,
            half_angle_rad: cone.half_angle_rad,
            normal: point.geometric_normal,
            distance: plan.distance,
            falloff: plan.falloff,
        });
        result.visibility *= share_above_surface(cone, &frame, &point);
        (cone, axis, result)
    })
}

/// Share of a cone's directions that are above the geometric surface; the point's own surface is in the way of the rest.
fn share_above_surface(cone: &Cone, frame: &Frame, point: &SurfacePoint) -> f32 {
    const SIDE: u32 = 4;
    if point.shading_normal == point.geometric_normal {
        return 1.0;
    }
    let above = (0..SIDE * SIDE).filter(|i| {
        let u = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
        frame.to_world(cone.sample(u)).dot(point.geometric_normal) > 0.0
    });
    above.count() as f32 / (SIDE * SIDE) as f32
}
