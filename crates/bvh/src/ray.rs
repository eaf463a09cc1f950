//! What is worked out once per ray: the shear of the triangle test and the slabs of the box test.

use crate::mesh_space::MeshSpace;
use conray_core::{Ray, Vec3, gamma};

/// Components of a direction below this share of the largest count as zero: they move a hit by less than any
/// coordinate's rounding, and their reciprocals stay finite.
const NEGLIGIBLE: f32 = 1e-30;

/// A ray that can hit something, with the shear that takes it to the z axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedRay {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Axes in the order (x, y, z) of the sheared space: z is the direction's largest component.
    pub(crate) axes: [usize; 3],
    /// `d_x / d_z`, `d_y / d_z` and `1 / d_z`.
    pub(crate) shear: [f32; 3],
    pub(crate) t_max: f32,
}

impl PreparedRay {
    /// `None` where the ray can hit nothing: a member is NaN, the origin or the direction infinite, the direction zero
    /// (or off unit length by a factor of 1e15), or `t_max` not above zero.
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        let size = ray.direction.abs();
        let z = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let largest = size[z];
        let usable = ray.origin.is_finite()
            && ray.direction.is_finite()
            && (1e-15..=1e15).contains(&largest)
            && ray.t_max > 0.0;
        if !usable {
            return None;
        }
        let kept = |d: f32| if d.abs() < NEGLIGIBLE * largest { 0.0 } else { d };
        let direction = Vec3::new(kept(ray.direction.x), kept(ray.direction.y), kept(ray.direction.z));
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let d = axes.map(|a| direction[a]);
        let shear = [d[0] / d[2], d[1] / d[2], 1.0 / d[2]];
        Some(Self { origin: ray.origin, direction, axes, shear, t_max: ray.t_max })
    }
}

/// The box test's view of a ray: `t = (plane - origin) * inverse`, sixteen boxes at once.
///
/// Rounding makes a computed `t` err by at most `gamma(3)` of itself, so scaling the far one by `1 + 2 gamma(3)` keeps
/// every box that the ray truly meets (Ize, "Robust BVH Ray Traversal", 2013). Where the origin itself is uncertain
/// by `slack` per axis (in a mesh's space), near and far planes get origins of their own, each moved so that the box
/// grows. Comparisons are such that NaN means "visit": it arises only where a ray lies in a box's plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slab {
    pub(crate) near_origin: [f32; 3],
    pub(crate) far_origin: [f32; 3],
    pub(crate) inverse: [f32; 3],
    /// Which plane of an axis is near: 0 the lowest, 1 the highest.
    pub(crate) near_side: [usize; 3],
}

impl Slab {
    /// Grows far distances by the rounding of the box test.
    pub(crate) const FAR: f32 = 1.0 + 2.0 * gamma(3);

    /// For boxes in world space.
    #[inline]
    pub(crate) fn in_world(ray: &PreparedRay) -> Self {
        let origin = ray.origin.to_array();
        let inverse = ray.direction.to_array().map(|d| 1.0 / d);
        Self {
            near_origin: origin,
            far_origin: origin,
            inverse,
            near_side: inverse.map(|i| usize::from(i < 0.0)),
        }
    }

    /// For boxes in a mesh's space; the slab that meets every box where that space is no use.
    #[inline]
    pub(crate) fn in_mesh(ray: &PreparedRay, space: Option<&MeshSpace>) -> Self {
        let Some(space) = space else { return Self::EVERYTHING };
        let origin = space.mesh_from_world * (ray.origin.as_dvec3() - space.translation);
        let direction = space.mesh_from_world * ray.direction.as_dvec3();
        let slack = space.slack(origin);
        let (mut slab, far) = (Self::EVERYTHING, origin.abs().max_element() + slack.max_element());
        if far > f64::from(f32::MAX) {
            return slab;
        }
        for axis in 0..3 {
            // The sign is that of the reciprocal: a component of -0 has one too, and its planes come in that order.
            let inverse = (1.0 / direction[axis]) as f32;
            let outward = if inverse < 0.0 { -slack[axis] } else { slack[axis] };
            slab.near_origin[axis] = (origin[axis] + outward) as f32;
            slab.far_origin[axis] = (origin[axis] - outward) as f32;
            slab.inverse[axis] = inverse;
            slab.near_side[axis] = usize::from(inverse < 0.0);
        }
        slab
    }

    /// Meets every box: all its distances are NaN.
    const EVERYTHING: Self =
        Self { near_origin: [0.0; 3], far_origin: [0.0; 3], inverse: [f32::NAN; 3], near_side: [0; 3] };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(direction: Vec3, t_max: f32) -> Ray {
        Ray { origin: Vec3::ZERO, direction, t_max }
    }

    #[test]
    fn unusable_rays_are_refused() {
        assert!(PreparedRay::new(&ray(Vec3::Z, 1.0)).is_some());
        assert!(PreparedRay::new(&ray(Vec3::Z, f32::INFINITY)).is_some());
        for direction in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(1.0, f32::NAN, 0.0)] {
            assert!(PreparedRay::new(&ray(direction, 1.0)).is_none(), "{direction}");
        }
        for t_max in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
            assert!(PreparedRay::new(&ray(Vec3::Z, t_max)).is_none(), "{t_max}");
        }
        assert!(PreparedRay::new(&Ray { origin: Vec3::NAN, ..ray(Vec3::Z, 1.0) }).is_none());
    }

    #[test]
    fn the_shear_takes_the_direction_to_the_z_axis() {
        for d in [Vec3::new(0.6, 0.0, -0.8), Vec3::new(-0.8, 0.6, 0.0), Vec3::new(1e-35, 1.0, -0.1)] {
            let r = PreparedRay::new(&ray(d, 1.0)).unwrap();
            let p = r.axes.map(|a| r.direction[a]);
            assert!((p[0] - r.shear[0] * p[2]).abs() < 1e-7 && (p[1] - r.shear[1] * p[2]).abs() < 1e-7);
            assert!((p[2] * r.shear[2] - 1.0).abs() < 1e-6);
            assert!(p[2].abs() >= p[0].abs().max(p[1].abs()));
        }
    }
}
