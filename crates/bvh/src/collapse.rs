//! Which nodes of a two-way tree become the children of sixteen-wide ones: the cheapest choice there is.
//!
//! By dynamic programming over the tree, after Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", 2017, section 4: for each node and each number of slots the least cost, by the surface area
//! heuristic, of putting all below it into that many slots. Leaving out slots never helps, so "at most" needs no case.

use crate::binary::BinaryTree;
use crate::lanes::WIDTH;
use rayon::join;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// What leaves are made of, and what visits cost a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafRule {
    /// Most items in a leaf, at most [`crate::node::Child::MAX_ITEMS`].
    pub(crate) max_items: u32,
    /// Items that always stay together, at most `max_items`.
    pub(crate) group: u32,
    /// Cost of a leaf, and of each item in it, in units of a visit to a node.
    pub(crate) leaf_cost: f32,
    pub(crate) item_cost: f32,
}

/// Subtrees of this depth are looked at by one thread; above it, halves are shared out.
const SHARED_LEVELS: u32 = 8;

/// Four bits for each number of slots from 1 to 16: the slots for the first child's subtree, or [`AS_ONE`].
type Choices = u64;
/// The subtree takes one slot only. With 16 slots, which only a whole node has, it means 15 for the first child.
const AS_ONE: u64 = 15;
/// In the place of one slot: a leaf.
const LEAF: u64 = 1;

/// The choice for every node.
pub(crate) struct Collapse<'a> {
    binary: &'a BinaryTree,
    choices: Vec<AtomicU64>,
}

/// Items below a node, and the least cost of putting them into 1 to 16 slots.
struct Costs {
    items: u32,
    by_slots: [f32; WIDTH],
}

impl<'a> Collapse<'a> {
    /// Chooses for all nodes of a tree that is not empty.
    pub(crate) fn new(binary: &'a BinaryTree, rule: LeafRule) -> Self {
        let choices = std::iter::repeat_with(|| AtomicU64::new(0)).take(binary.nodes.len()).collect();
        let collapse = Self { binary, choices };
        collapse.choose(0, rule, SHARED_LEVELS);
        collapse
    }

    fn choose(&self, index: u32, rule: LeafRule, shared_levels: u32) -> Costs {
        let node = &self.binary.nodes[index as usize];
        let area = node.aabb().half_area();
        if node.is_leaf() {
            self.choices[index as usize].store(all_as_one(LEAF), Relaxed);
            let cost = area * (rule.leaf_cost + rule.item_cost * node.prim_count as f32);
            return Costs { items: node.prim_count, by_slots: [cost; WIDTH] };
        }
        let (left, right) = (node.first_index, node.first_index + 1);
        let below = shared_levels.saturating_sub(1);
        let (left, right) = if shared_levels > 0 {
            join(|| self.choose(left, rule, below), || self.choose(right, rule, below))
        } else {
            (self.choose(left, rule, 0), self.choose(right, rule, 0))
        };
        let items = left.items + right.items;
        let (mut by_slots, firsts) = distributed(&left.by_slots, &right.by_slots);
        let as_node = area + by_slots[WIDTH - 1];
        let as_leaf = if items <= rule.max_items {
            area * (rule.leaf_cost + rule.item_cost * items as f32)
        } else {
            f32::INFINITY
        };
        let is_leaf = as_leaf <= as_node;
        let one = if is_leaf { as_leaf } else { as_node };
        by_slots[0] = one;
        let mut choices: Choices = if is_leaf { LEAF } else { 0 };
        for slots in 2..=WIDTH {
            let first = if slots < WIDTH && one <= by_slots[slots - 1] {
                by_slots[slots - 1] = one;
                AS_ONE
            } else {
                u64::from(firsts[slots - 1])
            };
            choices |= first << (4 * (slots - 1));
        }
        self.choices[index as usize].store(choices, Relaxed);
        Costs { items, by_slots }
    }

    /// Half the area of a node's box, in units of the two-way tree.
    pub(crate) fn area(&self, node: u32) -> f32 {
        self.binary.nodes[node as usize].aabb().half_area()
    }

    /// True where a node becomes a leaf.
    pub(crate) fn is_leaf(&self, node: u32) -> bool {
        self.choices[node as usize].load(Relaxed) & 15 == LEAF
    }

    /// The nodes that become the children of the wide node made from `node`; one where it is a leaf itself.
    pub(crate) fn open(&self, node: u32) -> ([u32; WIDTH], usize) {
        let (mut children, mut count) = ([node; WIDTH], 0);
        if self.is_leaf(node) {
            return (children, 1);
        }
        let mut pending = [(node, WIDTH); WIDTH];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (node, slots) = pending[height];
            let first = (self.choices[node as usize].load(Relaxed) >> (4 * (slots - 1)) & 15) as usize;
            if slots == 1 || (slots < WIDTH && first as u64 == AS_ONE) {
                children[count] = node;
                count += 1;
            } else {
                let left = self.binary.nodes[node as usize].first_index;
                pending[height] = (left + 1, slots - first);
                pending[height + 1] = (left, first);
                height += 2;
            }
        }
        (children, count)
    }

    /// Adds the items of the leaves below a node, in order.
    pub(crate) fn add_items_below(&self, node: u32, items: &mut Vec<u32>) {
        let node = &self.binary.nodes[node as usize];
        if node.is_leaf() {
            items.extend(self.binary.items(node));
        } else {
            self.add_items_below(node.first_index, items);
            self.add_items_below(node.first_index + 1, items);
        }
    }
}

/// One slot or more: a leaf of the two-way tree never takes more than one.
fn all_as_one(kind: u64) -> Choices {
    (1..WIDTH - 1).fold(kind, |choices, slot| choices | AS_ONE << (4 * slot))
}

/// For 2 to 16 slots the least sum of two subtrees' costs, and how many slots the first then has.
fn distributed(left: &[f32; WIDTH], right: &[f32; WIDTH]) -> ([f32; WIDTH], [u32; WIDTH]) {
    let (mut costs, mut firsts) = ([f32::INFINITY; WIDTH], [0; WIDTH]);
    for first in 1..WIDTH {
        // Without branches and in numbers of one width, so that the compiler takes several at once.
        let best = costs[first..].iter_mut().zip(&mut firsts[first..]);
        for ((least, chosen), right) in best.zip(right) {
            let cost = left[first - 1] + right;
            let is_less = cost < *least;
            *least = if is_less { cost } else { *least };
            *chosen = if is_less { first as u32 } else { *chosen };
        }
    }
    (costs, firsts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{Bounds, Vec3, hash_u32};

    const RULE: LeafRule = LeafRule { max_items: 6, group: 1, leaf_cost: 1.5, item_cost: 0.1 };

    fn tree(n: u32, seed: u32) -> BinaryTree {
        let unit = |i: u32| (hash_u32(i ^ hash_u32(seed)) >> 8) as f32 / (1 << 24) as f32;
        let corner = |i: u32| Vec3::new(unit(6 * i), unit(6 * i + 1), unit(6 * i + 2));
        let size = |i: u32| Vec3::new(unit(6 * i + 3), unit(6 * i + 4), unit(6 * i + 5)).powf(5.0);
        let boxes: Vec<Bounds> =
            (0..n).map(|i| Bounds { min: corner(i), max: corner(i) + size(i) }).collect();
        BinaryTree::build(&boxes, RULE.group)
    }

    /// Cost of the wide tree below a node by the surface area heuristic, with children chosen by `open`.
    fn cost(
        tree: &BinaryTree,
        node: u32,
        open: &dyn Fn(u32) -> Vec<u32>,
        is_leaf: &dyn Fn(u32) -> bool,
    ) -> f64 {
        let area = f64::from(tree.nodes[node as usize].aabb().half_area());
        if is_leaf(node) {
            return area * f64::from(RULE.leaf_cost + RULE.item_cost * items(tree, node) as f32);
        }
        area + open(node).into_iter().map(|child| cost(tree, child, open, is_leaf)).sum::<f64>()
    }

    fn items(tree: &BinaryTree, node: u32) -> u32 {
        let node = &tree.nodes[node as usize];
        if node.is_leaf() {
            node.prim_count
        } else {
            items(tree, node.first_index) + items(tree, node.first_index + 1)
        }
    }

    /// The usual way: from the root on, the node of largest area is opened until there are sixteen.
    fn largest_first(tree: &BinaryTree, node: u32, is_leaf: &dyn Fn(u32) -> bool) -> Vec<u32> {
        let area = |n: u32| tree.nodes[n as usize].aabb().half_area();
        let mut children = vec![node];
        while children.len() < WIDTH {
            let openable = (0..children.len()).filter(|&i| !is_leaf(children[i]));
            let Some(i) = openable.max_by(|&a, &b| area(children[a]).total_cmp(&area(children[b]))) else {
                break;
            };
            let first = tree.nodes[children[i] as usize].first_index;
            children[i] = first;
            children.push(first + 1);
        }
        children
    }

    #[test]
    fn no_other_way_of_opening_the_same_leaves_is_cheaper() {
        let mut cheaper = 0;
        for seed in 0..40 {
            let tree = tree(50 + 37 * seed, seed);
            let collapse = Collapse::new(&tree, RULE);
            let is_leaf = |n: u32| collapse.is_leaf(n);
            let ours = |n: u32| {
                let (children, count) = collapse.open(n);
                children[..count].to_vec()
            };
            let least = cost(&tree, 0, &ours, &is_leaf);
            let greedy = cost(&tree, 0, &|n| largest_first(&tree, n, &is_leaf), &is_leaf);
            // Two children a node is a way as well, and a bad one: the comparison can tell.
            let two =
                |n: u32| vec![tree.nodes[n as usize].first_index, tree.nodes[n as usize].first_index + 1];
            assert!(least <= greedy * (1.0 + 1e-6), "{seed}: {least} {greedy}");
            assert!(least < 0.9 * cost(&tree, 0, &two, &is_leaf), "{seed}");
            cheaper += u32::from(least < 0.995 * greedy);
        }
        assert!(cheaper > 20, "cheaper in {cheaper} of 40 trees");
    }

    #[test]
    fn the_least_cost_is_what_it_says() {
        // What the table of costs promises for the root is what its choices come to.
        let tree = tree(700, 3);
        let collapse = Collapse::new(&tree, RULE);
        let promised = f64::from(collapse.choose(0, RULE, 0).by_slots[0]);
        let ours = |n: u32| {
            let (children, count) = collapse.open(n);
            children[..count].to_vec()
        };
        let found = cost(&tree, 0, &ours, &|n| collapse.is_leaf(n));
        assert!((found / promised - 1.0).abs() < 1e-4, "{found} {promised}");
    }
}
