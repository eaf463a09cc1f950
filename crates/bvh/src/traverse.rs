//! Walking a tree along a ray, nearest boxes first.

use crate::lanes::{Lanes, bits};
use crate::node::{Child, ChildKind, Node};
use crate::ray::Slab;
use crate::wide::WideTree;
use conray_core::gamma;
use fearless_simd::{Simd, f32x16, prelude::*};

/// Distances of hits and of boxes are rounded apart: a box is passed over only where it starts past the limit by more
/// than that, so that of hits at one distance none is lost, whatever the order of the boxes.
const CUT: f32 = 1.0 + gamma(8);

/// Largest distance that still has to be looked at when hits up to `limit` count.
#[inline]
pub(crate) fn cut(limit: f32) -> f32 {
    limit * CUT
}

/// Trees of usual depth fit into the first, which is cheap to set up, nearly all others into the second; a tree so deep
/// that it takes more gets its stack from the heap.
const STACK_SIZES: [usize; 2] = [64, 256];

type Entry = (Child, f32);
const NO_ENTRY: Entry = (Child::EMPTY, 0.0);

/// What is done at the leaves. A trait rather than a closure, which would not be compiled for the level of SIMD at hand.
pub(crate) trait Leaves {
    /// Takes a leaf that the ray may meet: where its items are and how many. Returns how far hits still count, or `None`
    /// to stop.
    fn visit<S: Simd>(&mut self, simd: S, first: u32, items: u32) -> Option<f32>;
}

/// Visits the leaves that the ray may meet. Returns false where it was stopped.
#[inline(always)]
pub(crate) fn traverse<S: Simd>(
    simd: S,
    tree: &WideTree,
    slab: &Slab,
    limit: f32,
    leaves: &mut impl Leaves,
) -> bool {
    if tree.nodes.is_empty() {
        return true;
    }
    // One call for all kinds of stack: what is inlined there is large, and compiled for every sink and level of SIMD.
    let (mut usual, mut deeper, mut deepest);
    let stack: &mut [Entry] = if tree.stack_entries <= STACK_SIZES[0] {
        usual = [NO_ENTRY; STACK_SIZES[0]];
        &mut usual
    } else if tree.stack_entries <= STACK_SIZES[1] {
        deeper = [NO_ENTRY; STACK_SIZES[1]];
        &mut deeper
    } else {
        deepest = vec![NO_ENTRY; tree.stack_entries];
        &mut deepest
    };
    traverse_with(simd, &tree.nodes, slab, limit, leaves, stack)
}

#[inline(always)]
fn traverse_with<S: Simd>(
    simd: S,
    nodes: &[Node],
    slab: &Slab,
    limit: f32,
    leaves: &mut impl Leaves,
    stack: &mut [Entry],
) -> bool {
    let mut height = 0;
    let mut far = cut(limit);
    let mut current = Child::inner(0);
    loop {
        match current.kind() {
            ChildKind::Inner(index) => {
                let node = &nodes[index as usize];
                let (mut mask, near) = meet(simd, node, slab, far);
                let base = height;
                while mask != 0 {
                    let slot = mask.trailing_zeros() as usize & 15;
                    mask &= mask - 1;
                    let entry = (node.children[slot], near.0[slot]);
                    // Insertion keeps the nearest on top.
                    let mut at = height;
                    while at > base && stack[at - 1].1 < entry.1 {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = entry;
                    height += 1;
                }
            }
            ChildKind::Leaf(first, items) => match leaves.visit(simd, first, items) {
                Some(limit) => far = cut(limit),
                None => return false,
            },
        }
        loop {
            if height == 0 {
                return true;
            }
            height -= 1;
            let (child, near) = stack[height];
            // NaN is not beyond: see `Slab`.
            let beyond = near > far;
            if !beyond && child != Child::EMPTY {
                current = child;
                break;
            }
        }
    }
}

/// Which of a node's boxes the ray meets within `far`, and where it enters them.
#[inline(always)]
fn meet<S: Simd>(simd: S, node: &Node, slab: &Slab, far: f32) -> (u32, Lanes) {
    let near = |axis: usize| distance(simd, node, axis, slab.near_side[axis], slab.near_origin[axis], slab);
    let exit =
        |axis: usize| distance(simd, node, axis, slab.near_side[axis] ^ 1, slab.far_origin[axis], slab);
    let enter = near(0).max(near(1)).max(near(2).max(f32x16::splat(simd, 0.0)));
    let leave =
        (exit(0).min(exit(1)).min(exit(2)) * f32x16::splat(simd, Slab::FAR)).min(f32x16::splat(simd, far));
    (!bits(enter.simd_gt(leave)) & 0xffff, Lanes::of(enter))
}

#[inline(always)]
fn distance<S: Simd>(simd: S, node: &Node, axis: usize, side: usize, origin: f32, slab: &Slab) -> f32x16<S> {
    (node.planes[axis][side & 1].load(simd) - f32x16::splat(simd, origin))
        * f32x16::splat(simd, slab.inverse[axis])
}
