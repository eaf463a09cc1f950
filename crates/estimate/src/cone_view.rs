//! What the cones of one point say, one by one: for studies and for looking inside.

use crate::{
    AoPlan,
    methods::{Marches, cone_share, ray_count},
};
use conray_bvh::Level;
use conray_core::{Cone, SurfacePoint, Vec3};
use conray_voxel::Octree;

/// One cone of a point, as marched, and what the published blend makes of it.
#[derive(Clone, Copy, Debug)]
pub struct ConeView<'a> {
    /// The cone, about the shading normal; its weight and its directions.
    pub cone: &'a Cone,
    /// Its axis in world space.
    pub axis: Vec3,
    /// Visibility as marched, in [0, 1].
    pub visibility: f32,
    /// Cone error (epsilon), 0 or more; infinite for a cone that could not be marched.
    pub error: f32,
    /// The published blend's alpha before rounding: equation 1.
    pub alpha: f32,
    /// Rays that the published blend sends into it: equation 2, rounded.
    pub rays: u32,
}

/// Looks at the cones of points, one after the other.
pub struct ConeViews<'a> {
    plan: &'a AoPlan,
    marches: Marches<'a>,
}

impl<'a> ConeViews<'a> {
    /// Prepares the plan's cones once for all points.
    pub fn new(plan: &'a AoPlan, octree: &'a Octree) -> Self {
        Self { plan, marches: Marches::new(plan, octree, Level::new()) }
    }

    /// Marches the cones of a point, in the plan's order.
    pub fn at(&self, point: &SurfacePoint) -> impl Iterator<Item = ConeView<'a>> + use<'a> {
        let plan = self.plan;
        let results = self.marches.march(std::slice::from_ref(point));
        self.marches.of(point, results).map(move |(cone, axis, result)| {
            let alpha = cone_share(&result, plan);
            let rays = ray_count(alpha, plan.max_rays);
            ConeView { cone, axis, visibility: result.visibility, error: result.error, alpha, rays }
        })
    }
}
