//! The eight nodes about a position, as four rows of two.

use crate::level::{Bricks, Level};
use glam::UVec3;

/// Rows along x, y fastest; each has mean and SD of its lower node, then of its upper one, in 65535ths.
pub(crate) struct Rows(pub(crate) [[u16; 4]; 4]);

/// Nodes from the first of the eight to the last, in the order of a brick.
const WINDOW: usize = 64 + 8 + 2;

impl Rows {
    /// The nodes of a brick of leaves from the first of eight on.
    #[inline(always)]
    pub(crate) fn of_leaves(leaves: &[u8; 512], first: usize) -> Self {
        let w = window(leaves, first);
        Self([leaf_row(w[0], w[1]), leaf_row(w[8], w[9]), leaf_row(w[64], w[65]), leaf_row(w[72], w[73])])
    }

    /// The same above the leaves.
    #[inline(always)]
    pub(crate) fn of_nodes(nodes: &[[u16; 2]; 512], first: usize) -> Self {
        let w = window(nodes, first);
        Self([row(w[0], w[1]), row(w[8], w[9]), row(w[64], w[65]), row(w[72], w[73])])
    }

    /// The nodes `place - 1` and `place` on each axis, where `place` is from 0 to one more than the level's side.
    #[inline(always)]
    pub(crate) fn new(level: &Level, place: UVec3) -> Self {
        if let Some(plain) = &level.plain {
            return plain.rows(plain.first(place));
        }
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
            Bricks::Leaves(leaves) => Self::of_leaves(&leaves[brick].means, first),
            Bricks::Nodes(nodes) => Self::of_nodes(&nodes[brick].moments, first),
        }
    }

    /// In up to eight bricks.
    #[inline(always)]
    pub(crate) fn across(level: &Level, place: UVec3) -> Self {
        // Where the lower nodes are: in which brick, counted from the border, and where in it.
        let (brick, local) = ((place + 7) / 8, (place + 7) % 8);
        let (x, y, z) = (Axis::new(local.x), Axis::new(local.y), Axis::new(local.z));
        let across = level.table.across;
        let index = (brick.z * across + brick.y) * across + brick.x;
        let first = (local.x + 8 * local.y + 64 * local.z) as i32;
        // The brick and the index in it of the node that is that many steps on along each axis.
        let at = |i: u32, j: u32, k: u32| {
            let index = index + i * x.bricks + across * (j * y.bricks + across * k * z.bricks);
            let node = first + i as i32 * x.nodes + 8 * j as i32 * y.nodes + 64 * k as i32 * z.nodes;
            (level.stored(index as usize), node as usize % 512)
        };
        // Written out: closures over arrays are not always made part of the caller.
        match &level.bricks {
            Bricks::Leaves(leaves) => {
                let node = |(brick, node): (usize, usize)| leaves[brick].means[node];
                Self([
                    leaf_row(node(at(0, 0, 0)), node(at(1, 0, 0))),
                    leaf_row(node(at(0, 1, 0)), node(at(1, 1, 0))),
                    leaf_row(node(at(0, 0, 1)), node(at(1, 0, 1))),
                    leaf_row(node(at(0, 1, 1)), node(at(1, 1, 1))),
                ])
            }
            Bricks::Nodes(nodes) => {
                let node = |(brick, node): (usize, usize)| nodes[brick].moments[node];
                Self([
                    row(node(at(0, 0, 0)), node(at(1, 0, 0))),
                    row(node(at(0, 1, 0)), node(at(1, 1, 0))),
                    row(node(at(0, 0, 1)), node(at(1, 0, 1))),
                    row(node(at(0, 1, 1)), node(at(1, 1, 1))),
                ])
            }
        }
    }
}

/// From a node to the next one along an axis.
struct Axis {
    /// 1 where that is in the next brick.
    bricks: u32,
    /// Nodes on within a brick: 1, or back to the first.
    nodes: i32,
}

impl Axis {
    /// From the node at that place in its brick.
    #[inline(always)]
    fn new(local: u32) -> Self {
        let bricks = u32::from(local == 7);
        Self { bricks, nodes: 1 - 8 * bricks as i32 }
    }
}

#[inline(always)]
fn window<T>(nodes: &[T; 512], first: usize) -> &[T; WINDOW] {
    nodes[first..first + WINDOW].as_array().expect("of that length")
}

#[inline(always)]
pub(crate) fn row(low: [u16; 2], high: [u16; 2]) -> [u16; 4] {
    [low[0], low[1], high[0], high[1]]
}

#[inline(always)]
fn leaf_row(low: u8, high: u8) -> [u16; 4] {
    // 65535 = 257 * 255; a leaf has no SD.
    [257 * u16::from(low), 0, 257 * u16::from(high), 0]
}
