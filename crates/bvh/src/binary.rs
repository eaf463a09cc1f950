//! Two-way tree over boxes, from the top down, by the surface area heuristic over bins.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007. Every item becomes a leaf of its own;
//! which leaves to join is decided later, when the tree is made four-wide. Work and depth are bounded for every input
//! (coincident and nested boxes included, which make agglomerative builders quadratic), and the tree is the same for
//! any number of threads: threads share out subtrees, never a decision.

use conray_core::{Bounds, Vec3};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use rayon::join;

/// Bins per axis.
const BINS: usize = 16;
/// From this depth on items are split by count, which bounds the depth of all trees.
const MEDIAN_DEPTH: u32 = 40;
/// Subtrees of fewer items are built by one thread.
const PARALLEL_ITEMS: usize = 4096;

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

/// Builds the tree over non-empty, finite boxes: `2 n - 1` nodes in the layout of [`obvhs`], none for no items.
///
/// The root is node 0 and children lie side by side. A leaf's `first_index` is its one item. Boxes are scaled to about
/// [-1, 1]: a guide for the heuristics, no bounds.
pub(crate) fn build(boxes: &[Bounds]) -> Vec<Bvh2Node> {
    if boxes.is_empty() {
        return Vec::new();
    }
    let mut items = scaled_items(boxes);
    let mut nodes = vec![Bvh2Node::default(); 2 * items.len() - 1];
    let (root, rest) = nodes.split_first_mut().expect("there is at least one item");
    build_subtree(root, rest, 1, &mut items, 0);
    nodes
}

/// Boxes scaled into about [-1, 1], so that areas neither overflow nor vanish.
fn scaled_items(boxes: &[Bounds]) -> Vec<Item> {
    let all = boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(*b));
    let (lo, hi) = (all.min.as_dvec3(), all.max.as_dvec3());
    let (centre, half) = (0.5 * (lo + hi), 0.5 * (hi - lo).max_element());
    let scale = if half > 0.0 { 1.0 / half } else { 0.0 };
    let scaled = |p: Vec3| Vec3A::from(((p.as_dvec3() - centre) * DVec3::splat(scale)).as_vec3());
    (0..).zip(boxes).map(|(index, b)| Item { lo: scaled(b.min), hi: scaled(b.max), index }).collect()
}

/// Fills `node` and its descendants, which take exactly the slots `rest`; the first of those has index `first`.
fn build_subtree(node: &mut Bvh2Node, rest: &mut [Bvh2Node], first: u32, items: &mut [Item], depth: u32) {
    let (mut whole, mut centres) = (Box3::EMPTY, Box3::EMPTY);
    for item in items.iter() {
        whole.add(item.lo, item.hi);
        centres.add(item.centre(), item.centre());
    }
    let aabb = Aabb::new(whole.lo, whole.hi);
    if let [item] = items {
        *node = Bvh2Node::new(aabb, 1, item.index);
        return;
    }
    *node = Bvh2Node::new(aabb, 0, first);
    let middle = split(items, &centres, depth);
    let (left_items, right_items) = items.split_at_mut(middle);
    let (children, rest) = rest.split_at_mut(2);
    let (left_rest, right_rest) = rest.split_at_mut(2 * middle - 2);
    let [left, right] = children else { unreachable!("split_at_mut(2) gives two") };
    let right_first = first + 2 * middle as u32;
    let parallel = left_items.len() + right_items.len() >= PARALLEL_ITEMS;
    let mut build_left = || build_subtree(left, left_rest, first + 2, left_items, depth + 1);
    let mut build_right = || build_subtree(right, right_rest, right_first, right_items, depth + 1);
    if parallel {
        join(build_left, build_right);
    } else {
        build_left();
        build_right();
    }
}

/// Reorders two or more items and returns how many go left: at least one and not all.
fn split(items: &mut [Item], centres: &Box3, depth: u32) -> usize {
    let half = items.len() / 2;
    if items.len() == 2 {
        return 1;
    }
    let extent = centres.hi - centres.lo;
    // Coincident centres, or a difference so small that its reciprocal overflows.
    if extent.max_element() < f32::MIN_POSITIVE * 1e6 {
        return half;
    }
    if depth >= MEDIAN_DEPTH {
        let axis = longest_axis(extent);
        items.select_nth_unstable_by(half, |a, b| {
            a.centre()[axis].total_cmp(&b.centre()[axis]).then(a.index.cmp(&b.index))
        });
        return half;
    }
    let bins = if items.len() < 16 { 8 } else { BINS };
    let Some((axis, boundary)) = best_split(items, centres, bins) else { return half };
    let binner = Binner::new(centres, bins);
    let middle = partition(items, |item| binner.bins(item)[axis] < boundary);
    if middle == 0 || middle == items.len() { half } else { middle }
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
fn best_split(items: &[Item], centres: &Box3, bins: usize) -> Option<(usize, usize)> {
    let binner = Binner::new(centres, bins);
    let mut counts = [[0u32; BINS]; 3];
    let mut boxes = [[Box3::EMPTY; BINS]; 3];
    for item in items {
        let b = binner.bins(item);
        for axis in 0..3 {
            let bin = b[axis].min(BINS - 1);
            counts[axis][bin] += 1;
            boxes[axis][bin].add(item.lo, item.hi);
        }
    }
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        let mut right_costs = [0.0f32; BINS];
        let (mut right, mut count) = (Box3::EMPTY, 0);
        for bin in (1..bins).rev() {
            right.add(boxes[axis][bin].lo, boxes[axis][bin].hi);
            count += counts[axis][bin];
            right_costs[bin] =
                if count == 0 { f32::INFINITY } else { half_area(right.lo, right.hi) * count as f32 };
        }
        let (mut left, mut count) = (Box3::EMPTY, 0);
        for bin in 1..bins {
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

/// Moves the items that satisfy `is_left` to the front and returns how many there are.
fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let (mut left, mut right) = (0, items.len());
    while left < right {
        if is_left(&items[left]) {
            left += 1;
        } else {
            right -= 1;
            items.swap(left, right);
        }
    }
    left
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

    fn leaves(nodes: &[Bvh2Node]) -> Vec<u32> {
        let mut items: Vec<u32> = nodes.iter().filter(|n| n.is_leaf()).map(|n| n.first_index).collect();
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
            let nodes = build(&boxes);
            assert_eq!(nodes.len(), 2 * n as usize - 1);
            assert_eq!(leaves(&nodes), (0..n).collect::<Vec<_>>(), "case {case}");
            assert!(depth(&nodes, 0) <= MEDIAN_DEPTH + 16, "case {case}: {}", depth(&nodes, 0));
        }
    }

    #[test]
    fn two_far_clusters_part_first() {
        let at = |x: f32| Bounds { min: Vec3::splat(x), max: Vec3::splat(x + 1.0) };
        let boxes: Vec<Bounds> = (0..64).map(|i| at(if i % 2 == 0 { 0.0 } else { 100.0 })).collect();
        let nodes = build(&boxes);
        let root = nodes[0];
        let [left, right] = [nodes[root.first_index as usize], nodes[root.first_index as usize + 1]];
        assert!(left.aabb.max.x < right.aabb.min.x || right.aabb.max.x < left.aabb.min.x);
    }

    #[test]
    fn nothing_makes_nothing() {
        assert!(build(&[]).is_empty());
    }
}
