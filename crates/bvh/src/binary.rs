//! Two-way tree over boxes, from the top down, by the surface area heuristic over bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007. Leaves are small groups of items; which of
//! them to join is decided later, when the tree is made sixteen-wide. Work and depth are bounded for every input
//! (coincident and nested boxes included, which make agglomerative builders quadratic), and the tree is the same for
//! any number of threads: threads share out subtrees, never a decision.

use conray_core::{Bounds, Vec3};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use rayon::{join, prelude::*};

/// Bins per axis, and for few items.
const BINS: usize = 16;
const FEW_BINS: usize = 8;
const FEW_ITEMS: usize = 32;
/// From this depth on items are split by count, which bounds the depth of all trees.
const MEDIAN_DEPTH: u32 = 40;
/// Subtrees of fewer items are built by one thread.
const PARALLEL_ITEMS: usize = 8192;

#[inline]
fn half_area(lo: Vec3A, hi: Vec3A) -> f32 {
    let e = hi - lo;
    e.x * e.y + e.y * e.z + e.z * e.x
}

#[derive(Clone, Copy)]
struct Item {
    lo: Vec3A,
    hi: Vec3A,
    index: u32,
}

impl Item {
    #[inline]
    fn centre(&self) -> Vec3A {
        0.5 * (self.lo + self.hi)
    }
}

#[derive(Clone, Copy)]
struct Box3 {
    lo: Vec3A,
    hi: Vec3A,
}

impl Box3 {
    const EMPTY: Self = Self { lo: Vec3A::INFINITY, hi: Vec3A::NEG_INFINITY };

    #[inline]
    fn add(&mut self, lo: Vec3A, hi: Vec3A) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }
}

/// Boxes of some items and of their centres.
#[derive(Clone, Copy)]
struct Extent {
    whole: Box3,
    centres: Box3,
}

impl Extent {
    const EMPTY: Self = Self { whole: Box3::EMPTY, centres: Box3::EMPTY };

    #[inline]
    fn add(&mut self, item: &Item) {
        self.whole.add(item.lo, item.hi);
        self.centres.add(item.centre(), item.centre());
    }

    fn of(items: &[Item]) -> Self {
        items.iter().fold(Self::EMPTY, |mut all, item| {
            all.add(item);
            all
        })
    }
}

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
        Self { nodes, order: items.iter().map(|item| item.index).collect() }
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
    let item =
        |(index, b): (usize, &Bounds)| Item { lo: scaled(b.min), hi: scaled(b.max), index: index as u32 };
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

/// Reorders two or more items; how many go left - at least one and not all - and the extents of both sides.
fn split(items: &mut [Item], extent: &Extent, depth: u32) -> (usize, Extent, Extent) {
    if let Some(found) = split_by_area(items, extent, depth) {
        return found;
    }
    let half = items.len() / 2;
    let size = extent.centres.hi - extent.centres.lo;
    // Coincident centres may stay in any order.
    if size.max_element() > 0.0 {
        let axis = longest_axis(size);
        items.select_nth_unstable_by(half, |a, b| {
            a.centre()[axis].total_cmp(&b.centre()[axis]).then(a.index.cmp(&b.index))
        });
    }
    (half, Extent::of(&items[..half]), Extent::of(&items[half..]))
}

/// `None` where areas do not tell, or the tree is deep enough already.
fn split_by_area(items: &mut [Item], extent: &Extent, depth: u32) -> Option<(usize, Extent, Extent)> {
    let size = extent.centres.hi - extent.centres.lo;
    // Coincident centres, or a difference so small that its reciprocal overflows.
    if size.max_element() < f32::MIN_POSITIVE * 1e6 || depth >= MEDIAN_DEPTH {
        return None;
    }
    let bins = if items.len() < FEW_ITEMS { FEW_BINS } else { BINS };
    let binner = Binner::new(&extent.centres, bins);
    let (axis, boundary) = if bins == FEW_BINS {
        best_split::<FEW_BINS>(items, &binner)?
    } else {
        best_split::<BINS>(items, &binner)?
    };
    let found = partition(items, |item| binner.bins(item)[axis] < boundary);
    (found.0 > 0 && found.0 < items.len()).then_some(found)
}

fn longest_axis(extent: Vec3A) -> usize {
    (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best })
}

/// Maps centres to bins on all three axes.
struct Binner {
    origin: Vec3A,
    scale: Vec3A,
    last: Vec3A,
}

impl Binner {
    fn new(centres: &Box3, bins: usize) -> Self {
        let extent = centres.hi - centres.lo;
        let scale = |axis: usize| {
            let s = bins as f32 / extent[axis];
            if s.is_finite() { s } else { 0.0 }
        };
        Self {
            origin: centres.lo,
            scale: Vec3A::new(scale(0), scale(1), scale(2)),
            last: Vec3A::splat(bins as f32 - 1.0),
        }
    }

    #[inline]
    fn bins(&self, item: &Item) -> [usize; 3] {
        let b = ((item.centre() - self.origin) * self.scale).min(self.last);
        [b.x as usize, b.y as usize, b.z as usize]
    }
}

/// Axis and first bin on the right of the cheapest split: area times count, summed over both sides.
fn best_split<const N: usize>(items: &[Item], binner: &Binner) -> Option<(usize, usize)> {
    let mut counts = [[0u32; N]; 3];
    let mut boxes = [[Box3::EMPTY; N]; 3];
    for item in items {
        let b = binner.bins(item);
        for axis in 0..3 {
            let bin = b[axis].min(N - 1);
            counts[axis][bin] += 1;
            boxes[axis][bin].add(item.lo, item.hi);
        }
    }
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        let mut right_costs = [0.0f32; N];
        let (mut right, mut count) = (Box3::EMPTY, 0);
        for bin in (1..N).rev() {
            right.add(boxes[axis][bin].lo, boxes[axis][bin].hi);
            count += counts[axis][bin];
            right_costs[bin] =
                if count == 0 { f32::INFINITY } else { half_area(right.lo, right.hi) * count as f32 };
        }
        let (mut left, mut count) = (Box3::EMPTY, 0);
        for bin in 1..N {
            left.add(boxes[axis][bin - 1].lo, boxes[axis][bin - 1].hi);
            count += counts[axis][bin - 1];
            if count == 0 {
                continue;
            }
            let cost = half_area(left.lo, left.hi) * count as f32 + right_costs[bin];
            if cost.is_finite() && best.is_none_or(|(c, ..)| cost < c) {
                best = Some((cost, axis, bin));
            }
        }
    }
    best.map(|(_, axis, bin)| (axis, bin))
}

/// Moves the items that satisfy `is_left` to the front: how many they are, and the extents of both parts.
fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> (usize, Extent, Extent) {
    let (mut left, mut right) = (0, items.len());
    let mut extents = (Extent::EMPTY, Extent::EMPTY);
    while left < right {
        if is_left(&items[left]) {
            extents.0.add(&items[left]);
            left += 1;
        } else {
            extents.1.add(&items[left]);
            right -= 1;
            items.swap(left, right);
        }
    }
    (left, extents.0, extents.1)
}

#[cfg(test)]
mod tests {
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
