//! How one level's nodes are stored: sparse bricks of 8 x 8 x 8 nodes found through pages of 8 x 8 x 8 bricks.

use crate::morton;
use glam::UVec3;

/// No brick or no page.
const NONE: u32 = u32::MAX;

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

/// All nodes of one size.
#[derive(Clone)]
pub(crate) struct Level {
    /// Nodes along a side of the cube.
    pub(crate) side: u32,
    /// Morton codes of the bricks, ascending, in the order in which they are stored.
    pub(crate) codes: Vec<u32>,
    pub(crate) table: BrickTable,
    pub(crate) bricks: Bricks,
    /// Opacity across x, y and z in 255ths, for each brick; empty unless asked for.
    pub(crate) axes: Vec<[[u8; 3]; 512]>,
}

/// Index of a node within its brick.
#[inline]
pub(crate) fn cell_in_brick(local: UVec3) -> usize {
    (local.x | local.y << 3 | local.z << 6) as usize
}

impl Level {
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

    /// The brick that holds a node, and the node's index in it.
    #[inline]
    pub(crate) fn find(&self, cell: UVec3) -> Option<(u32, usize)> {
        Some((self.table.find(cell / 8)?, cell_in_brick(cell % 8)))
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let bricks = match &self.bricks {
            Bricks::Leaves(b) => size_of_val(b.as_slice()),
            Bricks::Nodes(b) => size_of_val(b.as_slice()),
        };
        (bricks + size_of_val(self.axes.as_slice()) + size_of_val(self.codes.as_slice())) as u64
            + self.table.memory_bytes()
    }
}

/// From a brick's place to its index, in two steps.
#[derive(Clone)]
pub(crate) struct BrickTable {
    /// Pages along a side.
    side: u32,
    /// For each page of 8 x 8 x 8 bricks its index in `pages`, or [`NONE`].
    roots: Vec<u32>,
    /// For each brick of a page its index, or [`NONE`].
    pages: Vec<[u32; 512]>,
}

impl BrickTable {
    /// The table of a level with that many nodes a side and those bricks.
    pub(crate) fn new(side: u32, codes: &[u32]) -> Self {
        let side = Self::pages_per_side(side);
        let mut table = Self {
            side,
            roots: vec![NONE; side.pow(3) as usize],
            pages: Vec::with_capacity(Self::page_count(codes)),
        };
        for (&code, index) in codes.iter().zip(0u32..) {
            let brick = morton::decode(code);
            let root = table.root(brick);
            if table.roots[root] == NONE {
                table.roots[root] = table.pages.len() as u32;
                table.pages.push([NONE; 512]);
            }
            table.pages[table.roots[root] as usize][cell_in_brick(brick % 8)] = index;
        }
        table
    }

    fn pages_per_side(side: u32) -> u32 {
        Level::bricks_per_side(side).div_ceil(8)
    }

    fn page_count(codes: &[u32]) -> usize {
        // A page is 512 consecutive codes.
        codes.chunk_by(|a, b| a >> 9 == b >> 9).count()
    }

    /// Bytes of the table of a level with that many nodes a side and those bricks.
    pub(crate) fn bytes_for(side: u32, codes: &[u32]) -> u64 {
        let roots = u64::from(Self::pages_per_side(side).pow(3)) * size_of::<u32>() as u64;
        roots + Self::page_count(codes) as u64 * size_of::<[u32; 512]>() as u64
    }

    fn memory_bytes(&self) -> u64 {
        (size_of_val(self.roots.as_slice()) + size_of_val(self.pages.as_slice())) as u64
    }

    #[inline]
    fn root(&self, brick: UVec3) -> usize {
        let page = brick / 8;
        ((page.z * self.side + page.y) * self.side + page.x) as usize
    }

    /// Index of the brick at a place within the cube.
    #[inline]
    pub(crate) fn find(&self, brick: UVec3) -> Option<u32> {
        let page = self.roots[self.root(brick)];
        if page == NONE {
            return None;
        }
        let index = self.pages[page as usize][cell_in_brick(brick % 8)];
        (index != NONE).then_some(index)
    }
}

impl Level {
    /// Opacities of a node across x, y and z, in [0, 1]; only where the level keeps them.
    #[inline]
    pub(crate) fn axis_opacities(&self, brick: u32, index: usize) -> conray_core::Vec3 {
        let [x, y, z] = self.axes[brick as usize][index];
        conray_core::Vec3::new(f32::from(x), f32::from(y), f32::from(z)) * (1.0 / 255.0)
    }
}
