//! Where the leaves lie in the world.

use crate::VoxelError;
use conray_core::Vec3;
use glam::{DAffine3, DVec3};

/// The cube of leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Lowest corner in world space.
    pub(crate) origin: Vec3,
    /// Edge of a leaf in world units.
    pub(crate) voxel_size: f32,
    /// Leaves along a side: a power of two.
    pub(crate) resolution: u32,
}

impl Grid {
    /// The cube about a box, with the box's lowest corner 1.5 voxels inside.
    ///
    /// So the lowest walls of an axis-aligned room, and on the longest axis the highest too, pass through the middle
    /// of a layer of voxels rather than between two.
    pub(crate) fn around(min: DVec3, max: DVec3, resolution: u32) -> Result<Self, VoxelError> {
        let longest = (max - min).max_element();
        if longest.is_nan() || longest <= 0.0 {
            return Err(VoxelError::NoExtent);
        }
        let n = f64::from(resolution);
        let mut voxel_size = ((longest / (n - 3.0)) as f32).max(f32::MIN_POSITIVE);
        // Far from the origin the corner's rounding may exceed the padding: larger voxels until the box fits.
        loop {
            let origin = (min - 1.5 * f64::from(voxel_size)).as_vec3();
            let grid = Self { origin, voxel_size, resolution };
            if !(origin + Vec3::splat(voxel_size * resolution as f32)).is_finite() || !origin.is_finite() {
                return Err(VoxelError::TooLarge(longest));
            }
            let (low, high) = (grid.cells_from_world(min), grid.cells_from_world(max));
            if low.min_element() >= 1.0 && high.max_element() <= n - 1.0 {
                return Ok(grid);
            }
            voxel_size *= 1.25;
        }
    }

    /// World position in units of leaves from the cube's corner.
    pub(crate) fn cells_from_world(&self, position: DVec3) -> DVec3 {
        (position - self.origin.as_dvec3()) / f64::from(self.voxel_size)
    }

    /// The same for the coordinates of an instance's mesh, in double precision.
    pub(crate) fn cells_from_mesh(&self, world_from_mesh: &conray_core::Affine3A) -> DAffine3 {
        let m = world_from_mesh;
        let size = f64::from(self.voxel_size);
        DAffine3 {
            matrix3: glam::DMat3::from_cols(
                m.matrix3.x_axis.as_dvec3() / size,
                m.matrix3.y_axis.as_dvec3() / size,
                m.matrix3.z_axis.as_dvec3() / size,
            ),
            translation: self.cells_from_world(m.translation.as_dvec3()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_lies_inside_at_any_scale_and_place() {
        let offsets = [DVec3::ZERO, DVec3::new(148_376.0, 1234.0, -223_423.0), DVec3::splat(1e30)];
        for offset in offsets {
            for size in [1e-30, 1e-3, 1.0, 1e6, 1e30] {
                for resolution in [16, 512, 2048] {
                    let (min, max) = (offset, offset + DVec3::new(size, 0.5 * size, 0.0));
                    // Sizes below the spacing of doubles vanish.
                    let Ok(grid) = Grid::around(min, max, resolution) else {
                        assert_eq!(offset.x + size, offset.x);
                        continue;
                    };
                    let (low, high) = (grid.cells_from_world(min), grid.cells_from_world(max));
                    assert!(low.min_element() >= 1.0, "{low} {grid:?}");
                    assert!(high.max_element() <= f64::from(resolution) - 1.0, "{high} {grid:?}");
                }
            }
        }
    }

    #[test]
    fn walls_pass_through_the_middle_of_voxels() {
        let grid = Grid::around(DVec3::ZERO, DVec3::splat(2.0), 64).unwrap();
        assert!((grid.cells_from_world(DVec3::ZERO) - 1.5).abs().max_element() < 1e-4);
        assert!((grid.cells_from_world(DVec3::splat(2.0)) - 62.5).abs().max_element() < 1e-4);
    }

    #[test]
    fn no_extent_and_too_much_are_refused() {
        assert_eq!(Grid::around(DVec3::ONE, DVec3::ONE, 16), Err(VoxelError::NoExtent));
        assert_eq!(Grid::around(DVec3::INFINITY, DVec3::NEG_INFINITY, 16), Err(VoxelError::NoExtent));
        assert_eq!(Grid::around(DVec3::NAN, DVec3::NAN, 16), Err(VoxelError::NoExtent));
        let far = DVec3::splat(3e38);
        assert!(matches!(Grid::around(-far, far, 16), Err(VoxelError::TooLarge(_))));
    }
}
