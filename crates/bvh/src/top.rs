//! The top level: a tree over the placements of instanced meshes.

use crate::blas::TriangleTree;
use crate::collapse::LeafRule;
use crate::mesh_space::{MeshSpace, corner_rounding};
use crate::placement::wide_matrix;
use crate::refine::build_wide;
use crate::wide::WideTree;
use conray_core::{Affine3A, Bounds, Vec3};
use glam::DVec3;

/// One placement a leaf: each is worth a tree of its own.
const LEAF_RULE: LeafRule = LeafRule { max_items: 1, group: 1, leaf_cost: 4.0, item_cost: 0.0 };

/// An instance that is not flattened.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    /// Index into the geometry's instances.
    pub(crate) instance: u32,
    /// Index into the trees of instanced meshes.
    pub(crate) tree: u32,
    pub(crate) world_from_mesh: Affine3A,
    /// `None` where the transform cannot be undone: then all of its triangles are tested.
    pub(crate) mesh_space: Option<MeshSpace>,
}

/// Placements under a tree.
#[derive(Clone, Debug)]
pub(crate) struct TopLevel {
    pub(crate) tree: WideTree,
    /// In the order of the leaves.
    pub(crate) placed: Vec<Placed>,
}

impl TopLevel {
    pub(crate) fn build(placed: &[Placed], trees: &[TriangleTree]) -> Self {
        let boxes: Vec<Bounds> =
            placed.iter().map(|p| world_bounds(p, &trees[p.tree as usize].tree)).collect();
        let (tree, leaves) = build_wide(&boxes, LEAF_RULE);
        let items = (0..leaves.len()).flat_map(|leaf| leaves.get(leaf));
        let placed = items.map(|&i| placed[i as usize].clone()).collect();
        Self { tree, placed }
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.tree.memory_bytes() + (self.placed.capacity() * size_of::<Placed>()) as u64
    }
}

/// World box of a placed tree: of the boxes two levels down, transformed, which is tighter than the root's.
fn world_bounds(placed: &Placed, tree: &WideTree) -> Bounds {
    let mut boxes = Vec::with_capacity(16);
    for (bounds, child) in tree.nodes.first().iter().flat_map(|root| root.slots()) {
        match child.kind() {
            crate::node::ChildKind::Inner(node) => {
                boxes.extend(tree.nodes[node as usize].slots().map(|(bounds, _)| bounds));
            }
            crate::node::ChildKind::Leaf(..) => boxes.push(bounds),
        }
    }
    let rounding = corner_rounding(&placed.world_from_mesh, &tree.bounds);
    boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(transformed(&placed.world_from_mesh, b, rounding)))
}

/// Box around a transformed box, grown by `rounding` and then outward to single precision.
fn transformed(world_from_mesh: &Affine3A, bounds: &Bounds, rounding: DVec3) -> Bounds {
    let (matrix, translation) = wide_matrix(world_from_mesh);
    let (lo, hi) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let centre = matrix * (0.5 * (lo + hi)) + translation;
    let half = crate::placement::abs_matrix(&matrix) * (0.5 * (hi - lo)) + rounding;
    let (min, max) = ((centre - half).as_vec3(), (centre + half).as_vec3());
    let outward = |v: Vec3, next: fn(f32) -> f32| {
        Vec3::from_array(v.to_array().map(|x| {
            // Overflow has been ruled out for the corners themselves, not for this box around them.
            next(x).clamp(f32::MIN, f32::MAX)
        }))
    };
    Bounds { min: outward(min, f32::next_down), max: outward(max, f32::next_up) }
}
