//! Exact emptiness of boxes.

use crate::Octree;
use conray_core::Vec3;
use glam::IVec3;

impl Octree {
    /// True only where no triangle touches the box from `min` to `max`, in world space.
    ///
    /// Exact but for the size of a leaf: false where a triangle touches a leaf that the box touches. True for a box
    /// with `min > max` on an axis; false where a coordinate is NaN.
    pub fn box_is_empty(&self, min: Vec3, max: Vec3) -> bool {
        if min.is_nan() || max.is_nan() {
            return false;
        }
        if min.cmpgt(max).any() {
            return true;
        }
        // Single-precision rounding of a position is at most this, in leaves; infinite corners are held at the cube.
        let slack = Vec3::splat(1e-3);
        let side = Vec3::splat(self.grid.resolution as f32);
        let low = (self.leaf_units(min) - slack).clamp(Vec3::NEG_ONE, side);
        let high = (self.leaf_units(max) + slack).clamp(Vec3::NEG_ONE, side);
        let leaves = IVec3::splat(self.grid.resolution as i32 - 1);
        let (low, high) = (low.floor().as_ivec3().max(IVec3::ZERO), high.floor().as_ivec3().min(leaves));
        let top = self.levels.len() as u32 - 1;
        low.cmpgt(high).any() || self.node_is_empty(top, IVec3::ZERO, low, high)
    }

    /// True where no occupied leaf of the node lies between `low` and `high`, both included.
    fn node_is_empty(&self, level: u32, cell: IVec3, low: IVec3, high: IVec3) -> bool {
        let first = cell << level as i32;
        let last = first + (1 << level) - 1;
        if first.cmpgt(high).any() || last.cmplt(low).any() || self.is_empty(level, cell) {
            return true;
        }
        let is_inside = first.cmpge(low).all() && last.cmple(high).all();
        if level == 0 || is_inside {
            return false;
        }
        (0..8).all(|c| {
            let child = 2 * cell + IVec3::new(c & 1, c >> 1 & 1, c >> 2);
            self.node_is_empty(level - 1, child, low, high)
        })
    }
}
