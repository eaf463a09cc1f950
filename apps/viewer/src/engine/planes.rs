//! From estimates, listed in the order of their points, to planes of pixels.

use super::report::{ConePlanes, Plane};
use crate::camera::Look;
use conray::{
    ConeEstimate, Estimate, SurfacePoint, Vec3,
    target::{CameraTarget, Target},
};
use std::sync::Arc;

/// How surfaces face the camera: what a lamp at the eye would show.
#[derive(Clone, Debug, Default)]
pub(super) struct Facing {
    /// Cosine between shading normal and sight, in [0, 1]; NaN where nothing is seen.
    pub(super) plane: Plane,
}

impl Facing {
    pub(super) fn of(target: &CameraTarget, look: &Look) -> Self {
        let (camera, eye) = (target.camera(), Vec3::from(look.eye));
        let size = [camera.width(), camera.height()];
        let facing = |point: &SurfacePoint| {
            (eye - point.position).normalize_or_zero().dot(point.shading_normal).clamp(0.0, 1.0)
        };
        let values = target.points().iter().map(|point| (point.id, facing(point)));
        Self { plane: scattered(size, values) }
    }
}

/// All planes of some estimates.
pub(super) struct EstimatePlanes {
    pub(super) visibility: Plane,
    pub(super) error: Plane,
    pub(super) rays: Plane,
    pub(super) cones: Option<ConePlanes>,
}

pub(super) fn of_estimates(
    points: &[SurfacePoint],
    estimates: &[Estimate],
    size: [u32; 2],
) -> EstimatePlanes {
    let plane = |value: &dyn Fn(&Estimate) -> f32| {
        scattered(size, points.iter().zip(estimates).map(|(point, e)| (point.id, value(e))))
    };
    let of_cones = |value: fn(&ConeEstimate) -> f32| plane(&|e| e.cone.as_ref().map_or(f32::NAN, value));
    let marched = estimates.iter().any(|e| e.cone.is_some());
    EstimatePlanes {
        visibility: plane(&|e| e.visibility),
        error: plane(&|e| e.error),
        rays: plane(&|e| e.rays as f32),
        cones: marched.then(|| ConePlanes {
            visibility: of_cones(|c| c.visibility),
            error: of_cones(|c| c.error),
            alpha: of_cones(|c| c.alpha),
        }),
    }
}

/// Values at their pixels, NaN elsewhere.
fn scattered([width, height]: [u32; 2], values: impl Iterator<Item = (u32, f32)>) -> Plane {
    let mut plane = vec![f32::NAN; width as usize * height as usize];
    for (pixel, value) in values {
        plane[pixel as usize] = value;
    }
    Arc::new(plane)
}
