//! From leaves to the levels above: mean, SD and emptiness of every node.
//!
//! Sums of opacities and of their squares are carried upward as integers, so that each node's mean and SD are those
//! of its finest descendants, rounded once. A brick is one node three levels up, so each three levels are computed
//! from the sums of one, and only every third level's sums are ever held.

use crate::level::{Bricks, LeafBrick, Level, NodeBrick, cell_in_brick};
use crate::morton;
use glam::UVec3;
use rayon::prelude::*;

/// Sums over a node's leaves of their opacities in 255ths, and of the squares.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sums {
    pub(crate) first: u64,
    pub(crate) second: u64,
}

/// Bytes of the sums of a brick.
pub(crate) const SUMS_BYTES: u64 = size_of::<[Sums; 512]>() as u64;

impl Sums {
    #[inline]
    fn add(&mut self, other: Self) {
        self.first += other.first;
        self.second += other.second;
    }

    /// Mean and SD in 65535ths for a node of `leaves` leaves.
    pub(crate) fn quantised(self, leaves: u64) -> [u16; 2] {
        // 65535 = 257 * 255.
        let mean = (self.first * 257 + leaves / 2) / leaves;
        let n = u128::from(leaves);
        let spread = n * u128::from(self.second) - u128::from(self.first).pow(2);
        let sd = (spread as f64).sqrt() / leaves as f64 * 257.0;
        [mean as u16, (sd + 0.5) as u16]
    }
}

/// Where sums come from: the leaves themselves, or those kept of a level above.
enum Base<'a> {
    Leaves(&'a [LeafBrick]),
    Sums(&'a [[Sums; 512]]),
}

impl Base<'_> {
    #[inline]
    fn at(&self, brick: u32, index: usize) -> Sums {
        match self {
            Self::Leaves(leaves) => {
                let q = u64::from(leaves[brick as usize].means[index]);
                Sums { first: q, second: q * q }
            }
            Self::Sums(sums) => sums[brick as usize - 1][index],
        }
    }
}

/// Morton codes of the bricks of the level above, whose nodes are twice as large.
pub(crate) fn parent_codes(codes: &[u32]) -> Vec<u32> {
    let mut parents: Vec<u32> = codes.iter().map(|code| code >> 3).collect();
    parents.dedup();
    parents
}

/// Adds the levels above the leaves, up to the one whose only node is the cube.
pub(crate) fn build_upper_levels(levels: &mut Vec<Level>) {
    let mut kept: Vec<[Sums; 512]> = Vec::new();
    let mut base = 0;
    while levels[levels.len() - 1].side > 1 {
        for step in 1..=3 {
            let above = levels.len() - 1;
            if levels[above].side == 1 {
                return;
            }
            let source = match &levels[base].bricks {
                Bricks::Leaves(leaves) => Base::Leaves(leaves),
                Bricks::Nodes(_) => Base::Sums(&kept),
            };
            let keep = step == 3;
            let (level, sums) = build_level(&levels[base], &levels[above], &source, base, step, keep);
            levels.push(level);
            if keep {
                kept = sums;
            }
        }
        base += 3;
    }
}

/// The level `step` above level `base`, and its sums if they are to be kept.
fn build_level(
    from: &Level,
    below: &Level,
    source: &Base<'_>,
    base: usize,
    step: usize,
    keep: bool,
) -> (Level, Vec<[Sums; 512]>) {
    let side = below.side / 2;
    let codes = parent_codes(&below.codes);
    let leaves = 1u64 << (3 * (base + step));
    let mut kept = vec![[Sums::default(); 512]; if keep { codes.len() } else { 0 }];
    let mut bricks = vec![NodeBrick::EMPTY; codes.len() + 1];
    if keep {
        let jobs = bricks[1..].par_iter_mut().zip(&mut kept).zip(&codes);
        jobs.for_each(|((brick, sums), &code)| fill(brick, sums, code, from, source, step, leaves));
    } else {
        let jobs = bricks[1..].par_iter_mut().zip(&codes);
        jobs.for_each(|(brick, &code)| {
            fill(brick, &mut [Sums::default(); 512], code, from, source, step, leaves);
        });
    }
    let axes = if below.axes.is_empty() {
        Vec::new()
    } else {
        codes.par_iter().map(|&code| composited_axes(code, below)).collect()
    };
    (Level::new(side, codes, Bricks::Nodes(bricks), axes), kept)
}

/// Fills one brick from all base bricks inside it.
fn fill(
    brick: &mut NodeBrick,
    sums: &mut [Sums; 512],
    code: u32,
    from: &Level,
    source: &Base<'_>,
    step: usize,
    leaves: u64,
) {
    let (low, across) = (morton::decode(code) << step as u32, 1u32 << step);
    let end = UVec3::splat(Level::bricks_per_side(from.side)).min(low + across);
    for z in low.z..end.z {
        for y in low.y..end.y {
            for x in low.x..end.x {
                let place = UVec3::new(x, y, z);
                if let Some(found) = from.brick_at(place) {
                    gather(brick, sums, (place - low) * (8 >> step), from, found, source, step);
                }
            }
        }
    }
    for (moments, sums) in brick.moments.iter_mut().zip(sums.iter()) {
        if sums.first > 0 {
            *moments = sums.quantised(leaves);
        }
    }
}

/// Adds the nodes of one base brick to the nodes that hold them, the first of which is at `corner`.
fn gather(
    brick: &mut NodeBrick,
    sums: &mut [Sums; 512],
    corner: UVec3,
    from: &Level,
    found: u32,
    source: &Base<'_>,
    step: usize,
) {
    for (word, bits) in from.occupied(found).iter().enumerate() {
        let mut bits = *bits;
        while bits != 0 {
            let index = word * 64 + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let local = UVec3::new(index as u32 & 7, index as u32 >> 3 & 7, index as u32 >> 6);
            let node = cell_in_brick(corner + (local >> step as u32));
            brick.occupied[node / 64] |= 1 << (node % 64);
            sums[node].add(source.at(found, index));
        }
    }
}

/// Opacities across the axes: of two children in a row the second is seen through the first, and the four rows
/// are averaged (Crassin and others, 2011, section 6.3).
fn composited_axes(code: u32, below: &Level) -> [[u8; 3]; 512] {
    let low = morton::decode(code) * 8;
    std::array::from_fn(|index| {
        let local = UVec3::new(index as u32 & 7, index as u32 >> 3 & 7, index as u32 >> 6);
        let first = 2 * (low + local);
        if first.max_element() >= below.side {
            return [0; 3];
        }
        // All eight children lie in one brick.
        let Some((brick, start)) = below.find(first) else { return [0; 3] };
        let child = |c: usize, axis: usize| {
            f32::from(below.axes[brick as usize - 1][start + offset(c)][axis]) / 255.0
        };
        std::array::from_fn(|axis| {
            let through = |c: usize| (1.0 - child(c, axis)) * (1.0 - child(c | 1 << axis, axis));
            let open: f32 = (0..8).filter(|c| c >> axis & 1 == 0).map(through).sum();
            ((1.0 - 0.25 * open) * 255.0 + 0.5) as u8
        })
    })
}

/// Offset of child `c` (bit k is its place on axis k) from the first child in a brick.
fn offset(c: usize) -> usize {
    (c & 1) + (c >> 1 & 1) * 8 + (c >> 2 & 1) * 64
}

#[cfg(test)]
mod tests {
    use super::Sums;

    fn sums(opacities: &[u64]) -> Sums {
        Sums { first: opacities.iter().sum(), second: opacities.iter().map(|q| q * q).sum() }
    }

    #[test]
    fn a_half_filled_node_has_mean_and_sd_of_a_half() {
        let [mean, sd] = sums(&[255, 255, 255, 255, 0, 0, 0, 0]).quantised(8);
        assert!(mean.abs_diff(32768) <= 1 && sd.abs_diff(32768) <= 1, "{mean} {sd}");
    }

    #[test]
    fn equal_leaves_have_no_sd_and_a_full_cube_does_not_overflow() {
        assert_eq!(sums(&[100; 8]).quantised(8), [25700, 0]);
        let leaves = 1u64 << 33;
        let full = Sums { first: leaves * 255, second: leaves * 255 * 255 };
        assert_eq!(full.quantised(leaves), [65535, 0]);
    }
}
