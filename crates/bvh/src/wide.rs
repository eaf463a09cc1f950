//! From the two-way tree to the four-wide one: which items share a leaf, which nodes open into their parent.
//!
//! Leaves are joined where the surface area heuristic says so (Goldsmith, Salmon, "Automatic Creation of Object
//! Hierarchies for Ray Tracing", 1987); a wide node starts from two children and opens the one of largest area until
//! it has four (Dammertz, Hanika, Keller, "Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent
//! Rays", 2008).

use crate::node::{Child, ChildKind, Node};
use conray_core::Bounds;
use obvhs::bvh2::node::Bvh2Node;

/// What leaves are made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafRule {
    /// Most items in a leaf, at most [`Child::MAX_ITEMS`].
    pub(crate) max_items: u32,
    /// Items that are tested at one go.
    pub(crate) group: u32,
    /// Cost of testing one group, in units of a step through a two-way node.
    pub(crate) group_cost: f32,
}

/// A four-wide tree. Node 0 is the root; there are no nodes where there are no items.
#[derive(Clone, Debug)]
pub(crate) struct WideTree {
    pub(crate) nodes: Vec<Node>,
    /// Box of everything.
    pub(crate) bounds: Bounds,
    /// Levels of nodes.
    pub(crate) levels: u32,
    /// Most entries that a traversal's stack ever holds.
    pub(crate) stack_entries: usize,
}

/// A wide node to be made: from which two-way node, for which slot, how deep.
struct Pending {
    binary: u32,
    parent: Option<(u32, usize)>,
    level: u32,
    stacked: usize,
}

impl WideTree {
    /// Makes the wide tree over `boxes` from their two-way tree. `emit` stores the items of a leaf side by side and
    /// returns where the first of them went.
    pub(crate) fn new(
        binary: &[Bvh2Node],
        boxes: &[Bounds],
        rule: LeafRule,
        mut emit: impl FnMut(&[u32]) -> u32,
    ) -> Self {
        let mut tree = Self { nodes: Vec::new(), bounds: Bounds::EMPTY, levels: 0, stack_entries: 0 };
        if binary.is_empty() {
            return tree;
        }
        let plan = Plan::new(binary, boxes, rule);
        tree.bounds = plan.bounds[0];
        tree.nodes.reserve(boxes.len() / 4);
        let mut items = Vec::with_capacity(rule.max_items as usize);
        let mut pending = vec![Pending { binary: 0, parent: None, level: 1, stacked: 0 }];
        while let Some(task) = pending.pop() {
            let index = tree.nodes.len() as u32;
            if let Some((parent, slot)) = task.parent {
                tree.nodes[parent as usize].children[slot] = Child::inner(index);
            }
            let (children, count) = plan.open(task.binary, binary);
            let mut node = Node::UNUSED;
            tree.levels = tree.levels.max(task.level);
            tree.stack_entries = tree.stack_entries.max(task.stacked + count);
            // Pushed backwards, so that the first child follows its parent in memory.
            for slot in (0..count).rev() {
                let child = children[slot];
                let bounds = &plan.bounds[child as usize];
                if plan.is_leaf[child as usize] {
                    plan.items_below(child, binary, &mut items);
                    node.set(slot, bounds, Child::leaf(emit(&items), items.len() as u32));
                } else {
                    node.set(slot, bounds, Child::inner(0));
                    let stacked = task.stacked + count - 1;
                    let parent = Some((index, slot));
                    pending.push(Pending { binary: child, parent, level: task.level + 1, stacked });
                }
            }
            tree.nodes.push(node);
        }
        tree
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        (self.nodes.capacity() * size_of::<Node>()) as u64
    }

    /// Checks that boxes lie inside their parents', that no node is reached twice or never, and that the stack's size
    /// is enough; hands every leaf to `leaf` (box, first item, number of items).
    pub(crate) fn check(
        &self,
        mut leaf: impl FnMut(&Bounds, u32, u32) -> Result<(), String>,
    ) -> Result<(), String> {
        if self.nodes.is_empty() {
            return Ok(());
        }
        let mut reached = vec![false; self.nodes.len()];
        let mut stack = vec![(0u32, self.bounds, 1u32, 0usize)];
        while let Some((index, outer, level, stacked)) = stack.pop() {
            let node = self.nodes.get(index as usize).ok_or(format!("node {index} does not exist"))?;
            if std::mem::replace(&mut reached[index as usize], true) {
                return Err(format!("node {index} is reached twice"));
            }
            let count = node.slots().count();
            if count == 0 || node.slots().zip(&node.children).any(|((_, a), b)| a != *b) {
                return Err(format!("node {index} has no children or gaps between them"));
            }
            if level > self.levels || stacked + count > self.stack_entries {
                return Err(format!("node {index} is deeper than the tree says"));
            }
            for (bounds, child) in node.slots() {
                if bounds.is_empty() || bounds.union(outer) != outer {
                    return Err(format!(
                        "a child of node {index} is empty or sticks out: {bounds:?} of {outer:?}"
                    ));
                }
                match child.kind() {
                    ChildKind::Inner(next) => stack.push((next, bounds, level + 1, stacked + count - 1)),
                    ChildKind::Leaf(first, items) => leaf(&bounds, first, items)?,
                }
            }
        }
        match reached.iter().position(|r| !r) {
            Some(node) => Err(format!("node {node} is never reached")),
            None => Ok(()),
        }
    }
}

/// What the two-way tree will become, per node.
struct Plan {
    /// Exact boxes.
    bounds: Vec<Bounds>,
    /// Nodes that become leaves.
    is_leaf: Vec<bool>,
}

impl Plan {
    fn new(binary: &[Bvh2Node], boxes: &[Bounds], rule: LeafRule) -> Self {
        let mut bounds = vec![Bounds::EMPTY; binary.len()];
        let mut is_leaf = vec![false; binary.len()];
        let mut costs = vec![0f32; binary.len()];
        let mut counts = vec![0u32; binary.len()];
        for &n in parents_first(binary).iter().rev() {
            let (i, node) = (n as usize, &binary[n as usize]);
            let area = node.aabb().half_area();
            let leaf_cost = |items: u32| area * rule.group_cost * items.div_ceil(rule.group) as f32;
            if node.is_leaf() {
                bounds[i] = boxes[node.first_index as usize];
                (counts[i], costs[i], is_leaf[i]) = (1, leaf_cost(1), true);
                continue;
            }
            let (l, r) = (node.first_index as usize, node.first_index as usize + 1);
            bounds[i] = bounds[l].union(bounds[r]);
            counts[i] = counts[l] + counts[r];
            costs[i] = area + costs[l] + costs[r];
            if counts[i] <= rule.max_items && leaf_cost(counts[i]) <= costs[i] {
                (costs[i], is_leaf[i]) = (leaf_cost(counts[i]), true);
            }
        }
        Self { bounds, is_leaf }
    }

    /// The two to four nodes that become the children of the wide node made from `node`; one where it is a leaf itself.
    fn open(&self, node: u32, binary: &[Bvh2Node]) -> ([u32; 4], usize) {
        let (mut children, mut count) = ([node, 0, 0, 0], 1);
        while count < 4 {
            let area = |c: u32| binary[c as usize].aabb().half_area();
            let openable = (0..count).filter(|&i| !self.is_leaf[children[i] as usize]);
            let Some(i) = openable.max_by(|&a, &b| area(children[a]).total_cmp(&area(children[b]))) else {
                break;
            };
            let first = binary[children[i] as usize].first_index;
            (children[i], children[count]) = (first, first + 1);
            count += 1;
        }
        (children, count)
    }

    /// Items of the leaves below a node, in order.
    fn items_below(&self, node: u32, binary: &[Bvh2Node], items: &mut Vec<u32>) {
        items.clear();
        let mut stack = vec![node];
        while let Some(n) = stack.pop() {
            let node = &binary[n as usize];
            if node.is_leaf() {
                items.push(node.first_index);
            } else {
                stack.extend([node.first_index + 1, node.first_index]);
            }
        }
    }
}

/// All nodes, each before its children.
fn parents_first(binary: &[Bvh2Node]) -> Vec<u32> {
    let mut order = Vec::with_capacity(binary.len());
    let mut stack = vec![0u32];
    while let Some(n) = stack.pop() {
        order.push(n);
        let node = &binary[n as usize];
        if !node.is_leaf() {
            stack.extend([node.first_index + 1, node.first_index]);
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binary::build;
    use conray_core::Vec3;

    const RULE: LeafRule = LeafRule { max_items: 8, group: 4, group_cost: 1.0 };

    fn tree(boxes: &[Bounds]) -> (WideTree, Vec<u32>) {
        let mut order = Vec::new();
        let tree = WideTree::new(&build(boxes), boxes, RULE, |items| {
            order.extend_from_slice(items);
            (order.len() - items.len()) as u32
        });
        (tree, order)
    }

    fn line(n: u32) -> Vec<Bounds> {
        let at = |i: u32| Vec3::new(i as f32, (i % 7) as f32, (i % 3) as f32);
        (0..n).map(|i| Bounds { min: at(i), max: at(i) + 1.0 }).collect()
    }

    #[test]
    fn trees_of_every_small_size_are_whole() {
        for n in 0..70 {
            let boxes = line(n);
            let (tree, mut order) = tree(&boxes);
            let mut seen = 0;
            tree.check(|bounds, first, items| {
                for &item in &order[first as usize..(first + items) as usize] {
                    let inner = boxes[item as usize];
                    assert_eq!(inner.union(*bounds), *bounds);
                }
                seen += items;
                Ok(())
            })
            .unwrap();
            order.sort_unstable();
            assert_eq!((seen, order), (n, (0..n).collect()));
        }
    }

    #[test]
    fn the_check_can_fail() {
        let (whole, _) = tree(&line(70));
        let check = |damage: &dyn Fn(&mut WideTree)| {
            let mut tree = whole.clone();
            damage(&mut tree);
            tree.check(|_, _, _| Ok(()))
        };
        assert_eq!(check(&|_| ()), Ok(()));
        assert!(check(&|t| t.bounds.max.x -= 1.0).is_err());
        assert!(check(&|t| t.nodes[0].planes[1][1][0] += 1e3).is_err());
        assert!(check(&|t| t.nodes[1].children[0] = Child::inner(0)).is_err());
        assert!(check(&|t| t.nodes[1].children[0] = Child::EMPTY).is_err());
        assert!(check(&|t| t.stack_entries -= 1).is_err());
        assert!(check(&|t| t.nodes.push(Node::UNUSED)).is_err());
        assert!(check(&|t| t.nodes.truncate(2)).is_err());
    }
}
