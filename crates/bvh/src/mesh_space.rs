//! The way from the world into a mesh's space, with what is lost on it.

use crate::placement::{abs_matrix, wide_matrix};
use conray_core::{Affine3A, Bounds, Vec3, gamma};
use glam::{DMat3, DVec3, Mat3};

/// The way from the world into a mesh's space, with what is lost on it.
///
/// Only boxes are tested there, triangles never: so the way may be inexact as long as `slack` covers it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshSpace {
    pub(crate) mesh_from_world: DMat3,
    /// Subtracted from world positions first.
    pub(crate) translation: DVec3,
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
    pub(crate) fn slack(&self, origin: DVec3) -> DVec3 {
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
