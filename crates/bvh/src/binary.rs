//! Two-way tree over boxes, from the top down, by the surface area heuristic over bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007. Leaves are small groups of items; which of
//! them to join is decided later, when the tree is made sixteen-wide. Work and depth are bounded for every input
//! (coincident and nested boxes included, which make agglomerative builders quadratic), and the tree is the same for
//! any number of threads: threads share out subtrees, never a decision.

mod split;

use conray_core::{Bounds, Vec3};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use rayon::{join, prelude::*};
use split::{Extent, Item, split};

/// Subtrees of fewer items are built by one thread.
const PARALLEL_ITEMS: usize = 8192;

/// A two-way tree and the order in which its leaves hold the items.
///
/// The root is node 0 and children lie side by side. A leaf's items are `order[first_index..][..prim_count]`. Boxes are
/// scaled to about [-1, 1]: a guide for the heuristics, no bounds.
#[derive(Clone, Debug, Default)]
pub(crate) struct BinaryTree {
    pub(crate) nodes: Vec<Bvh2Node>,
    pub(crate) order: Vec<u32>,
}

impl BinaryTree {
    /// Builds the tree over non-empty, finite boxes; empty for none. Groups of up to `group` items are not split.
    pub(crate) fn build(boxes: &[Bounds], group: u32) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let mut items = scaled_items(boxes);
        let extent = Extent::of(&items);
        let mut nodes = Vec::with_capacity(boxes.len());
        nodes.push(Bvh2Node::default());
        nodes[0] = Builder { group: group as usize }.subtree(&mut nodes, &mut items, &extent, 0, 0);
        Self { nodes, order: items.iter().map(Item::index).collect() }
    }

    /// Items of a leaf.
    #[inline]
    pub(crate) fn items(&self, leaf: &Bvh2Node) -> &[u32] {
        &self.order[leaf.first_index as usize..][..leaf.prim_count as usize]
    }
}

/// Boxes scaled into about [-1, 1], so that areas neither overflow nor vanish.
fn scaled_items(boxes: &[Bounds]) -> Vec<Item> {
    let all = boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(*b));
    let (lo, hi) = (all.min.as_dvec3(), all.max.as_dvec3());
    let (centre, half) = (0.5 * (lo + hi), 0.5 * (hi - lo).max_element());
    let scale = if half > 0.0 { 1.0 / half } else { 0.0 };
    let scaled = |p: Vec3| Vec3A::from(((p.as_dvec3() - centre) * DVec3::splat(scale)).as_vec3());
    let item = |(index, b): (usize, &Bounds)| Item::new(scaled(b.min), scaled(b.max), index as u32);
    boxes.par_iter().enumerate().map(item).collect()
}

/// Builds subtrees.
struct Builder {
    group: usize,
}

impl Builder {
    /// The node of some items, of which the first is number `first` of all; its descendants go to the end of `nodes`.
    fn subtree(
        &self,
        nodes: &mut Vec<Bvh2Node>,
        items: &mut [Item],
        extent: &Extent,
        first: u32,
        depth: u32,
    ) -> Bvh2Node {
        let aabb = Aabb::new(extent.whole.lo, extent.whole.hi);
        if items.len() <= self.group {
            return Bvh2Node::new(aabb, items.len() as u32, first);
        }
        let (middle, left, right) = split(items, extent, depth);
        let (left_items, right_items) = items.split_at_mut(middle);
        let right_first = first + middle as u32;
        let children = nodes.len();
        nodes.extend([Bvh2Node::default(); 2]);
        if left_items.len() + right_items.len() >= PARALLEL_ITEMS {
            let ((a, below_a), (b, below_b)) = join(
                || self.apart(left_items, &left, first, depth + 1),
                || self.apart(right_items, &right, right_first, depth + 1),
            );
            nodes[children] = moved(nodes, &a, &below_a);
            nodes[children + 1] = moved(nodes, &b, &below_b);
        } else {
            nodes[children] = self.subtree(nodes, left_items, &left, first, depth + 1);
            nodes[children + 1] = self.subtree(nodes, right_items, &right, right_first, depth + 1);
        }
        Bvh2Node::new(aabb, 0, children as u32)
    }

    /// A subtree in a list of its own, but for its root.
    fn apart(
        &self,
        items: &mut [Item],
        extent: &Extent,
        first: u32,
        depth: u32,
    ) -> (Bvh2Node, Vec<Bvh2Node>) {
        let mut nodes = Vec::with_capacity(items.len());
        let root = self.subtree(&mut nodes, items, extent, first, depth);
        (root, nodes)
    }
}

/// Puts a subtree's list at the end of another, and gives its root as it then must be.
fn moved(nodes: &mut Vec<Bvh2Node>, root: &Bvh2Node, below: &[Bvh2Node]) -> Bvh2Node {
    let offset = nodes.len() as u32;
    let shifted = |node: &Bvh2Node| {
        let mut node = *node;
        if !node.is_leaf() {
            node.first_index += offset;
        }
        node
    };
    nodes.extend(below.iter().map(shifted));
    shifted(root)
}

#[cfg(test)]
mod tests {
    use super::split::MEDIAN_DEPTH;
    use super::*;

    fn depth(nodes: &[Bvh2Node], node: usize) -> u32 {
        let n = &nodes[node];
        if n.is_leaf() {
            1
        } else {
            1 + depth(nodes, n.first_index as usize).max(depth(nodes, n.first_index as usize + 1))
        }
    }

    fn leaves(tree: &BinaryTree) -> Vec<u32> {
        let leaves = tree.nodes.iter().filter(|n| n.is_leaf());
        let mut items: Vec<u32> = leaves.flat_map(|n| tree.items(n)).copied().collect();
        items.sort_unstable();
        items
    }

    #[test]
    fn hostile_boxes_make_shallow_trees_with_every_item_once() {
        let n = 20_000u32;
        let nested = |i: u32| Bounds { min: Vec3::splat(-1.0 - i as f32), max: Vec3::splat(1.0 + i as f32) };
        let same = |_| Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        let geometric = |i: u32| {
            let x = 2f32.powi(-(i as i32 % 140));
            Bounds { min: Vec3::splat(x), max: Vec3::splat(x) }
        };
        let huge = |i: u32| {
            let x = if i.is_multiple_of(2) { f32::MAX } else { -f32::MAX };
            Bounds { min: Vec3::splat(x), max: Vec3::splat(x) }
        };
        let cases: [&dyn Fn(u32) -> Bounds; 4] = [&nested, &same, &geometric, &huge];
        for (case, make) in cases.iter().enumerate() {
            let boxes: Vec<Bounds> = (0..n).map(make).collect();
            let tree = BinaryTree::build(&boxes, 3);
            assert_eq!(leaves(&tree), (0..n).collect::<Vec<_>>(), "case {case}");
            assert!(tree.nodes.iter().all(|n| n.prim_count as usize <= 3));
            let depth = depth(&tree.nodes, 0);
            assert!(depth <= MEDIAN_DEPTH + 16, "case {case}: {depth}");
        }
    }

    #[test]
    fn two_far_clusters_part_first() {
        let at = |x: f32| Bounds { min: Vec3::splat(x), max: Vec3::splat(x + 1.0) };
        let boxes: Vec<Bounds> = (0..64).map(|i| at(if i % 2 == 0 { 0.0 } else { 100.0 })).collect();
        let nodes = BinaryTree::build(&boxes, 1).nodes;
        let root = nodes[0];
        let [left, right] = [nodes[root.first_index as usize], nodes[root.first_index as usize + 1]];
        assert!(left.aabb.max.x < right.aabb.min.x || right.aabb.max.x < left.aabb.min.x);
    }

    #[test]
    fn nothing_makes_nothing() {
        assert!(BinaryTree::build(&[], 3).nodes.is_empty());
    }
}
