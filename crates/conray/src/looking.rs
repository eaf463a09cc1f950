//! One surface point looked at closely: where its rays go.

use crate::Session;
use conray_core::{Frame, Ray, SurfacePoint, Vec3, cosine_hemisphere, hash_u32, owen_sobol_2d};

/// A ray of a surface point and what it met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayView {
    /// Its unit direction, in world space.
    pub direction: Vec3,
    /// How far the first surface on its way is, in world units, that lies within the AO distance and blocks at least half of the light; 0 where the point's own surface is in the way.
    /// `None` where it is open.
    pub hit: Option<f32>,
}

impl Session {
    /// The first rays of a point's sequence by the plan's seed, over the whole hemisphere: those of method `rays` where neither falloff, spread nor bias
    /// angle is set.
    pub fn rays_at(&self, point: &SurfacePoint, count: u32) -> Vec<RayView> {
        let (frame, origin) = (Frame::from_normal(point.shading_normal), point.ray_origin());
        let sequence = hash_u32(point.id ^ hash_u32(self.plan.seed));
        let one = |index| {
            let direction = frame.to_world(cosine_hemisphere(owen_sobol_2d(index, sequence)));
            let ray = Ray { origin, direction, t_max: self.plan.distance };
            let below = direction.dot(point.geometric_normal) <= 0.0;
            let hit = if below { Some(0.0) } else { self.bvh.nearest(&ray).map(|hit| hit.t) };
            RayView { direction, hit }
        };
        if point.is_valid() { (0..count).map(one).collect() } else { Vec::new() }
    }
}
