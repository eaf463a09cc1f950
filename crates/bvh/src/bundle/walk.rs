//! The walk of a bundle through the tree: nearest boxes first, each with the rays that meet it.

use super::{Met, boxes::NearBoxes, rays::Rays, triangles::HalfSpaces};
use crate::{
    blas::TriangleTree,
    node::{Child, ChildKind, Node},
    ray::PreparedRay,
    triangle::crossing,
};
use conray_core::{Ray, Vec3};
use fearless_simd::Simd;

/// Subtrees put off, at most; deeper trees are left to single rays.
const STACK: usize = 128;

/// A subtree to visit: which rays meet its box, and how far the box is.
#[derive(Clone, Copy)]
struct Waiting {
    child: Child,
    rays: u64,
    distance: f32,
}

/// Finds what the rays meet among the triangles that are stored in world space; `None` where the tree is too deep.
#[inline(always)]
pub(super) fn walk<S: Simd>(simd: S, triangles: &TriangleTree, rays: &Rays) -> Option<Met> {
    let tree = &triangles.tree;
    let mut met = Met::default();
    if tree.nodes.is_empty() {
        return Some(met);
    }
    if tree.stack_entries > STACK {
        return None;
    }
    let mut next = Waiting { child: Child::inner(0), rays: rays.all, distance: 0.0 };
    let mut stack = [next; STACK];
    let mut height = 0;
    loop {
        let active = next.rays & !met.blocked;
        if active != 0 {
            match next.child.kind() {
                ChildKind::Inner(index) => {
                    height = open(simd, &tree.nodes[index as usize], rays, active, &mut stack, height);
                }
                ChildKind::Leaf(first, items) => {
                    leaf(simd, triangles, (first, items), rays, active, &mut met)
                }
            }
        }
        if height == 0 || met.blocked == rays.all {
            return Some(met);
        }
        height -= 1;
        next = stack[height];
    }
}

/// Puts the children that active rays meet on the stack, the nearest on top, and gives its new height.
#[inline(always)]
fn open<S: Simd>(
    simd: S,
    node: &Node,
    rays: &Rays,
    active: u64,
    stack: &mut [Waiting; STACK],
    base: usize,
) -> usize {
    let boxes = NearBoxes::new(node, rays);
    let mut height = base;
    let mut reachable = boxes.reachable;
    while reachable != 0 {
        let child = reachable.trailing_zeros() as usize & 3;
        reachable &= reachable - 1;
        let here = boxes.met_by(simd, child, rays, active);
        if here == 0 {
            continue;
        }
        let entry = Waiting { child: node.children[child], rays: here, distance: boxes.distance[child] };
        let mut at = height;
        while at > base && stack[at - 1].distance < entry.distance {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = entry;
        height += 1;
    }
    height
}

/// Tests the triangles of a leaf.
#[inline(always)]
fn leaf<S: Simd>(
    simd: S,
    triangles: &TriangleTree,
    (first, items): (u32, u32),
    rays: &Rays,
    active: u64,
    met: &mut Met,
) {
    let mut left = items as usize;
    for packet in first as usize..(first + items.div_ceil(4)) as usize {
        let four = HalfSpaces::new(&triangles.packets[packet], rays);
        for lane in 0..left.min(4) {
            let decided = four.test(simd, lane, rays, active & !met.blocked);
            if decided.inside | decided.unsure == 0 {
                continue;
            }
            if triangles.ids[packet][lane].is_opaque() {
                met.blocked |= decided.inside;
                if decided.unsure != 0 {
                    met.blocked |= settle(&triangles.packets[packet].lane(lane), rays, decided.unsure);
                }
            } else {
                met.unsettled |= decided.inside | decided.unsure;
            }
        }
        left = left.saturating_sub(4);
    }
}

/// The exact test of the rays that the wide one was not sure of.
#[cold]
fn settle(corners: &[Vec3; 3], rays: &Rays, mut unsure: u64) -> u64 {
    let mut blocked = 0;
    while unsure != 0 {
        let index = unsure.trailing_zeros() as usize;
        unsure &= unsure - 1;
        let direction = rays.direction[index / 16].map(|axis| axis.0[index % 16]);
        let ray = Ray { origin: rays.origin, direction: Vec3::from_array(direction), t_max: rays.t_max };
        let met = PreparedRay::new(&ray).and_then(|ray| crossing(corners, &ray));
        if met.is_some_and(|c| c.t < rays.t_max) {
            blocked |= 1 << index;
        }
    }
    blocked
}
