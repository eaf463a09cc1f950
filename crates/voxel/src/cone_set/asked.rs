//! Whether sixteen cones meet anything at the steps of a part.
//!
//! All steps of all points are asked for before any answer is used: where the bits are, reading them one by one, testing them.
//! So no read waits for another, and no vector is read while its members are still on their way to memory.

use super::{
    lanes::{LANES, Lanes},
    paths::Paths,
};
use crate::{
    filter_bits::{BLOCK_WORDS, FilterBits},
    level::{BrickTable, Level},
    steps::{MOST_STEPS_OF_PART, Step},
};
use fearless_simd::{Simd, f32x16, prelude::*, u32x16};
use glam::UVec3;

/// A value for each cone, by step of a part.
type ByStep<T> = [Lanes<T>; MOST_STEPS_OF_PART];

/// Positions of the cones at the steps of a part, and which of them meet something.
pub(super) struct Asked {
    /// In nodes of the level that was asked, by step and axis.
    pub(super) at: [[Lanes<f32>; 3]; MOST_STEPS_OF_PART],
    /// Bits of the cones whose filter meets an occupied node, and of some whose filter is just outside the cube.
    pub(super) met: [u32; MOST_STEPS_OF_PART],
    /// Which byte or block holds a place's bit.
    index: ByStep<u32>,
    /// Which word of a block does.
    word: ByStep<u32>,
    /// Which bit it is.
    bit: ByStep<u32>,
    found: ByStep<u32>,
}

impl Asked {
    pub(super) const fn new() -> Self {
        Self {
            at: [[Lanes([0.0; LANES]); 3]; MOST_STEPS_OF_PART],
            met: [0; MOST_STEPS_OF_PART],
            index: [Lanes([0; LANES]); MOST_STEPS_OF_PART],
            word: [Lanes([0; LANES]); MOST_STEPS_OF_PART],
            bit: [Lanes([0; LANES]); MOST_STEPS_OF_PART],
            found: [Lanes([0; LANES]); MOST_STEPS_OF_PART],
        }
    }

    /// Where the bits of a step are, among those of all places.
    #[inline(always)]
    fn place_plain<S: Simd>(&mut self, simd: S, k: usize, at: &[f32x16<S>; 3], side: u32, across: u32) {
        let across = u32x16::splat(simd, across);
        let [x, y, z] = self.places(simd, k, at, side);
        let place = (z * across + y) * across + x;
        (place >> 3).store_slice(&mut self.index[k].0);
        (place & u32x16::splat(simd, 7)).store_slice(&mut self.bit[k].0);
    }

    #[inline(always)]
    fn read_plain(&mut self, k: usize, bytes: &[u8]) {
        for (found, &index) in self.found[k].0.iter_mut().zip(&self.index[k].0) {
            *found = u32::from(bytes[index as usize]);
        }
    }

    /// Where the bits of a step are, in blocks.
    #[inline(always)]
    fn place_in_blocks<S: Simd>(
        &mut self,
        simd: S,
        k: usize,
        at: &[f32x16<S>; 3],
        side: u32,
        table: &BrickTable,
    ) {
        let across = u32x16::splat(simd, table.across);
        let (one, three) = (u32x16::splat(simd, 1), u32x16::splat(simd, 3));
        let seven = u32x16::splat(simd, 7);
        let [x, y, z] = self.places(simd, k, at, side);
        let first = u32x16::splat(simd, table.index(UVec3::ZERO) as u32);
        let index = ((z >> 3) * across + (y >> 3)) * across + (x >> 3) + first;
        index.store_slice(&mut self.index[k].0);
        (((z & seven) << 1) + ((y >> 2) & one)).store_slice(&mut self.word[k].0);
        (((y & three) << 3) | (x & seven)).store_slice(&mut self.bit[k].0);
    }

    #[inline(always)]
    fn read_blocks(&mut self, k: usize, numbers: &[u32], blocks: &[[u32; BLOCK_WORDS]]) {
        let places = self.index[k].0.iter().zip(&self.word[k].0);
        for (found, (&index, &word)) in self.found[k].0.iter_mut().zip(places) {
            let number = numbers[index as usize] as usize;
            *found = blocks[number][word as usize % BLOCK_WORDS];
        }
    }

    /// Which of the bits that were read are set.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, steps: usize) {
        let one = u32x16::splat(simd, 1);
        for (met, (found, bit)) in self.met.iter_mut().zip(self.found.iter().zip(&self.bit)).take(steps) {
            let bits = u32x16::from_slice(simd, &found.0) >> u32x16::from_slice(simd, &bit.0);
            *met = (bits & one).simd_eq(one).to_bitmask() as u32;
        }
    }

    /// Notes the positions at step number `k`; the places of their filters, or one where filters meet nothing.
    #[inline(always)]
    fn places<S: Simd>(&mut self, simd: S, k: usize, at: &[f32x16<S>; 3], side: u32) -> [u32x16<S>; 3] {
        let (half, outside) = (f32x16::splat(simd, 0.5), u32x16::splat(simd, side + 1));
        let mut places = [outside; 3];
        for axis in 0..3 {
            at[axis].store_slice(&mut self.at[k][axis].0);
            // What is below 0 becomes a large number, or 0 where a level of SIMD says so.
            places[axis] = (at[axis] + half).to_int::<u32x16<S>>().min(outside);
        }
        places
    }
}

/// Asks for the steps of a part at all points, on `level`, which has that number.
///
/// The bits of one point are read while those of the next are placed: vectors and single reads keep different parts of the
/// processor busy.
#[inline(always)]
pub(super) fn ask<S: Simd>(
    simd: S,
    asked: &mut [Asked],
    level: &Level,
    number: usize,
    steps: &[Step],
    paths: &[Paths<S>],
) {
    let (points, side) = (asked.len().min(paths.len()), level.side);
    for p in 0..=points {
        let scaled = paths[p.min(points - 1)].in_nodes(simd, number);
        match &level.filter {
            FilterBits::Plain(plain) => {
                for (k, step) in steps.iter().enumerate().take(MOST_STEPS_OF_PART) {
                    if p < points {
                        asked[p].place_plain(simd, k, &scaled.at(simd, step), side, plain.across);
                    }
                    if p > 0 {
                        asked[p - 1].read_plain(k, &plain.bytes);
                    }
                }
            }
            FilterBits::Blocks(blocks) => {
                for (k, step) in steps.iter().enumerate().take(MOST_STEPS_OF_PART) {
                    if p < points {
                        asked[p].place_in_blocks(simd, k, &scaled.at(simd, step), side, &level.table);
                    }
                    if p > 0 {
                        asked[p - 1].read_blocks(k, &level.table.numbers, blocks);
                    }
                }
            }
        }
    }
    for asked in asked {
        asked.test(simd, steps.len());
    }
}
