//! From boxes to a sixteen-wide tree: split from the top, improve by reinsertion, widen.
//!
//! Reinsertion: Meister, Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", 2018, as
//! implemented by the crate `obvhs`. Which nodes are tried is decided here, because the crate's own choice sorts by
//! area alone and leaves ties to a sort whose order may depend on the number of threads.

use crate::binary::BinaryTree;
use crate::collapse::LeafRule;
use crate::wide::{Leaves, WideTree};
use conray_core::Bounds;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use rayon::{join, prelude::*};

/// Share of the nodes, the largest ones, that each pass tries to move to a better place. Chosen on Crytek Sponza: twice
/// as many save no further steps worth the time.
const PASSES: [f32; 6] = [0.1, 0.05, 0.03, 0.02, 0.015, 0.01];
/// Trees whose nodes' areas sum up to more than this many times the root's are left as they are: their boxes overlap so
/// much that the search for better places would visit most of the tree each time. (Crytek Sponza: about 90.)
const MAX_CROWDING: f64 = 1000.0;
/// Reinsertion may make a tree deeper without bound; one deeper than this is dropped for the one it came from, since what
/// follows goes down by recursion.
const MOST_LEVELS: usize = 400;
/// Levels whose halves are shared out among threads where all nodes are visited.
const SHARED_LEVELS: u32 = 6;
/// Fewer nodes are not worth the trouble.
const MIN_NODES: usize = 32;

/// Builds the tree; see [`WideTree::new`].
pub(crate) fn build_wide(boxes: &[Bounds], rule: LeafRule) -> (WideTree, Leaves) {
    let mut tree = BinaryTree::build(boxes, rule.group);
    tree.nodes = reinsert(tree.nodes);
    if depth(&tree.nodes) > MOST_LEVELS {
        tree = BinaryTree::build(boxes, rule.group);
    }
    WideTree::new(&tree, boxes, rule)
}

fn reinsert(nodes: Vec<Bvh2Node>) -> Vec<Bvh2Node> {
    if nodes.len() < MIN_NODES || crowding(&nodes) > MAX_CROWDING {
        return nodes;
    }
    let mut tree = Bvh2 { nodes, ..Bvh2::default() };
    let mut optimizer = ReinsertionOptimizer::default();
    for share in PASSES {
        // The optimizer takes its stack's size from this.
        tree.max_depth = depth(&tree.nodes);
        let candidates = largest(&tree.nodes, (share * tree.nodes.len() as f32) as usize);
        optimizer.run_with_candidates(&mut tree, &candidates, 1);
    }
    tree.nodes
}

/// Sum of all nodes' areas over the root's: how many nodes a random long ray meets.
fn crowding(nodes: &[Bvh2Node]) -> f64 {
    let area = |n: &Bvh2Node| f64::from(n.aabb().half_area());
    let sum: f64 = nodes.iter().map(area).sum();
    // All in one point: nothing can be improved.
    if sum > 0.0 { sum / area(&nodes[0]) } else { f64::INFINITY }
}

/// Levels of nodes.
fn depth(nodes: &[Bvh2Node]) -> usize {
    if nodes.is_empty() { 0 } else { depth_below(nodes, 0, SHARED_LEVELS) }
}

/// Levels of nodes from one down; the halves of the uppermost are shared out among threads.
fn depth_below(nodes: &[Bvh2Node], top: u32, shared_levels: u32) -> usize {
    let node = &nodes[top as usize];
    if shared_levels > 0 && !node.is_leaf() {
        let below = |child: u32| depth_below(nodes, child, shared_levels - 1);
        let (left, right) = join(|| below(node.first_index), || below(node.first_index + 1));
        return 1 + left.max(right);
    }
    // A list in place of recursion: the tree may be deep.
    let (mut deepest, mut stack) = (0, vec![(top, 1)]);
    while let Some((n, depth)) = stack.pop() {
        let node = &nodes[n as usize];
        deepest = deepest.max(depth);
        if !node.is_leaf() {
            stack.extend([(node.first_index, depth + 1), (node.first_index + 1, depth + 1)]);
        }
    }
    deepest
}

/// The `count` nodes of largest area but for the root, by area and then by number.
fn largest(nodes: &[Bvh2Node], count: usize) -> Vec<u32> {
    let key = |i: u32| (nodes[i as usize].aabb().half_area(), i);
    let mut keys: Vec<(f32, u32)> = (1..nodes.len() as u32).into_par_iter().map(key).collect();
    let by_area = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    let count = count.clamp(1, keys.len());
    if count < keys.len() {
        keys.select_nth_unstable_by(count, by_area);
        keys.truncate(count);
    }
    keys.sort_unstable_by(by_area);
    keys.into_iter().map(|(_, node)| node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{Vec3, hash_u32};

    fn boxes(n: u32) -> Vec<Bounds> {
        let unit = |x: u32| (hash_u32(x) >> 8) as f32 / (1 << 24) as f32;
        let at = |i: u32| Vec3::new(unit(3 * i), unit(3 * i + 1), unit(3 * i + 2));
        let size = |i: u32| 0.3 * Vec3::new(unit(!i), unit(!i ^ 7), unit(!i ^ 1 << 20)).powf(6.0);
        (0..n).map(|i| Bounds { min: at(i), max: at(i) + size(i) }).collect()
    }

    #[test]
    fn reinsertion_lowers_the_cost_and_keeps_every_item() {
        let tree = BinaryTree::build(&boxes(5000), 1);
        let before = tree.nodes.clone();
        let after = reinsert(before.clone());
        let items = |nodes: &[Bvh2Node]| {
            let leaves = nodes.iter().filter(|n| n.is_leaf());
            let mut items: Vec<u32> = leaves.flat_map(|n| tree.items(n)).copied().collect();
            items.sort_unstable();
            items
        };
        assert_eq!(items(&before), items(&after));
        assert!(crowding(&after) < 0.99 * crowding(&before), "{} {}", crowding(&before), crowding(&after));
        assert!(depth(&after) >= 13);
    }

    #[test]
    fn crowded_trees_are_left_alone() {
        let nested: Vec<Bounds> =
            (1..4000).map(|i| Bounds { min: Vec3::splat(-(i as f32)), max: Vec3::splat(i as f32) }).collect();
        let nodes = BinaryTree::build(&nested, 1).nodes;
        assert!(crowding(&nodes) > MAX_CROWDING);
        let same = |a: &Bvh2Node, b: &Bvh2Node| (a.first_index, a.aabb.min) == (b.first_index, b.aabb.min);
        assert!(reinsert(nodes.clone()).iter().zip(&nodes).all(|(a, b)| same(a, b)));
    }
}
