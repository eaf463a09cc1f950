//! From boxes to a four-wide tree, by way of a two-way one.

use crate::binary;
use crate::traverse::MAX_STACK;
use crate::wide::{LeafRule, WideTree};
use conray_core::Bounds;

/// Builds the tree; see [`WideTree::new`] for `emit`.
pub(crate) fn build_wide(boxes: &[Bounds], rule: LeafRule, emit: impl FnMut(&[u32]) -> u32) -> WideTree {
    let nodes = binary::build(boxes);
    let tree = WideTree::new(&nodes, boxes, rule, emit);
    assert!(tree.stack_entries <= MAX_STACK, "the two-way tree's depth is bounded");
    tree
}
