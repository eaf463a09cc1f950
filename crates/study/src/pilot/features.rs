//! What the rays of a cone meet, in units of voxels: the facts from which the cause of an error is told.

use conray::{Ray, Session, SurfacePoint, Vec3};
use conray_core::Cone;
use conray_voxel::Octree;

/// Rays of a cone whose occluders are looked at.
pub(super) const RAYS_LOOKED_AT: u32 = 64;

/// What blocks the rays of one cone.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OccluderFacts {
    /// Blocked rays looked at.
    pub(crate) hits: u32,
    /// Share of them that meet a surface with an opacity map or a fractional opacity.
    pub(crate) masked: f32,
    /// Share of them that leave the occluder again within a voxel.
    pub(crate) thin: f32,
    /// Mean distance of the occluder from the point, in voxels.
    pub(crate) distance: f32,
    /// Mean height of the occluder above the tangent plane of the point, in voxels.
    pub(crate) height: f32,
}

/// Gathers [`OccluderFacts`].
pub(super) struct Occluders<'a> {
    session: &'a Session,
    point: &'a SurfacePoint,
    voxel: f32,
    sums: OccluderFacts,
}

impl<'a> Occluders<'a> {
    pub(super) fn new(session: &'a Session, point: &'a SurfacePoint) -> Self {
        let voxel = session.octree().map_or(1.0, |octree| octree.voxel_size());
        Self { session, point, voxel, sums: OccluderFacts::default() }
    }

    /// Looks at what blocks a ray; surfaces that let half of the light through do not count.
    pub(super) fn look(&mut self, ray: &Ray) {
        let bvh = self.session.bvh();
        let Some(hit) = bvh.nearest(ray) else { return };
        let geometry = self.session.geometry();
        let mesh = geometry.instances()[hit.instance as usize].mesh as usize;
        let place = ray.origin + hit.t * ray.direction;
        let behind = Ray {
            // Past the surface itself, by far less than a voxel.
            origin: place + 1e-3 * self.voxel * ray.direction,
            direction: ray.direction,
            t_max: self.voxel,
        };
        self.sums.hits += 1;
        self.sums.masked += f32::from(u8::from(!geometry.opacity(mesh).is_opaque()));
        self.sums.thin += f32::from(u8::from(bvh.nearest(&behind).is_some()));
        self.sums.distance += hit.t / self.voxel;
        self.sums.height += (place - self.point.position).dot(self.point.geometric_normal) / self.voxel;
    }

    pub(super) fn facts(&self) -> OccluderFacts {
        let n = self.sums.hits.max(1) as f32;
        let OccluderFacts { hits, masked, thin, distance, height } = self.sums;
        OccluderFacts { hits, masked: masked / n, thin: thin / n, distance: distance / n, height: height / n }
    }
}

/// True where boxes around the cone are empty from the point's own voxels to the AO distance: open for certain.
///
/// The first two voxels hold the surface itself, so a cone is certified only where its lowest direction has left
/// them: what is nearer counts as the surface's own.
pub(super) fn path_is_empty(
    octree: &Octree,
    point: &SurfacePoint,
    axis: Vec3,
    cone: &Cone,
    distance: f32,
) -> bool {
    let lowest = axis.dot(point.geometric_normal).clamp(-1.0, 1.0).acos() + cone.half_angle_rad;
    let rise = (std::f32::consts::FRAC_PI_2 - lowest).sin();
    if rise <= 0.0 {
        return false;
    }
    let reach = distance.min(octree.bounds().diagonal());
    // A cell's corners lie outside the round cone of equal solid angle: at most sqrt(2) as far from the axis.
    let spread = std::f32::consts::SQRT_2 * cone.half_angle_rad.tan();
    let mut near = 2.0 * octree.voxel_size() / rise;
    while near < reach {
        let far = (near * 1.5).min(reach);
        let (a, b) = (point.position + near * axis, point.position + far * axis);
        let pad = Vec3::splat(far * spread);
        if !octree.box_is_empty(a.min(b) - pad, a.max(b) + pad) {
            return false;
        }
        near = far;
    }
    true
}
