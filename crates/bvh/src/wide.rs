//! The sixteen-wide tree, made from a two-way one.

use crate::binary::BinaryTree;
use crate::collapse::{Collapse, LeafRule};
use crate::lanes::WIDTH;
use crate::node::{Child, ChildKind, Node};
use conray_core::Bounds;
use rayon::prelude::*;

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

/// The items of all leaves, one leaf after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Leaves {
    items: Vec<u32>,
    /// Where each leaf's items end.
    ends: Vec<u32>,
}

impl Leaves {
    /// How many leaves there are.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Items of a leaf.
    pub(crate) fn get(&self, leaf: usize) -> &[u32] {
        let start = if leaf == 0 { 0 } else { self.ends[leaf - 1] };
        &self.items[start as usize..self.ends[leaf] as usize]
    }

    /// Adds a leaf of what `collect` adds to the items.
    fn push(&mut self, collect: impl FnOnce(&mut Vec<u32>)) -> u32 {
        collect(&mut self.items);
        self.ends.push(self.items.len() as u32);
        self.ends.len() as u32 - 1
    }

    fn append(&mut self, other: Self) {
        let before = self.items.len() as u32;
        self.items.extend(other.items);
        self.ends.extend(other.ends.into_iter().map(|end| end + before));
    }
}

/// Levels of wide nodes whose children are shared out among threads.
const SHARED_LEVELS: u32 = 2;

impl WideTree {
    /// Makes the wide tree over `boxes` from their two-way tree, and says what is in its leaves, which it knows by number.
    pub(crate) fn new(binary: &BinaryTree, boxes: &[Bounds], rule: LeafRule) -> (Self, Leaves) {
        if binary.nodes.is_empty() {
            let tree = Self { nodes: Vec::new(), bounds: Bounds::EMPTY, levels: 0, stack_entries: 0 };
            return (tree, Leaves::default());
        }
        let collapse = Collapse::new(binary, rule);
        let mut part = Part::default();
        let found = Widening { collapse, boxes }.add(&mut part, 0, SHARED_LEVELS);
        let Found { bounds, levels, stack_entries } = found;
        (Self { nodes: part.nodes, bounds, levels, stack_entries }, part.leaves)
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

/// Nodes and leaves of a part of the tree, by numbers of its own.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    leaves: Leaves,
}

/// What a node and all below it take.
struct Found {
    bounds: Bounds,
    levels: u32,
    stack_entries: usize,
}

impl Part {
    /// Adds another part, which then comes last.
    fn append(&mut self, other: Self) {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let moved = |mut node: Node| {
            node.children.iter_mut().for_each(|child| *child = child.moved(nodes, leaves));
            node
        };
        self.nodes.extend(other.nodes.into_iter().map(moved));
        self.leaves.append(other.leaves);
    }
}

struct Widening<'a> {
    collapse: Collapse<'a>,
    boxes: &'a [Bounds],
}

impl Widening<'_> {
    /// Adds the wide node made from a two-way one, and all below it, which follow it in memory in the order of its slots. The
    /// same for any number of threads.
    fn add(&self, part: &mut Part, node: u32, shared_levels: u32) -> Found {
        let index = part.nodes.len();
        part.nodes.push(Node::UNUSED);
        let (children, count) = self.children(node);
        let children = &children[..count];
        let mut apart: Vec<Option<(Part, Found)>> = Vec::new();
        if shared_levels > 0 {
            let below = |&child: &u32| {
                if self.collapse.is_leaf(child) {
                    return None;
                }
                let mut part = Part::default();
                let found = self.add(&mut part, child, shared_levels - 1);
                Some((part, found))
            };
            children.par_iter().map(below).collect_into_vec(&mut apart);
        }
        let mut all = Found { bounds: Bounds::EMPTY, levels: 1, stack_entries: count };
        for (slot, &child) in children.iter().enumerate() {
            let (bounds, child) = if self.collapse.is_leaf(child) {
                let leaf = part.leaves.push(|items| self.collapse.add_items_below(child, items));
                let items = part.leaves.get(leaf as usize);
                let bounds = items.iter().fold(Bounds::EMPTY, |all, &i| all.union(self.boxes[i as usize]));
                (bounds, Child::leaf(leaf, items.len() as u32))
            } else {
                let next = Child::inner(part.nodes.len() as u32);
                let found = match apart.get_mut(slot).and_then(Option::take) {
                    Some((below, found)) => {
                        part.append(below);
                        found
                    }
                    None => self.add(part, child, 0),
                };
                all.levels = all.levels.max(found.levels + 1);
                all.stack_entries = all.stack_entries.max(count - 1 + found.stack_entries);
                (found.bounds, next)
            };
            part.nodes[index].set(slot, &bounds, child);
            all.bounds = all.bounds.union(bounds);
        }
        all
    }

    /// What the slots of the wide node made from a two-way one hold.
    fn children(&self, node: u32) -> ([u32; WIDTH], usize) {
        let collapse = &self.collapse;
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
        (children, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::Vec3;

    const RULE: LeafRule = LeafRule { max_items: 8, group: 2, leaf_cost: 1.0, item_cost: 0.1 };

    fn tree(boxes: &[Bounds]) -> (WideTree, Leaves) {
        WideTree::new(&BinaryTree::build(boxes, RULE.group), boxes, RULE)
    }

    fn line(n: u32) -> Vec<Bounds> {
        let at = |i: u32| Vec3::new(i as f32, (i % 7) as f32, (i % 3) as f32);
        (0..n).map(|i| Bounds { min: at(i), max: at(i) + 1.0 }).collect()
    }

    #[test]
    fn trees_of_every_small_size_are_whole() {
        for n in 0..70 {
            let boxes = line(n);
            let (tree, leaves) = tree(&boxes);
            let mut seen = vec![];
            tree.check(|bounds, leaf, items| {
                let found = leaves.get(leaf as usize);
                assert_eq!(found.len(), items as usize);
                assert!(found.iter().all(|&item| boxes[item as usize].union(*bounds) == *bounds));
                seen.extend_from_slice(found);
                Ok(())
            })
            .unwrap();
            seen.sort_unstable();
            assert_eq!(seen, (0..n).collect::<Vec<_>>());
        }
    }

    #[test]
    fn threads_change_nothing() {
        let boxes = line(60_000);
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (tree, leaves) = pool.install(|| tree(&boxes));
            tree.check(|_, _, _| Ok(())).unwrap();
            let children: Vec<_> = tree.nodes.iter().flat_map(|node| node.children).collect();
            (children, leaves.items, leaves.ends, tree.levels, tree.stack_entries)
        };
        let one = build(1);
        assert!(one.3 > SHARED_LEVELS + 1, "{} levels", one.3);
        assert_eq!(one, build(3));
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
