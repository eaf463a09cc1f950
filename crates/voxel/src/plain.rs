//! A second copy of small levels, with every node of the cube in one array: eight neighbours are at fixed distances, with no
//! table to ask and no brick's end in between.

use crate::{
    level::{Bricks, Level},
    morton,
    rows::{Rows, row},
};
use glam::UVec3;
use rayon::prelude::*;

/// The most nodes along a side for which there is a copy: 9 MB.
const MOST_PLAIN: u32 = 128;

/// Nodes of a level about the cube, one below and two above.
#[derive(Clone, Debug)]
pub(crate) struct PlainNodes {
    /// Nodes along a side.
    pub(crate) across: u32,
    /// Mean and SD in 65535ths, x fastest; the node x, y, z of the level is at `x + 1`, `y + 1`, `z + 1`.
    pub(crate) moments: Vec<[u16; 2]>,
}

impl PlainNodes {
    /// The copy of a level, if it is small.
    pub(crate) fn new(side: u32, codes: &[u32], bricks: &Bricks) -> Option<Self> {
        if side > MOST_PLAIN {
            return None;
        }
        let across = Self::across(side);
        let layer = (across * across) as usize;
        let mut moments = vec![[0; 2]; layer * across as usize];
        // Layers of nodes 0 to 7, 8 to 15 and so on.
        let slabs = moments[layer..].par_chunks_mut(8 * layer).take(Level::bricks_per_side(side) as usize);
        slabs.enumerate().for_each(|(z, slab)| {
            for (number, &code) in (1..).zip(codes) {
                let brick = morton::decode(code);
                if brick.z == z as u32 {
                    copy(slab, across, brick, side.min(8), |index| bricks.moments(number, index));
                }
            }
        });
        Some(Self { across, moments })
    }

    fn across(side: u32) -> u32 {
        side + 3
    }

    /// Bytes of the copy of a level with that many nodes a side.
    pub(crate) fn bytes_for(side: u32) -> u64 {
        if side > MOST_PLAIN {
            0
        } else {
            u64::from(Self::across(side).pow(3)) * size_of::<[u16; 2]>() as u64
        }
    }

    /// The first of the eight nodes `place - 1` and `place`, which is at most one more than the level's side.
    #[inline(always)]
    pub(crate) fn first(&self, place: UVec3) -> usize {
        ((place.z * self.across + place.y) * self.across + place.x) as usize
    }

    /// The eight nodes from the first one on.
    #[inline(always)]
    pub(crate) fn rows(&self, first: usize) -> Rows {
        let (y, z) = (self.across as usize, self.across as usize * self.across as usize);
        Rows([self.row(first), self.row(first + y), self.row(first + z), self.row(first + y + z)])
    }

    #[inline(always)]
    fn row(&self, first: usize) -> [u16; 4] {
        let &[low, high] = self.moments[first..first + 2].as_array().expect("of that length");
        row(low, high)
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        size_of_val(self.moments.as_slice()) as u64
    }
}

/// Copies a brick's nodes into its slab.
fn copy(slab: &mut [[u16; 2]], across: u32, brick: UVec3, side: u32, moments: impl Fn(usize) -> [u16; 2]) {
    for z in 0..side {
        for y in 0..side {
            let row = (z * across + 8 * brick.y + y + 1) * across + 8 * brick.x + 1;
            for x in 0..side {
                slab[(row + x) as usize] = moments((x | y << 3 | z << 6) as usize);
            }
        }
    }
}
