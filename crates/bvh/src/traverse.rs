//! Walking a tree along a ray, nearest boxes first.

use crate::node::{Child, ChildKind, Node};
use crate::ray::Slab;
use crate::wide::WideTree;
use conray_core::gamma;
use glam::Vec4;

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

/// Visits the leaves that the ray may meet. `leaf` gets the first item and the number of items, and returns how far
/// hits still count, or `None` to stop. Returns false where it was stopped.
#[inline]
pub(crate) fn traverse(
    tree: &WideTree,
    slab: &Slab,
    limit: f32,
    leaf: impl FnMut(u32, u32) -> Option<f32>,
) -> bool {
    if tree.nodes.is_empty() {
        true
    } else if tree.stack_entries <= STACK_SIZES[0] {
        traverse_with(&tree.nodes, slab, limit, leaf, &mut [NO_ENTRY; STACK_SIZES[0]])
    } else if tree.stack_entries <= STACK_SIZES[1] {
        traverse_with(&tree.nodes, slab, limit, leaf, &mut [NO_ENTRY; STACK_SIZES[1]])
    } else {
        traverse_with(&tree.nodes, slab, limit, leaf, &mut vec![NO_ENTRY; tree.stack_entries])
    }
}

#[inline(always)]
fn traverse_with(
    nodes: &[Node],
    slab: &Slab,
    limit: f32,
    mut leaf: impl FnMut(u32, u32) -> Option<f32>,
    stack: &mut [Entry],
) -> bool {
    let mut height = 0;
    let mut far = cut(limit);
    let mut current = Child::inner(0);
    loop {
        match current.kind() {
            ChildKind::Inner(index) => {
                let node = &nodes[index as usize];
                let (mut mask, near) = meet(node, slab, far);
                if mask != 0 {
                    let near = near.to_array();
                    let base = height;
                    while mask != 0 {
                        let slot = mask.trailing_zeros() as usize & 3;
                        mask &= mask - 1;
                        let entry = (node.children[slot], near[slot]);
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
            }
            ChildKind::Leaf(first, items) => match leaf(first, items) {
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
fn meet(node: &Node, slab: &Slab, far: f32) -> (u32, Vec4) {
    let distance = |axis: usize, side: usize, origin: &[Vec4; 3]| {
        (node.planes[axis][side & 1] - origin[axis]) * slab.inverse[axis]
    };
    let near = |axis: usize| distance(axis, slab.near_side[axis], &slab.near_origin);
    let exit = |axis: usize| distance(axis, slab.near_side[axis] ^ 1, &slab.far_origin);
    let enter = near(0).max(near(1)).max(near(2).max(Vec4::ZERO));
    let leave = (exit(0).min(exit(1)).min(exit(2)) * Slab::FAR).min(Vec4::splat(far));
    (!enter.cmpgt(leave).bitmask() & 0xf, enter)
}
