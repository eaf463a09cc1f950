//! Rays that leave one surface point, and the tally of what they met.

use crate::AoPlan;
use conray_bvh::Bvh;
use conray_core::{Frame, Ray, SurfacePoint, Vec3};

/// All that the rays of a point share.
pub(crate) struct PointRays<'a> {
    plan: &'a AoPlan,
    bvh: &'a Bvh,
    frame: Frame,
    geometric_normal: Vec3,
    origin: Vec3,
}

impl<'a> PointRays<'a> {
    pub(crate) fn new(plan: &'a AoPlan, bvh: &'a Bvh, point: &SurfacePoint) -> Self {
        Self {
            plan,
            bvh,
            frame: Frame::from_normal(point.shading_normal),
            geometric_normal: point.geometric_normal,
            origin: point.ray_origin(),
        }
    }

    /// Traces one ray, its direction given about the shading normal, into a tally.
    ///
    /// Below the geometric surface the point's own surface is in the way.
    #[inline]
    pub(crate) fn trace(&self, local: Vec3, tally: &mut Tally) {
        let direction = self.frame.to_world(local);
        let visibility = if direction.dot(self.geometric_normal) > 0.0 {
            let ray = Ray { origin: self.origin, direction, t_max: self.plan.distance };
            self.bvh.visibility(&ray, self.plan.falloff, self.plan.distance)
        } else {
            0.0
        };
        tally.add(visibility, direction);
    }
}

/// Sums over rays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    /// Rays traced.
    pub(crate) rays: u32,
    /// Sum of visibilities.
    sum: f32,
    /// Sum of squared visibilities.
    squares: f32,
    /// Sum of directions, each times its visibility.
    pub(crate) open: Vec3,
}

impl Tally {
    #[inline]
    pub(super) fn add(&mut self, visibility: f32, direction: Vec3) {
        self.rays += 1;
        self.sum += visibility;
        self.squares += visibility * visibility;
        self.open += visibility * direction;
    }

    /// Mean visibility; 0 without rays.
    pub(crate) fn mean(&self) -> f32 {
        self.sum / self.rays.max(1) as f32
    }

    /// Variance of the mean, as of independent rays.
    ///
    /// One open and one closed ray are added (the rule of succession), so that few rays that agree do not claim
    /// certainty. Stratified rays err less than this says.
    pub(crate) fn variance_of_mean(&self) -> f32 {
        let n = self.rays as f32 + 2.0;
        let mean = (self.sum + 1.0) / n;
        let variance = ((self.squares + 1.0) / n - mean * mean).max(0.0);
        variance / self.rays.max(1) as f32
    }
}
