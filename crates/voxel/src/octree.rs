//! The octree itself: facts, and nodes one by one.

use crate::{OctreeStats, grid::Grid, level::Level};
use conray_core::{Bounds, Vec3};
use glam::IVec3;

/// A sparse voxel octree of opacities.
///
/// Immutable once built, and the same for any number of threads. Positions are in world space; a cell is a node's
/// place in its level, `0 <= x, y, z < resolution >> level`. What lies outside the cube is empty.
#[derive(Clone)]
pub struct Octree {
    pub(crate) grid: Grid,
    /// Leaves first, the cube as one node last.
    pub(crate) levels: Vec<Level>,
    pub(crate) peak_bytes: u64,
}

impl std::fmt::Debug for Octree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Octree").field("grid", &self.grid).field("stats", &self.stats()).finish()
    }
}

impl Octree {
    /// Lowest corner of the cube, in world space.
    pub fn origin(&self) -> Vec3 {
        self.grid.origin
    }

    /// Edge of a leaf in world units.
    pub fn voxel_size(&self) -> f32 {
        self.grid.voxel_size
    }

    /// Leaves along a side of the cube: what was asked for, or less where memory was limited.
    pub fn resolution(&self) -> u32 {
        self.grid.resolution
    }

    /// How many levels there are: level 0 holds the leaves, level `levels() - 1` the cube as one node.
    pub fn levels(&self) -> u32 {
        self.levels.len() as u32
    }

    /// The cube.
    pub fn bounds(&self) -> Bounds {
        let side = self.grid.voxel_size * self.grid.resolution as f32;
        Bounds { min: self.grid.origin, max: self.grid.origin + side }
    }

    /// True where nodes keep an opacity for each axis.
    pub fn is_directional(&self) -> bool {
        !self.levels[0].axes.is_empty()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> u64 {
        self.levels.iter().map(Level::memory_bytes).sum()
    }

    /// Facts for a report; counts every node once.
    pub fn stats(&self) -> OctreeStats {
        let ones = |level: &Level| -> u64 {
            let words = (1..=level.codes.len() as u32).flat_map(|b| level.occupied(b));
            words.map(|word| u64::from(word.count_ones())).sum()
        };
        OctreeStats {
            resolution: self.grid.resolution,
            voxel_size: self.grid.voxel_size,
            occupied: self.levels.iter().map(ones).collect(),
            bricks: self.levels.iter().map(|level| level.codes.len() as u64).collect(),
            memory_bytes: self.memory_bytes(),
            peak_bytes: self.peak_bytes,
        }
    }

    /// Mean and standard deviation of the opacities of a node's leaves, each in [0, 1]; the SD is at most 1/2.
    ///
    /// Zero for cells and levels that do not exist.
    pub fn mean_sd(&self, level: u32, cell: IVec3) -> (f32, f32) {
        let Some((level, brick, index)) = self.find(level, cell) else { return (0.0, 0.0) };
        level.mean_sd(brick, index)
    }

    /// True where no triangle touches the node. Triangles whose material lets everything through do not count.
    ///
    /// True for cells and levels that do not exist.
    pub fn is_empty(&self, level: u32, cell: IVec3) -> bool {
        self.find(level, cell).is_none_or(|(level, brick, index)| !level.is_occupied(brick, index))
    }

    /// Opacity of a node across x, y and z, each in [0, 1]; `None` unless built with
    /// [`crate::OctreeOptions::directional`]. Zero for cells and levels that do not exist.
    pub fn axis_opacities(&self, level: u32, cell: IVec3) -> Option<Vec3> {
        self.is_directional().then(|| {
            self.find(level, cell)
                .map_or(Vec3::ZERO, |(level, brick, index)| level.axis_opacities(brick, index))
        })
    }

    fn find(&self, level: u32, cell: IVec3) -> Option<(&Level, u32, usize)> {
        let level = self.levels.get(level as usize)?;
        let inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(IVec3::splat(level.side as i32)).all();
        let (brick, index) = if inside { level.find(cell.as_uvec3())? } else { return None };
        Some((level, brick, index))
    }
}
