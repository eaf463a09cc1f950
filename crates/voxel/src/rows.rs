//! The eight nodes about a position, as four rows of two.

use crate::level::{Bricks, Level};
use glam::UVec3;

/// Rows along x, y fastest; each has mean and SD of its lower node, then of its upper one, in 65535ths.
pub(crate) struct Rows(pub(crate) [[u16; 4]; 4]);

/// Nodes from the first of the eight to the last, in the order of a brick.
const WINDOW: usize = 64 + 8 + 2;

impl Rows {
    /// The nodes `place - 1` and `place` on each axis, where `place` is from 0 to one more than the level's side.
    #[inline(always)]
    pub(crate) fn new(level: &Level, place: UVec3) -> Self {
        let local = place % 8;
        if local.min_element() == 0 {
            Self::across(level, place)
        } else {
            Self::within(level, place / 8, local - 1)
        }
    }

    /// All in one brick: at fixed distances from the first.
    #[inline(always)]
    fn within(level: &Level, brick: UVec3, first: UVec3) -> Self {
        let brick = level.stored(level.table.index(brick));
        let first = (first.x + 8 * first.y + 64 * first.z) as usize;
        match &level.bricks {
            Bricks::Leaves(leaves) => {
                let w = window(&leaves[brick].means, first);
                Self([
                    leaf_row(w[0], w[1]),
                    leaf_row(w[8], w[9]),
                    leaf_row(w[64], w[65]),
                    leaf_row(w[72], w[73]),
                ])
            }
            Bricks::Nodes(nodes) => {
                let w = window(&nodes[brick].moments, first);
                Self([row(w[0], w[1]), row(w[8], w[9]), row(w[64], w[65]), row(w[72], w[73])])
            }
        }
    }

    /// In up to eight bricks.
    #[inline(always)]
    fn across(level: &Level, place: UVec3) -> Self {
        // Where the lower and the upper node are on each axis: which brick, counted from the border, and where in it.
        let (low, high) = (place + 7, place + 8);
        let (low_brick, high_brick) = (low / 8, high / 8);
        let (low, high) = (low % 8, high % 8);
        let across = level.table.across;
        let at = |x: (u32, u32), y: (u32, u32), z: (u32, u32)| {
            let brick = level.stored(((z.0 * across + y.0) * across + x.0) as usize);
            (brick, (x.1 + 8 * y.1 + 64 * z.1) as usize)
        };
        let x = [(low_brick.x, low.x), (high_brick.x, high.x)];
        let y = [(low_brick.y, low.y), (high_brick.y, high.y)];
        let z = [(low_brick.z, low.z), (high_brick.z, high.z)];
        let rows = [(y[0], z[0]), (y[1], z[0]), (y[0], z[1]), (y[1], z[1])];
        let mut all = [[0; 4]; 4];
        match &level.bricks {
            Bricks::Leaves(leaves) => {
                for (row, (y, z)) in all.iter_mut().zip(rows) {
                    let ((a, i), (b, j)) = (at(x[0], y, z), at(x[1], y, z));
                    *row = leaf_row(leaves[a].means[i], leaves[b].means[j]);
                }
            }
            Bricks::Nodes(nodes) => {
                for (out, (y, z)) in all.iter_mut().zip(rows) {
                    let ((a, i), (b, j)) = (at(x[0], y, z), at(x[1], y, z));
                    *out = row(nodes[a].moments[i], nodes[b].moments[j]);
                }
            }
        }
        Self(all)
    }
}

#[inline(always)]
fn window<T>(nodes: &[T; 512], first: usize) -> &[T; WINDOW] {
    nodes[first..first + WINDOW].as_array().expect("of that length")
}

#[inline(always)]
fn row(low: [u16; 2], high: [u16; 2]) -> [u16; 4] {
    [low[0], low[1], high[0], high[1]]
}

#[inline(always)]
fn leaf_row(low: u8, high: u8) -> [u16; 4] {
    // 65535 = 257 * 255; a leaf has no SD.
    [257 * u16::from(low), 0, 257 * u16::from(high), 0]
}
