//! The octree as plain numbers, as shaders read it.

use crate::{
    Octree,
    level::{Bricks, Level},
};
use bytemuck::{Pod, Zeroable};
use conray_core::Vec3;

/// Words of a brick of leaves: four leaves each.
const LEAF_WORDS: usize = 512 / 4;

/// Where a level's numbers are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct PackedLevel {
    /// Nodes along a side of the cube.
    pub side: u32,
    /// Bricks along a side, with a border of one about the cube.
    pub across: u32,
    /// First of the level's places in the table.
    pub table: u32,
    /// First of the level's words.
    pub words: u32,
}

/// An octree as plain numbers: mean opacities and standard deviations, found as the octree itself finds them.
///
/// A place of the table, x fastest, holds the number of the brick of 8 x 8 x 8 nodes there, 0 where there is none; brick 0 of a level is empty. A brick
/// of leaves, level 0, has 128 words of four opacities in 255ths, the first lowest; a brick above has 512 of a mean in the lower half and
/// an SD in the upper, in 65535ths.
#[derive(Clone, Debug)]
pub struct PackedOctree {
    /// Lowest corner of the cube in world space.
    pub origin: Vec3,
    /// Edge of a leaf in world units.
    pub voxel_size: f32,
    /// Leaves along a side.
    pub resolution: u32,
    /// The levels, leaves first.
    pub levels: Vec<PackedLevel>,
    /// Numbers of bricks.
    pub table: Vec<u32>,
    /// Opacities.
    pub words: Vec<u32>,
}

impl Octree {
    /// The octree as plain numbers, but for the axis opacities, which are left out.
    pub fn packed(&self) -> PackedOctree {
        let mut packed = PackedOctree {
            origin: self.grid.origin,
            voxel_size: self.grid.voxel_size,
            resolution: self.grid.resolution,
            levels: Vec::new(),
            table: Vec::new(),
            words: Vec::new(),
        };
        self.levels.iter().for_each(|level| packed.add(level));
        packed
    }

    /// Words and places of the table that [`Octree::packed`] has.
    pub fn packed_counts(&self) -> [u64; 2] {
        let words = |level: &Level| match &level.bricks {
            Bricks::Leaves(bricks) => (bricks.len() * LEAF_WORDS) as u64,
            Bricks::Nodes(bricks) => 512 * bricks.len() as u64,
        };
        let places = |level: &Level| level.table.numbers.len() as u64;
        [self.levels.iter().map(words).sum(), self.levels.iter().map(places).sum()]
    }
}

impl PackedOctree {
    fn add(&mut self, level: &Level) {
        self.levels.push(PackedLevel {
            side: level.side,
            across: level.table.across,
            table: self.table.len() as u32,
            words: self.words.len() as u32,
        });
        self.table.extend((0..level.table.numbers.len()).map(|index| level.stored(index) as u32));
        match &level.bricks {
            Bricks::Leaves(bricks) => {
                let words = bricks.iter().flat_map(|brick| brick.means.as_chunks::<4>().0);
                self.words.extend(words.map(|&bytes| u32::from_le_bytes(bytes)));
            }
            Bricks::Nodes(bricks) => {
                let moments = bricks.iter().flat_map(|brick| &brick.moments);
                self.words.extend(moments.map(|&[mean, sd]| u32::from(mean) | u32::from(sd) << 16));
            }
        }
    }

    /// Mean and SD of a node in [0, 1], 0 outside: as a shader finds them.
    pub fn mean_sd(&self, level: usize, cell: [u32; 3]) -> [f32; 2] {
        let PackedLevel { side, across, table, words } = self.levels[level];
        if cell.iter().any(|&at| at >= side) {
            return [0.0; 2];
        }
        let [x, y, z] = cell.map(|at| at / 8 + 1);
        let brick = self.table[(table + (z * across + y) * across + x) as usize];
        let [x, y, z] = cell.map(|at| at % 8);
        let node = x | y << 3 | z << 6;
        if level == 0 {
            let word = self.words[(words + brick * LEAF_WORDS as u32 + node / 4) as usize];
            return [(word >> (8 * (node % 4)) & 0xff) as f32 / 255.0, 0.0];
        }
        let word = self.words[(words + brick * 512 + node) as usize];
        [word & 0xffff, word >> 16].map(|half| half as f32 / 65535.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OctreeOptions;
    use conray_core::{Affine3A, Geometry, TriangleMesh, hash_u32};
    use glam::IVec3;

    #[test]
    fn every_node_is_that_of_the_octree() {
        let random = |i: u32| hash_u32(i) as f32 / u32::MAX as f32;
        let corners =
            (0..60).map(|i| Vec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2))).collect();
        let triangles = (0..20).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(TriangleMesh::new(corners, triangles).unwrap()).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        let options = OctreeOptions { resolution: 32, ..Default::default() };
        let octree = Octree::build(&geometry, &options).unwrap();
        let packed = octree.packed();
        assert_eq!(octree.packed_counts(), [packed.words.len() as u64, packed.table.len() as u64]);
        let mut occupied = 0;
        for (level, &PackedLevel { side, .. }) in packed.levels.iter().enumerate() {
            for at in 0..side.pow(3) {
                let cell = [at % side, at / side % side, at / side / side];
                let (mean, sd) = octree.mean_sd(level as u32, IVec3::from(cell.map(|at| at as i32)));
                let found = packed.mean_sd(level, cell);
                assert!((found[0] - mean).abs() < 1e-6 && (found[1] - sd).abs() < 1e-6, "{level} {cell:?}");
                occupied += u32::from(mean > 0.0);
            }
        }
        assert!(occupied > 1000);
        assert_eq!(packed.mean_sd(0, [32, 0, 0]), [0.0; 2]);
    }
}
