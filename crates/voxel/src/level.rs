//! How one level's nodes are stored: sparse bricks of 8 x 8 x 8 nodes, found through a table of all their places.

use crate::{filter_bits::FilterBits, morton, plain::PlainNodes};
use glam::UVec3;

/// 512 leaves.
#[derive(Clone)]
pub(crate) struct LeafBrick {
    /// Opacity in 255ths.
    pub(crate) means: [u8; 512],
    /// One bit a leaf: whether a triangle touches it.
    pub(crate) occupied: [u64; 8],
}

impl LeafBrick {
    pub(crate) const EMPTY: Self = Self { means: [0; 512], occupied: [0; 8] };
}

/// 512 nodes above the leaves.
#[derive(Clone)]
pub(crate) struct NodeBrick {
    /// Mean and SD in 65535ths.
    pub(crate) moments: [[u16; 2]; 512],
    /// One bit a node: whether a triangle touches it.
    pub(crate) occupied: [u64; 8],
}

impl NodeBrick {
    pub(crate) const EMPTY: Self = Self { moments: [[0; 2]; 512], occupied: [0; 8] };
}

/// A level's bricks, of which kind depends on the level.
#[derive(Clone)]
pub(crate) enum Bricks {
    Leaves(Vec<LeafBrick>),
    Nodes(Vec<NodeBrick>),
}

impl Bricks {
    /// Mean and SD of a node of a brick, in 65535ths.
    #[inline(always)]
    pub(crate) fn moments(&self, brick: usize, index: usize) -> [u16; 2] {
        match self {
            // 65535 = 257 * 255; a leaf has no SD.
            Self::Leaves(leaves) => [257 * u16::from(leaves[brick].means[index]), 0],
            Self::Nodes(nodes) => nodes[brick].moments[index],
        }
    }
}

/// All nodes of one size.
#[derive(Clone)]
pub(crate) struct Level {
    /// Nodes along a side of the cube.
    pub(crate) side: u32,
    /// Morton codes of the bricks, ascending, in the order in which they are stored.
    pub(crate) codes: Vec<u32>,
    /// Numbers of bricks, and of the blocks of `filter`: those with a brick have its number, the rest higher ones.
    pub(crate) table: BrickTable,
    /// Brick number 0 is empty; it stands for all places without a brick.
    pub(crate) bricks: Bricks,
    /// Opacity across x, y and z in 255ths, for each brick but number 0; empty unless asked for.
    pub(crate) axes: Vec<[[u8; 3]; 512]>,
    /// Where filters meet nothing.
    pub(crate) filter: FilterBits,
    /// All nodes of a small level.
    pub(crate) plain: Option<PlainNodes>,
}

/// Index of a node within its brick.
#[inline]
pub(crate) fn cell_in_brick(local: UVec3) -> usize {
    (local.x | local.y << 3 | local.z << 6) as usize
}

impl Level {
    /// A level of those bricks, with its tables.
    pub(crate) fn new(side: u32, codes: Vec<u32>, bricks: Bricks, axes: Vec<[[u8; 3]; 512]>) -> Self {
        let table = BrickTable::new(side, &codes);
        let plain = PlainNodes::new(side, &codes, &bricks);
        let mut level = Self { side, codes, table, bricks, axes, filter: FilterBits::Blocks(vec![]), plain };
        FilterBits::add_to(&mut level);
        level
    }

    /// Bricks along a side.
    pub(crate) fn bricks_per_side(side: u32) -> u32 {
        side.div_ceil(8)
    }

    /// Whether a triangle touches the node of that index in a brick.
    #[inline]
    pub(crate) fn is_occupied(&self, brick: u32, index: usize) -> bool {
        self.occupied(brick)[index / 64] >> (index % 64) & 1 == 1
    }

    /// A brick's bits.
    #[inline]
    pub(crate) fn occupied(&self, brick: u32) -> &[u64; 8] {
        match &self.bricks {
            Bricks::Leaves(leaves) => &leaves[brick as usize].occupied,
            Bricks::Nodes(nodes) => &nodes[brick as usize].occupied,
        }
    }

    /// Mean and SD of a node, in [0, 1].
    #[inline]
    pub(crate) fn mean_sd(&self, brick: u32, index: usize) -> (f32, f32) {
        match &self.bricks {
            Bricks::Leaves(leaves) => (f32::from(leaves[brick as usize].means[index]) * (1.0 / 255.0), 0.0),
            Bricks::Nodes(nodes) => {
                let [mean, sd] = nodes[brick as usize].moments[index];
                (f32::from(mean) * (1.0 / 65535.0), f32::from(sd) * (1.0 / 65535.0))
            }
        }
    }

    /// Index in `bricks` of what the table has at an index: the empty brick where there is none.
    #[inline(always)]
    pub(crate) fn stored(&self, index: usize) -> usize {
        let number = self.table.numbers[index] as usize;
        // Blocks of the filter's bits alone have no brick.
        if number <= self.codes.len() { number } else { 0 }
    }

    /// Number of the brick at a place within the cube, if there is one.
    #[inline]
    pub(crate) fn brick_at(&self, place: UVec3) -> Option<u32> {
        let number = self.table.numbers[self.table.index(place)];
        (1..=self.codes.len() as u32).contains(&number).then_some(number)
    }

    /// Number of the brick that holds a node, and the node's index in it.
    #[inline]
    pub(crate) fn find(&self, cell: UVec3) -> Option<(u32, usize)> {
        Some((self.brick_at(cell / 8)?, cell_in_brick(cell % 8)))
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let bricks = match &self.bricks {
            Bricks::Leaves(b) => size_of_val(b.as_slice()),
            Bricks::Nodes(b) => size_of_val(b.as_slice()),
        };
        (bricks + size_of_val(self.axes.as_slice()) + size_of_val(self.codes.as_slice())) as u64
            + self.table.memory_bytes()
            + self.filter.memory_bytes()
            + self.plain.as_ref().map_or(0, PlainNodes::memory_bytes)
    }
}

/// From a brick's place to its number, with a border of one brick about the cube.
#[derive(Clone, Debug, Default)]
pub(crate) struct BrickTable {
    /// Bricks along a side, with the border.
    pub(crate) across: u32,
    /// The number of the brick at each place, x fastest.
    pub(crate) numbers: Vec<u32>,
}

impl BrickTable {
    /// The table of a level with that many nodes a side: bricks get the numbers from 1 on in the order of their Morton
    /// codes, all other places 0.
    pub(crate) fn new(side: u32, codes: &[u32]) -> Self {
        let across = Self::across(side);
        let mut table = Self { across, numbers: vec![0; across.pow(3) as usize] };
        for (number, &code) in (1..).zip(codes) {
            let index = table.index(morton::decode(code));
            table.numbers[index] = number;
        }
        table
    }

    fn across(side: u32) -> u32 {
        Level::bricks_per_side(side) + 2
    }

    /// Bytes of the table of a level with that many nodes a side.
    pub(crate) fn bytes_for(side: u32) -> u64 {
        u64::from(Self::across(side).pow(3)) * size_of::<u32>() as u64
    }

    pub(crate) fn memory_bytes(&self) -> u64 {
        size_of_val(self.numbers.as_slice()) as u64
    }

    /// Where the number of the brick at a place is; the place may lie on the border above the cube.
    #[inline]
    pub(crate) fn index(&self, brick: UVec3) -> usize {
        (((brick.z + 1) * self.across + brick.y + 1) * self.across + brick.x + 1) as usize
    }
}

impl Level {
    /// Opacities of a node across x, y and z, in [0, 1]; only where the level keeps them.
    #[inline]
    pub(crate) fn axis_opacities(&self, brick: u32, index: usize) -> conray_core::Vec3 {
        let [x, y, z] = self.axes[brick as usize - 1][index];
        conray_core::Vec3::new(f32::from(x), f32::from(y), f32::from(z)) * (1.0 / 255.0)
    }
}
