//! Leaving out look-ups in empty space.

use crate::{Octree, lookup::Taps};
use conray_core::Vec3;

/// How many levels coarser than the samples empty space is looked for.
const COARSER: usize = 3;

/// A box in leaf units that no triangle touches.
pub(crate) struct EmptyBlock {
    low: Vec3,
    high: Vec3,
}

impl EmptyBlock {
    /// Holds nothing.
    pub(crate) const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// True where a sample's filter lies in the box: it reaches 1.5 nodes of the coarser of its two levels.
    #[inline]
    pub(crate) fn holds(&self, position: Vec3, level: f32) -> bool {
        let reach = Vec3::splat(1.5 * (1u32 << (level.ceil() as u32)) as f32);
        (position - reach).cmpge(self.low).all() && (position + reach).cmple(self.high).all()
    }
}

impl Octree {
    /// The eight nodes nearest to a position some levels above `level`, if no triangle touches them.
    pub(crate) fn empty_block(&self, position: Vec3, level: f32) -> EmptyBlock {
        let level = (level.ceil() as usize + COARSER).min(self.levels.len() - 1);
        let nodes = &self.levels[level];
        let Some(taps) = Taps::new(position, level, nodes.side) else { return EmptyBlock::NONE };
        if !taps.is_empty(nodes) {
            return EmptyBlock::NONE;
        }
        let edge = (1u32 << level) as f32;
        let low = taps.low().as_vec3() * edge;
        EmptyBlock { low, high: low + 2.0 * edge }
    }
}
