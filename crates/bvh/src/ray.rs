//! What is worked out once per ray: the shear of the triangle test and the slabs of the box test.

use crate::placement::{abs_matrix, wide_matrix};
use conray_core::{Affine3A, Bounds, Ray, Vec3, gamma};
use glam::{DMat3, DVec3, Mat3};

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

/// The way from the world into a mesh's space, with what is lost on it.
///
/// Only boxes are tested there, triangles never: so the way may be inexact as long as `slack` covers it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshSpace {
    mesh_from_world: DMat3,
    /// Subtracted from world positions first.
    translation: DVec3,
    /// Slack that does not depend on the ray, per axis.
    fixed_slack: DVec3,
    /// Largest coordinate of the mesh.
    reach: f64,
}

impl MeshSpace {
    /// How well the inverse must undo the transform, per element.
    const RESIDUAL: f64 = 1.0 / (1u32 << 28) as f64;

    /// `None` where the transform is singular or too near to it.
    pub(crate) fn new(world_from_mesh: &Affine3A, mesh_bounds: &Bounds) -> Option<Self> {
        let (matrix, translation) = wide_matrix(world_from_mesh);
        let mesh_from_world = matrix.inverse();
        let residual = mesh_from_world * matrix - DMat3::IDENTITY;
        let worst = residual.abs_diff_eq(DMat3::ZERO, Self::RESIDUAL);
        if !worst {
            return None;
        }
        let corner = mesh_bounds.min.as_dvec3().abs().max(mesh_bounds.max.as_dvec3().abs());
        let fixed_slack = abs_matrix(&mesh_from_world) * corner_rounding(world_from_mesh, mesh_bounds);
        let reach = corner.max_element();
        (fixed_slack.is_finite() && reach.is_finite()).then_some(Self {
            mesh_from_world,
            translation,
            fixed_slack,
            reach,
        })
    }

    /// How far, per axis, the ray in the mesh's space may be from where it ought to be.
    ///
    /// Three parts: the rounding of the mesh's world corners, taken back (`fixed_slack`); the rounding of the origin to
    /// single precision, with a factor of 4 to spare; and the inverse's own error, a share [`Self::RESIDUAL`] of the
    /// positions that occur along the ray as far as the mesh reaches, twice over for three axes and with a factor of 4/3
    /// to spare.
    fn slack(&self, origin: DVec3) -> DVec3 {
        let rounding = origin.abs() * f64::from(2.0 * f32::EPSILON);
        let inverse = 8.0 * Self::RESIDUAL * (origin.abs().max_element() + self.reach);
        self.fixed_slack + rounding + DVec3::splat(inverse + f64::from(f32::MIN_POSITIVE))
    }
}

/// What a bundle of rays needs to be taken into a mesh's space; see [`MeshSpace`].
pub(crate) struct BundleSpace {
    pub(crate) mesh_from_world: Mat3,
    pub(crate) origin: Vec3,
    /// How far, per axis, any point of a ray may be from where it ought to be, for rays as long as the mesh is far.
    pub(crate) slack: Vec3,
    /// What heights over the surface are measured along: `normal . mesh position` has the sign of the world's.
    pub(crate) normal: Vec3,
    /// Bound on the squared factor by which lengths grow on the way into the mesh's space.
    pub(crate) stretch_squared: f32,
}

impl MeshSpace {
    /// The way of a bundle from `origin`; `None` where it leads beyond single precision.
    ///
    /// Directions are transformed in single precision. That moves a point at distance t by a few roundings of t times the
    /// transform's norm; on the way to a mesh as far as `farthest` in its own space, t is at most that times the norm of
    /// the way back. `None` also where the product of the norms, which says how much the transform distorts, is so large
    /// that boxes would grow beyond use.
    pub(crate) fn bundle(&self, origin: Vec3, normal: Vec3) -> Option<BundleSpace> {
        let from_world = self.mesh_from_world;
        let to_world = from_world.inverse();
        let norm_squared =
            |m: &DMat3| m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared();
        let stretch_squared = norm_squared(&from_world);
        let distortion = (stretch_squared * norm_squared(&to_world)).sqrt();
        let at = from_world * (origin.as_dvec3() - self.translation);
        let farthest = at.abs().max_element() + self.reach;
        let rounded = 4.0 * f64::from(f32::EPSILON) * distortion * farthest;
        let slack = self.slack(at) + DVec3::splat(rounded);
        let towards = to_world.transpose() * normal.as_dvec3();
        let usable = farthest < 1e18
            && (1e-24..1e24).contains(&stretch_squared)
            && distortion < 1e4
            && towards.is_finite();
        usable.then(|| BundleSpace {
            mesh_from_world: from_world.as_mat3(),
            origin: at.as_vec3(),
            slack: slack.as_vec3() * (1.0 + f32::EPSILON),
            normal: towards.normalize_or_zero().as_vec3(),
            stretch_squared: (stretch_squared * 1.0001) as f32,
        })
    }
}

/// Bound, per axis, on how far a mesh's world corners lie from their exactly transformed places: three products and
/// three sums.
pub(crate) fn corner_rounding(world_from_mesh: &Affine3A, mesh_bounds: &Bounds) -> DVec3 {
    let (matrix, translation) = wide_matrix(world_from_mesh);
    let corner = mesh_bounds.min.as_dvec3().abs().max(mesh_bounds.max.as_dvec3().abs());
    f64::from(gamma(4)) * (abs_matrix(&matrix) * corner + translation.abs())
        + DVec3::splat(8.0 * f64::from(f32::from_bits(1)))
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

    #[test]
    fn singular_placements_have_no_mesh_space() {
        let bounds = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE };
        for scale in [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0)] {
            assert!(MeshSpace::new(&Affine3A::from_scale(scale), &bounds).is_none());
        }
        for scale in [Vec3::splat(1e-6), Vec3::splat(1e6), Vec3::new(-1.0, 1e4, 1e-4)] {
            assert!(MeshSpace::new(&Affine3A::from_scale(scale), &bounds).is_some());
        }
    }
}
