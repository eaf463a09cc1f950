//! The sixteen-wide tree, made from a two-way one.

use crate::binary::BinaryTree;
use crate::collapse::{Collapse, LeafRule};
use crate::node::{Child, ChildKind, Node};
use conray_core::Bounds;

/// A sixteen-wide tree. Node 0 is the root; there are no nodes where there are no items.
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

impl WideTree {
    /// Makes the wide tree over `boxes` from their two-way tree. `emit` stores the items of a leaf side by side and
    /// returns where the first of them went.
    pub(crate) fn new(
        binary: &BinaryTree,
        boxes: &[Bounds],
        rule: LeafRule,
        mut emit: impl FnMut(&[u32]) -> u32,
    ) -> Self {
        let mut tree = Self { nodes: Vec::new(), bounds: Bounds::EMPTY, levels: 0, stack_entries: 0 };
        if binary.nodes.is_empty() {
            return tree;
        }
        let collapse = Collapse::new(binary, rule);
        tree.nodes.reserve(boxes.len() / 64);
        let mut items = Vec::with_capacity(rule.max_items as usize);
        tree.bounds = tree.add(&collapse, boxes, 0, (1, 0), &mut items, &mut emit);
        tree
    }

    /// Adds the wide node made from a two-way one, and all below it, which follow it in memory. Returns their box.
    fn add(
        &mut self,
        collapse: &Collapse<'_>,
        boxes: &[Bounds],
        node: u32,
        (level, stacked): (u32, usize),
        items: &mut Vec<u32>,
        emit: &mut impl FnMut(&[u32]) -> u32,
    ) -> Bounds {
        let index = self.nodes.len();
        self.nodes.push(Node::UNUSED);
        let (mut children, count) = collapse.open(node);
        // Bundles test leaves from the first slot on and put nodes on a stack, so that they visit the last first: in each
        // way the largest, which is likeliest to block.
        children[..count].sort_by(|&a, &b| {
            let by_area = collapse.area(a).total_cmp(&collapse.area(b)).then(a.cmp(&b));
            match (collapse.is_leaf(a), collapse.is_leaf(b)) {
                (true, true) => by_area.reverse(),
                (false, false) => by_area,
                (a_is_leaf, b_is_leaf) => a_is_leaf.cmp(&b_is_leaf),
            }
        });
        self.levels = self.levels.max(level);
        self.stack_entries = self.stack_entries.max(stacked + count);
        let mut all = Bounds::EMPTY;
        for (slot, &child) in children[..count].iter().enumerate() {
            let (bounds, child) = if collapse.is_leaf(child) {
                collapse.items_below(child, items);
                let bounds = items.iter().fold(Bounds::EMPTY, |all, &i| all.union(boxes[i as usize]));
                (bounds, Child::leaf(emit(items), items.len() as u32))
            } else {
                let next = Child::inner(self.nodes.len() as u32);
                let below = (level + 1, stacked + count - 1);
                (self.add(collapse, boxes, child, below, items, emit), next)
            };
            self.nodes[index].set(slot, &bounds, child);
            all = all.union(bounds);
        }
        all
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

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::Vec3;

    const RULE: LeafRule = LeafRule { max_items: 8, group: 2, leaf_cost: 1.0, item_cost: 0.1 };

    fn tree(boxes: &[Bounds]) -> (WideTree, Vec<u32>) {
        let mut order = Vec::new();
        let tree = WideTree::new(&BinaryTree::build(boxes, RULE.group), boxes, RULE, |items| {
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
        assert!(check(&|t| t.nodes[0].planes[1][1].0[0] += 1e3).is_err());
        assert!(check(&|t| t.nodes[1].children[0] = Child::inner(0)).is_err());
        assert!(check(&|t| t.nodes[1].children[0] = Child::EMPTY).is_err());
        assert!(check(&|t| t.stack_entries -= 1).is_err());
        assert!(check(&|t| t.nodes.push(Node::UNUSED)).is_err());
        assert!(check(&|t| t.nodes.truncate(2)).is_err());
    }
}
