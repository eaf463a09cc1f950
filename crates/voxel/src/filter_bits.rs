//! Where a trilinear filter meets nothing: one bit for each place that it can take.
//!
//! The filter about a position covers the nodes `place - 1` and `place` on each axis. Most samples of a march lie in empty
//! space; one or two reads here tell so, where reading the nodes takes sixteen.

use crate::{
    level::{BrickTable, Level},
    morton,
};
use glam::{IVec3, UVec3};
use rayon::prelude::*;

/// Places along a side of a block.
const BLOCK: u32 = 8;

/// Words of 32 bits in a block.
pub(crate) const BLOCK_WORDS: usize = 16;

/// The most nodes along a side for which every place of the cube has a bit: 2 MB, found by one read in place of two.
const MOST_PLAIN: u32 = 256;

/// One level's bits; the filter takes places from 0 to the level's side.
#[derive(Clone, Debug)]
pub(crate) enum FilterBits {
    /// A bit for every place, on levels with few.
    Plain(PlainBits),
    /// Blocks of 8 x 8 x 8 places, whose numbers are in the level's table; number 0 is without bits. Bit `x + 8 (y % 4)` of
    /// word `2 z + y / 4` is set where the filter meets an occupied node.
    Blocks(Vec<[u32; BLOCK_WORDS]>),
}

/// A bit for every place of a cube.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlainBits {
    /// Places along a side, with at least one more than the filter takes: there it meets nothing. A multiple of 8.
    pub(crate) across: u32,
    /// The place x, y, z has bit `i % 8` of byte `i / 8`, where `i = (z across + y) across + x`.
    pub(crate) bytes: Vec<u8>,
}

impl FilterBits {
    /// Adds the bits to a level, and the numbers of blocks without a brick to its table.
    pub(crate) fn add_to(level: &mut Level) {
        let extra = extra_codes(level.side, &level.codes, &level.table);
        if level.side <= MOST_PLAIN {
            level.filter = Self::Plain(PlainBits::new(level, &extra));
            return;
        }
        let count = level.codes.len() + extra.len();
        let mut blocks = vec![[0; BLOCK_WORDS]; count + 1];
        let places = level.codes.par_iter().chain(&extra);
        blocks[1..]
            .par_iter_mut()
            .zip(places)
            .for_each(|(block, &code)| *block = bits_of(level, morton::decode(code)));
        for (number, &code) in (level.codes.len() as u32 + 1..).zip(&extra) {
            let index = level.table.index(morton::decode(code));
            level.table.numbers[index] = number;
        }
        level.filter = Self::Blocks(blocks);
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        match self {
            Self::Plain(plain) => size_of_val(plain.bytes.as_slice()) as u64,
            Self::Blocks(blocks) => size_of_val(blocks.as_slice()) as u64,
        }
    }

    /// Bytes of the bits of a level with that many nodes a side and those bricks.
    pub(crate) fn bytes_for(side: u32, codes: &[u32]) -> u64 {
        if side <= MOST_PLAIN {
            return u64::from(PlainBits::across(side).pow(3) / 8);
        }
        let extra = extra_codes(side, codes, &BrickTable::new(side, codes));
        4 * ((codes.len() + extra.len() + 1) * BLOCK_WORDS) as u64
    }
}

impl PlainBits {
    fn across(side: u32) -> u32 {
        (side + 2).next_multiple_of(BLOCK)
    }

    /// The bits of a level, by blocks with a brick and `extra` ones.
    fn new(level: &Level, extra: &[u32]) -> Self {
        let across = Self::across(level.side);
        let mut layers = vec![vec![]; (across / BLOCK) as usize];
        for &code in level.codes.iter().chain(extra) {
            let block = morton::decode(code);
            layers[block.z as usize].push(block);
        }
        let row_bytes = (across / BLOCK) as usize;
        let layer_bytes = across as usize * across as usize;
        let mut bytes = vec![0; layers.len() * layer_bytes];
        bytes.par_chunks_mut(layer_bytes).zip(&layers).for_each(|(bytes, blocks)| {
            for &block in blocks {
                let rows = bits_of(level, block).map(u32::to_le_bytes);
                for (row, &bits) in rows.as_flattened().iter().enumerate() {
                    let (y, z) = (8 * block.y as usize + row % 8, row / 8);
                    bytes[(z * across as usize + y) * row_bytes + block.x as usize] = bits;
                }
            }
        });
        Self { across, bytes }
    }
}

impl Level {
    /// True where the filter at a place meets no occupied node; places go from 0 to the level's side.
    #[inline]
    pub(crate) fn is_vacant(&self, place: IVec3) -> bool {
        let place = place.as_uvec3();
        match &self.filter {
            FilterBits::Plain(plain) => {
                let index = (place.z * plain.across + place.y) * plain.across + place.x;
                plain.bytes[index as usize / 8] >> (index % 8) & 1 == 0
            }
            FilterBits::Blocks(blocks) => {
                let number = self.table.numbers[self.table.index(place / BLOCK)];
                let local = place % BLOCK;
                let word = blocks[number as usize][(2 * local.z + local.y / 4) as usize];
                word >> (local.x + 8 * (local.y % 4)) & 1 == 0
            }
        }
    }
}

/// Morton codes of the blocks without a brick from which a filter may reach one: upper neighbours of bricks.
fn extra_codes(side: u32, bricks: &[u32], table: &BrickTable) -> Vec<u32> {
    // Places go up to the side itself, one block more than there are bricks; small levels have one block anyway.
    let blocks = side / BLOCK + 1;
    let mut codes: Vec<u32> = bricks
        .par_iter()
        .flat_map_iter(|&code| {
            let brick = morton::decode(code);
            let about = (1..8).map(move |c| brick + UVec3::new(c & 1, c >> 1 & 1, c >> 2));
            let is_extra = move |b: &UVec3| b.max_element() < blocks && table.numbers[table.index(*b)] == 0;
            about.filter(is_extra).map(morton::encode)
        })
        .collect();
    codes.par_sort_unstable();
    codes.dedup();
    codes
}

/// The bits of the block at a place.
fn bits_of(level: &Level, place: UVec3) -> [u32; BLOCK_WORDS] {
    let mut block = [0; BLOCK_WORDS];
    // Bricks about the block: bit k of the index says whether the lower or the upper one on axis k.
    let bricks: [Option<u32>; 8] = std::array::from_fn(|c| {
        let upper = UVec3::new(c as u32 & 1, c as u32 >> 1 & 1, c as u32 >> 2);
        let at = (place + upper).checked_sub(UVec3::ONE)?;
        level.brick_at(at)
    });
    // Whether the nodes at -1 to 7 of a row are occupied, as bits 0 to 8.
    let row = |y: usize, z: usize| {
        let half = |x: usize| {
            let which = x | usize::from(y > 0) << 1 | usize::from(z > 0) << 2;
            bricks[which].map_or(0, |brick| {
                let word = level.occupied(brick)[(z + 7) % 8];
                u32::from((word >> (8 * ((y + 7) % 8))) as u8)
            })
        };
        half(0) >> 7 | half(1) << 1
    };
    // Pairs along x, then y, then z.
    let mut below = [0u32; 8];
    for z in 0..9 {
        let rows: [u32; 9] = std::array::from_fn(|y| {
            let row = row(y, z);
            (row | row >> 1) & 0xff
        });
        let layer: [u32; 8] = std::array::from_fn(|y| rows[y] | rows[y + 1]);
        if z > 0 {
            for y in 0..8 {
                block[2 * (z - 1) + y / 4] |= (layer[y] | below[y]) << (8 * (y % 4));
            }
        }
        below = layer;
    }
    block
}
