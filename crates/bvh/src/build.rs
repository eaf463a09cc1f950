//! Deciding what is flattened and what stays instanced, and building all levels.

use crate::blas::TriangleTree;
use crate::bvh::Bvh;
use crate::mesh_space::MeshSpace;
use crate::node::Child;
use crate::packet::{PlacedTriangle, TriangleId};
use crate::placement::{abs_matrix, wide_matrix, world_corner};
use crate::top::{Placed, TopLevel};
use conray_core::{Affine3A, Bounds, Geometry, Opacity, TriangleMesh};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use thiserror::Error;

/// Why no hierarchy can be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BvhError {
    /// More than the layout's indices reach.
    #[error("{what}: {count} are more than the limit of {limit}")]
    TooMany {
        /// Kind of thing.
        what: &'static str,
        /// How many.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// A transform takes a vertex beyond single precision.
    #[error("instance {instance} ({name}) reaches beyond what single-precision coordinates hold")]
    Overflow {
        /// Index of the instance.
        instance: usize,
        /// Its name; may be empty.
        name: String,
    },
}

/// Meshes whose placements have no more triangles than this together are flattened: a tree of their own saves nothing.
const FLAT_TRIANGLES: u64 = 1024;
/// Instanced placements that cannot be undone are flattened up to so many triangles in all; others are searched
/// without a tree, which is slow but right.
const MAX_SINGULAR_TRIANGLES: u64 = 1 << 20;

/// What a mesh's material means for its triangles.
#[derive(Clone, Copy, PartialEq)]
enum Blocking {
    Nothing,
    Fully,
    ByLookUp,
}

impl Blocking {
    fn of(geometry: &Geometry, mesh: usize) -> Self {
        match geometry.opacity(mesh) {
            // Which side was met is looked up too.
            Opacity::Constant(o) if *o >= 1.0 && !geometry.is_one_sided(mesh) => Self::Fully,
            Opacity::Constant(o) if *o > 0.0 => Self::ByLookUp,
            Opacity::Constant(_) => Self::Nothing,
            Opacity::Texture(_) => Self::ByLookUp,
        }
    }
}

pub(crate) fn build(geometry: Arc<Geometry>) -> Result<Bvh, BvhError> {
    check_counts(&geometry)?;
    let blocking: Vec<Blocking> = (0..geometry.meshes().len()).map(|m| Blocking::of(&geometry, m)).collect();
    let plan = Plan::new(&geometry, &blocking);
    check_overflow(&geometry)?;

    let instanced: Vec<u32> = plan.instanced_meshes();
    let trees: Vec<TriangleTree> = instanced
        .par_iter()
        .map(|&m| {
            let opaque = blocking[m as usize] == Blocking::Fully;
            TriangleTree::build(&triangles_of(&geometry.meshes()[m as usize], None, 0, opaque))
        })
        .collect();
    let (placed, mut singular) = place(&geometry, &plan, &instanced, &trees, &blocking);

    let mut flat = flattened(&geometry, &plan, &blocking);
    flat.append(&mut singular);
    let flat = TriangleTree::build(&flat);
    let top = TopLevel::build(&placed, &trees);
    Ok(Bvh::from_levels(geometry, flat, trees, top))
}

/// Which meshes are flattened.
struct Plan {
    /// Per mesh: `None` where it occludes nothing, else whether it is flattened.
    flat: Vec<Option<bool>>,
}

impl Plan {
    fn new(geometry: &Geometry, blocking: &[Blocking]) -> Self {
        let mut uses = vec![0u64; geometry.meshes().len()];
        geometry.instances().iter().for_each(|i| uses[i.mesh as usize] += 1);
        let decide = |(m, mesh): (usize, &TriangleMesh)| {
            let triangles = mesh.triangles().len() as u64;
            let occludes = uses[m] > 0 && triangles > 0 && blocking[m] != Blocking::Nothing;
            occludes.then_some(uses[m] == 1 || uses[m] * triangles <= FLAT_TRIANGLES)
        };
        Self { flat: geometry.meshes().iter().enumerate().map(decide).collect() }
    }

    fn is_flat(&self, mesh: usize) -> bool {
        self.flat[mesh] == Some(true)
    }

    fn instanced_meshes(&self) -> Vec<u32> {
        (0..).zip(&self.flat).filter(|(_, flat)| **flat == Some(false)).map(|(m, _)| m).collect()
    }
}

/// Instances for the top level, and the triangles of those that are flattened because their transforms cannot be undone.
fn place(
    geometry: &Geometry,
    plan: &Plan,
    instanced: &[u32],
    trees: &[TriangleTree],
    blocking: &[Blocking],
) -> (Vec<Placed>, Vec<PlacedTriangle>) {
    let mut placed = Vec::new();
    let mut singular = Vec::new();
    for (i, instance) in (0u32..).zip(geometry.instances()) {
        let m = instance.mesh as usize;
        if plan.flat[m] != Some(false) {
            continue;
        }
        let tree = instanced.binary_search(&instance.mesh).expect("it is one of them");
        let triangles = trees[tree].triangles;
        if triangles == 0 {
            continue;
        }
        let world_from_mesh = instance.world_from_mesh;
        let mesh_space = MeshSpace::new(&world_from_mesh, &trees[tree].tree.bounds);
        if mesh_space.is_none() && singular.len() as u64 + triangles <= MAX_SINGULAR_TRIANGLES {
            // A placement scaled to a line or a point leaves no triangle at all: it costs nothing.
            let opaque = blocking[m] == Blocking::Fully;
            singular.append(&mut triangles_of(&geometry.meshes()[m], Some(&world_from_mesh), i, opaque));
            continue;
        }
        placed.push(Placed { instance: i, tree: tree as u32, world_from_mesh, mesh_space });
    }
    (placed, singular)
}

/// The triangles of all flattened meshes that have three corners, in the world.
fn flattened(geometry: &Geometry, plan: &Plan, blocking: &[Blocking]) -> Vec<PlacedTriangle> {
    // Which instances, and how many triangles there are up to each, itself included.
    let (mut instances, mut ends, mut total) = (Vec::new(), Vec::new(), 0);
    for (i, instance) in (0u32..).zip(geometry.instances()) {
        if plan.is_flat(instance.mesh as usize) {
            total += geometry.meshes()[instance.mesh as usize].triangles().len();
            instances.push(i);
            ends.push(total);
        }
    }
    let is_any_without = AtomicBool::new(false);
    let place = |number: usize| {
        let part = ends.partition_point(|&end| end <= number);
        let first = if part == 0 { 0 } else { ends[part - 1] };
        let instance = &geometry.instances()[instances[part] as usize];
        let (mesh, opaque) = (instance.mesh as usize, blocking[instance.mesh as usize] == Blocking::Fully);
        let world_from_mesh = Some(&instance.world_from_mesh);
        let triangle =
            placed(&geometry.meshes()[mesh], number - first, world_from_mesh, instances[part], opaque);
        if !triangle.has_three_corners() {
            is_any_without.store(true, Relaxed);
        }
        triangle
    };
    // One place for each, so that threads write where the triangles stay; few scenes have any to leave out.
    let mut triangles: Vec<_> = (0..total).into_par_iter().map(place).collect();
    if is_any_without.into_inner() {
        triangles.retain(PlacedTriangle::has_three_corners);
    }
    triangles
}

/// The triangles of a mesh that have three corners; see [`placed`].
fn triangles_of(
    mesh: &TriangleMesh,
    world_from_mesh: Option<&Affine3A>,
    instance: u32,
    opaque: bool,
) -> Vec<PlacedTriangle> {
    (0..mesh.triangles().len())
        .into_par_iter()
        .map(|triangle| placed(mesh, triangle, world_from_mesh, instance, opaque))
        .filter(PlacedTriangle::has_three_corners)
        .collect()
}

/// A triangle of a mesh, in the world or, without a transform, in the mesh's space.
#[inline]
fn placed(
    mesh: &TriangleMesh,
    triangle: usize,
    world_from_mesh: Option<&Affine3A>,
    instance: u32,
    opaque: bool,
) -> PlacedTriangle {
    let corners = mesh.corners(triangle);
    let corners = world_from_mesh.map_or(corners, |m| corners.map(|p| world_corner(m, p)));
    PlacedTriangle { corners, id: TriangleId::new(instance, triangle as u32, opaque) }
}

fn check_counts(geometry: &Geometry) -> Result<(), BvhError> {
    let check = |what, count: u64, limit: u64| {
        if count > limit { Err(BvhError::TooMany { what, count, limit }) } else { Ok(()) }
    };
    // Each triangle might end up in a packet of its own.
    let limit = u64::from(Child::MAX_FIRST) - MAX_SINGULAR_TRIANGLES;
    check("instances", geometry.instances().len() as u64, limit)?;
    check(
        "triangles",
        geometry.stored_triangle_count() + FLAT_TRIANGLES * geometry.meshes().len() as u64,
        limit,
    )
}

/// All world corners must be finite.
fn check_overflow(geometry: &Geometry) -> Result<(), BvhError> {
    let bounds: Vec<Bounds> = geometry.meshes().par_iter().map(TriangleMesh::bounds).collect();
    for (i, instance) in geometry.instances().iter().enumerate() {
        let b = &bounds[instance.mesh as usize];
        if b.is_empty() {
            continue;
        }
        let (matrix, translation) = wide_matrix(&instance.world_from_mesh);
        let corner = b.min.as_dvec3().abs().max(b.max.as_dvec3().abs());
        let largest = abs_matrix(&matrix) * corner + translation.abs();
        if largest.max_element() < 0.25 * f64::from(f32::MAX) {
            continue;
        }
        let mesh = &geometry.meshes()[instance.mesh as usize];
        let finite =
            |v: &u32| world_corner(&instance.world_from_mesh, mesh.positions()[*v as usize]).is_finite();
        if !mesh.triangles().iter().flatten().all(finite) {
            return Err(BvhError::Overflow { instance: i, name: instance.name.clone() });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::Vec3;

    #[test]
    fn placements_scaled_to_nothing_cost_nothing() {
        let mut geometry = Geometry::default();
        let corners: Vec<Vec3> = (0..600).map(|i| Vec3::new(i as f32, (i * i % 7) as f32, 1.0)).collect();
        let triangles = (0..598).map(|i| [i, i + 1, i + 2]).collect();
        let mesh = geometry.add_mesh(TriangleMesh::new(corners, triangles).unwrap()).unwrap();
        let sheet = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
        for scale in [sheet].into_iter().chain([Affine3A::from_scale(Vec3::ZERO); 200]) {
            geometry.add_instance(mesh, scale).unwrap();
        }
        let blocking = [Blocking::Fully];
        let plan = Plan::new(&geometry, &blocking);
        let trees = [TriangleTree::build(&triangles_of(&geometry.meshes()[0], None, 0, true))];
        let (placed, singular) = place(&geometry, &plan, &[0], &trees, &blocking);
        // Of 201 placements the sheet's triangles alone are held.
        assert!(placed.is_empty());
        assert!(singular.iter().all(|t| t.id.instance == 0 && t.id.is_opaque()));
        assert!(!singular.is_empty() && singular.capacity() <= 2 * 598, "{}", singular.capacity());
        assert!(flattened(&geometry, &plan, &blocking).is_empty());
    }
}
