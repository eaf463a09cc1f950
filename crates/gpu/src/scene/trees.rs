//! Trees of compressed wide nodes: one of placements, one for each mesh that several of them show, and one of all other triangles in the world.

use super::{
    materials::Materials,
    triangles::{GpuTriangle, Triangles},
};
use bytemuck::{Pod, Zeroable};
use conray_core::{Affine3A, Geometry};
use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    bvh2::reinsertion::ReinsertionOptimizer,
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode},
    ploc::PlocBuilder,
};
use std::collections::BTreeMap;

/// It is mirrored.
const TURNED: u32 = 2;
/// Its triangles are those of a mesh, and not in the world yet.
const MOVED: u32 = 4;

/// A tree of triangles in the world.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuPlacement {
    pub(crate) world_from_mesh: [[f32; 4]; 3],
    pub(crate) mesh_from_world: [[f32; 4]; 3],
    pub(crate) root: u32,
    pub(crate) flags: u32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
}

impl GpuPlacement {
    fn new(world_from_mesh: &Affine3A, root: u32, moved: bool) -> Self {
        let mirrored = world_from_mesh.matrix3.determinant() < 0.0;
        Self {
            world_from_mesh: rows(world_from_mesh),
            mesh_from_world: rows(&world_from_mesh.inverse()),
            root,
            flags: if mirrored { TURNED } else { 0 } | if moved { MOVED } else { 0 },
            pad_a: 0,
            pad_b: 0,
        }
    }
}

fn rows(affine: &Affine3A) -> [[f32; 4]; 3] {
    let m = affine.matrix3.transpose();
    let t = affine.translation;
    [m.x_axis.extend(t.x), m.y_axis.extend(t.y), m.z_axis.extend(t.z)].map(|row| row.to_array())
}

/// The tree over some things: by the steps of the crate's own builder, which looks at a clock that pages do not have.
fn compressed<T: Boundable>(things: &[T], params: &BvhBuildParams) -> CwBvh {
    let all = (0..things.len() as u32).collect();
    let mut builder = PlocBuilder::with_capacity(things.len());
    let (distance, precision, depth) =
        (params.ploc_search_distance, params.sort_precision, params.search_depth_threshold);
    let mut binary = builder.build(distance, things, all, precision, depth);
    ReinsertionOptimizer::default().run(&mut binary, params.reinsertion_batch_ratio, None);
    // Three is what a leaf of compressed nodes holds.
    bvh2_to_cwbvh(&binary, params.max_prims_per_leaf.clamp(1, 3), true, false)
}

/// All that rays go through.
#[derive(Default)]
pub(super) struct Trees {
    pub(super) nodes: Vec<CwBvhNode>,
    pub(super) triangles: Triangles,
    /// In the order in which the leaves of the first tree name them.
    pub(super) placements: Vec<GpuPlacement>,
}

impl Trees {
    pub(super) fn new(geometry: &Geometry, materials: &Materials) -> Self {
        let mut placed: BTreeMap<u32, Vec<&Affine3A>> = BTreeMap::new();
        for instance in geometry.instances() {
            placed.entry(instance.mesh).or_default().push(&instance.world_from_mesh);
        }
        let mut all = Self::default();
        // A placement of its own would cost a walk: what is shown once stands in the world.
        let (alone, shared): (Vec<_>, Vec<_>) = placed.into_iter().partition(|(_, of)| of.len() == 1);
        let mut flat = Triangles::default();
        for (mesh, of) in alone {
            flat.add(geometry, mesh as usize, materials, Some(of[0]));
        }
        let mut boxes = Vec::new();
        let mut trees = Vec::new();
        all.plant(flat, &mut trees);
        boxes.push(trees[0].total_aabb);
        let mut roots = vec![(0, Affine3A::IDENTITY)];
        for (mesh, of) in shared {
            let mut own = Triangles::default();
            own.add(geometry, mesh as usize, materials, None);
            if own.list.is_empty() {
                continue;
            }
            let corners = own.list.iter().flat_map(|t| [t.a, t.b, t.c]).collect::<Vec<_>>();
            all.plant(own, &mut trees);
            for world_from_mesh in of {
                let mut bounds = Aabb::INVALID;
                for &corner in &corners {
                    bounds.extend(world_from_mesh.transform_point3(corner).into());
                }
                boxes.push(bounds);
                roots.push((trees.len() - 1, *world_from_mesh));
            }
        }
        let one = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        // An empty tree of the world's own is no box.
        let used: Vec<usize> = (0..boxes.len()).filter(|&k| k > 0 || !trees[0].nodes.is_empty()).collect();
        let used_boxes: Vec<Aabb> = used.iter().map(|&k| boxes[k]).collect();
        let top = if used_boxes.is_empty() { CwBvh::default() } else { compressed(&used_boxes, &one) };
        all.lay_out(top, trees, &roots, &used);
        all
    }

    /// Builds a tree over triangles, which join the list in the order of its leaves; the nodes wait.
    fn plant(&mut self, mut own: Triangles, trees: &mut Vec<CwBvh>) {
        let boxes: Vec<_> = own.list.iter().map(GpuTriangle::corners).collect();
        let mut tree = if boxes.is_empty() {
            CwBvh::default()
        } else {
            compressed(&boxes, &BvhBuildParams::medium_build())
        };
        own.reorder(&tree.primitive_indices);
        let first = self.triangles.list.len() as u32;
        tree.nodes.iter_mut().for_each(|node| node.primitive_base_idx += first);
        self.triangles.append(own);
        trees.push(tree);
    }

    /// Puts nodes one behind the other, those of the placements first, and placements in the order of their leaves.
    fn lay_out(&mut self, top: CwBvh, trees: Vec<CwBvh>, roots: &[(usize, Affine3A)], used: &[usize]) {
        let mut firsts = Vec::new();
        let add = |tree: &CwBvh, nodes: &mut Vec<CwBvhNode>| {
            let first = nodes.len() as u32;
            let moved = |node: &CwBvhNode| CwBvhNode { child_base_idx: node.child_base_idx + first, ..*node };
            nodes.extend(tree.nodes.iter().map(moved));
            first
        };
        add(&top, &mut self.nodes);
        for tree in &trees {
            firsts.push(add(tree, &mut self.nodes));
        }
        // Where nothing occludes there is one all the same, which no leaf names.
        let mut order: Vec<usize> = top.primitive_indices.iter().map(|&k| used[k as usize]).collect();
        if order.is_empty() {
            order.push(0);
        }
        self.placements =
            order.iter().map(|&k| GpuPlacement::new(&roots[k].1, firsts[roots[k].0], k > 0)).collect();
    }
}
