//! The walk of a bundle through a tree.
//!
//! Leaves are tested as soon as their node is opened, inner nodes are put on a stack in the order of their slots, which the
//! build chose (`wide.rs`): leaves before nodes and the largest first, since that is what blocks most. Sorting by distance,
//! as single rays do, costs more than it saves: a bundle looks into all directions at once.

use super::boxes::NearBoxes;
use super::rays::BoxRays;
use crate::node::ChildKind;
use crate::visits::{Visit, count};
use crate::wide::WideTree;
use fearless_simd::Simd;

/// Nearly all trees are so shallow that this many subtrees are put off at most; others get their stack from the heap.
const STACK: usize = 128;

/// A subtree put off: the rays that meet its box, and its node.
type Entry = (u64, u32);

/// What is done at the leaves. A trait rather than a closure, which would not be compiled for the level of SIMD at hand.
pub(super) trait Leaves {
    /// The rays that are still to be followed.
    fn open(&self) -> u64;
    /// Takes a leaf that the active rays may meet: where its items are and how many. `None` gives up.
    fn visit<S: Simd>(&mut self, simd: S, first: u32, items: u32, active: u64) -> Option<()>;
}

/// Visits the leaves whose boxes the rays meet; `None` where a leaf gave up.
#[inline(always)]
pub(super) fn walk<S: Simd>(
    simd: S,
    tree: &WideTree,
    rays: &BoxRays,
    leaves: &mut impl Leaves,
) -> Option<()> {
    if tree.nodes.is_empty() {
        return Some(());
    }
    let (mut usual, mut deep);
    let stack: &mut [Entry] = if tree.stack_entries <= STACK {
        usual = [(0, 0); STACK];
        &mut usual
    } else {
        deep = vec![(0, 0); tree.stack_entries];
        &mut deep
    };
    // A function of its own, shared by all trees of triangles: large, and compiled for every level of SIMD.
    simd.vectorize(
        #[inline(always)]
        || walk_with(simd, tree, rays, leaves, stack),
    )
}

#[inline(always)]
fn walk_with<S: Simd>(
    simd: S,
    tree: &WideTree,
    rays: &BoxRays,
    leaves: &mut impl Leaves,
    stack: &mut [Entry],
) -> Option<()> {
    stack[0] = (leaves.open(), 0);
    let mut height = 1;
    while height > 0 {
        height -= 1;
        let (rays_to_node, index) = stack[height];
        let active = rays_to_node & leaves.open();
        if active == 0 {
            continue;
        }
        let node = &tree.nodes[index as usize];
        let boxes = NearBoxes::new(simd, node, rays);
        count(Visit::Node, 1);
        count(Visit::NodeRay, active.count_ones());
        count(Visit::Reachable, boxes.reachable.count_ones());
        let met = boxes.met(simd, rays, active);
        let leaf_slots = node.leaf_slots(simd);
        let mut slots = met.children & leaf_slots;
        while slots != 0 {
            let slot = slots.trailing_zeros() as usize & 15;
            slots &= slots - 1;
            let here = boxes.rays_to(simd, rays, &met, slot, active) & leaves.open();
            if let (true, ChildKind::Leaf(first, items)) = (here != 0, node.children[slot].kind()) {
                leaves.visit(simd, first, items, here)?;
            }
        }
        let mut slots = met.children & !leaf_slots;
        while slots != 0 {
            let slot = slots.trailing_zeros() as usize & 15;
            slots &= slots - 1;
            let here = boxes.rays_to(simd, rays, &met, slot, active);
            if here != 0 {
                stack[height] = (here, node.children[slot].index());
                height += 1;
            }
        }
    }
    Some(())
}
