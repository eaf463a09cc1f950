//! Meshes as trees of small groups of nearby triangles, made once per mesh and shared by its instances.
//!
//! The voxeliser asks "which triangles of this instance may touch that box" many times. Flattening instances would
//! take memory for every copy; these trees take 4 bytes a stored triangle.

use conray_core::{Bounds, Geometry, Opacity, TriangleMesh, Vec3};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;

/// Triangles a leaf of the tree, and children a node.
const LEAF: usize = 32;
const FAN_OUT: usize = 8;

/// The trees of a geometry's meshes.
pub(crate) struct Clusters {
    meshes: Vec<MeshClusters>,
}

/// Triangles of one mesh, sorted so that neighbours in the order are neighbours in space and alike in size.
pub(crate) struct MeshClusters {
    order: Vec<u32>,
    /// Bounds in mesh space: of each [`LEAF`] triangles, then of each [`FAN_OUT`] of the boxes before.
    boxes: Vec<Vec<Bounds>>,
}

impl Clusters {
    /// Trees for every mesh that an instance places and that can occlude.
    pub(crate) fn new(geometry: &Geometry) -> Self {
        let mut used = vec![false; geometry.meshes().len()];
        geometry.instances().iter().for_each(|i| used[i.mesh as usize] = true);
        let build = |(m, mesh): (usize, &TriangleMesh)| {
            let occludes = !matches!(geometry.opacity(m), Opacity::Constant(a) if *a <= 0.0);
            MeshClusters::new(mesh, used[m] && occludes)
        };
        Self { meshes: geometry.meshes().par_iter().enumerate().map(|(m, mesh)| build((m, mesh))).collect() }
    }

    /// The tree of a mesh.
    pub(crate) fn of_mesh(&self, mesh: u32) -> &MeshClusters {
        &self.meshes[mesh as usize]
    }

    /// Bytes held.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let bytes = |m: &MeshClusters| {
            let boxes: usize = m.boxes.iter().map(Vec::len).sum();
            m.order.len() * size_of::<u32>() + boxes * size_of::<Bounds>() + size_of::<MeshClusters>()
        };
        self.meshes.iter().map(|m| bytes(m) as u64).sum()
    }
}

impl MeshClusters {
    fn new(mesh: &TriangleMesh, occludes: bool) -> Self {
        if !occludes || mesh.triangles().is_empty() {
            return Self { order: Vec::new(), boxes: vec![Vec::new()] };
        }
        let order = sorted(mesh);
        let bounds_of =
            |triangles: &[u32]| Bounds::of_points(triangles.iter().flat_map(|&t| mesh.corners(t as usize)));
        let mut boxes: Vec<Vec<Bounds>> = vec![order.par_chunks(LEAF).map(bounds_of).collect()];
        while boxes[boxes.len() - 1].len() > FAN_OUT {
            let below = &boxes[boxes.len() - 1];
            let union = |b: &[Bounds]| b.iter().fold(Bounds::EMPTY, |all, &one| all.union(one));
            boxes.push(below.chunks(FAN_OUT).map(union).collect());
        }
        Self { order, boxes }
    }

    /// Groups of triangles, for work that visits all.
    pub(crate) fn groups(&self) -> impl IndexedParallelIterator<Item = &[u32]> {
        self.order.par_chunks(LEAF)
    }

    /// Bounds after a transform: those of the groups' transformed boxes together.
    pub(crate) fn transformed_bounds(&self, m: &DAffine3) -> (DVec3, DVec3) {
        let absolute = absolute_matrix(m);
        self.boxes[0].iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), b| {
            let (low, high) = transformed_box(b, m, &absolute);
            (min.min(low), max.max(high))
        })
    }

    /// Calls `visit` with each group whose transformed box overlaps the box from `low` to `high`.
    pub(crate) fn overlapping(&self, m: &DAffine3, low: DVec3, high: DVec3, visit: &mut impl FnMut(&[u32])) {
        let absolute = absolute_matrix(m);
        let top = self.boxes.len() - 1;
        let mut stack = vec![(top, 0, self.boxes[top].len())];
        while let Some((depth, start, end)) = stack.pop() {
            for k in start..end {
                let (min, max) = transformed_box(&self.boxes[depth][k], m, &absolute);
                if min.cmpgt(high).any() || max.cmplt(low).any() {
                    continue;
                }
                if depth == 0 {
                    visit(&self.order[k * LEAF..((k + 1) * LEAF).min(self.order.len())]);
                } else {
                    let below = self.boxes[depth - 1].len();
                    stack.push((depth - 1, k * FAN_OUT, ((k + 1) * FAN_OUT).min(below)));
                }
            }
        }
    }
}

fn absolute_matrix(m: &DAffine3) -> glam::DMat3 {
    glam::DMat3::from_cols(m.matrix3.x_axis.abs(), m.matrix3.y_axis.abs(), m.matrix3.z_axis.abs())
}

/// Bounds of a transformed box (Arvo, "Transforming Axis-Aligned Bounding Boxes", 1990).
fn transformed_box(b: &Bounds, m: &DAffine3, absolute: &glam::DMat3) -> (DVec3, DVec3) {
    let (min, max) = (b.min.as_dvec3(), b.max.as_dvec3());
    let centre = m.transform_point3(0.5 * (min + max));
    let half = *absolute * (0.5 * (max - min));
    (centre - half, centre + half)
}

/// Triangle indices by size, then along a Morton curve, so that a few large triangles do not blow up many groups.
fn sorted(mesh: &TriangleMesh) -> Vec<u32> {
    let bounds = mesh.bounds();
    // Doubles: differences of finite singles never overflow.
    let (low, size) = (bounds.min.as_dvec3(), bounds.max.as_dvec3() - bounds.min.as_dvec3());
    let extent = size.max_element().max(f64::MIN_POSITIVE);
    let key = |t: u32| {
        let b = Bounds::of_points(mesh.corners(t as usize));
        let share = (b.max.as_dvec3() - b.min.as_dvec3()).max_element() / extent;
        // Sizes in powers of four: 0 is the whole mesh.
        let class = (-0.5 * share.max(1e-9).log2()).clamp(0.0, 15.0) as u64;
        let middle = (0.5 * (b.min.as_dvec3() + b.max.as_dvec3()) - low) / extent;
        let place = crate::morton::encode((middle * 511.0).as_uvec3());
        class << 60 | u64::from(place) << 32 | u64::from(t)
    };
    let mut keys: Vec<u64> = (0..mesh.triangles().len() as u32).into_par_iter().map(key).collect();
    keys.par_sort_unstable();
    keys.into_par_iter().map(|key| key as u32).collect()
}

/// Bound on the error, in world units per axis, of placing a mesh's vertices in the world in single precision.
pub(crate) fn placement_error(mesh_bounds: &Bounds, world_from_mesh: &conray_core::Affine3A) -> f64 {
    if mesh_bounds.is_empty() {
        return 0.0;
    }
    let reach = mesh_bounds.min.abs().max(mesh_bounds.max.abs()).as_dvec3();
    let m = &world_from_mesh.matrix3;
    let columns = [Vec3::from(m.x_axis), Vec3::from(m.y_axis), Vec3::from(m.z_axis)];
    let moved: DVec3 = columns.iter().zip(reach.to_array()).map(|(c, r)| c.abs().as_dvec3() * r).sum();
    let most = (moved + Vec3::from(world_from_mesh.translation).abs().as_dvec3()).max_element();
    // Three products, three sums and the rounding of the result.
    f64::from(conray_core::gamma(7)) * most
}

impl MeshClusters {
    /// Bounds in mesh space; empty where nothing occludes.
    pub(crate) fn bounds(&self) -> Bounds {
        self.boxes[self.boxes.len() - 1].iter().fold(Bounds::EMPTY, |all, &one| all.union(one))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soup(count: u32) -> TriangleMesh {
        let h = |i: u32| conray_core::hash_u32(i) as f32 / u32::MAX as f32;
        let positions: Vec<Vec3> =
            (0..3 * count).map(|i| Vec3::new(h(6 * i), h(6 * i + 1), h(6 * i + 2))).collect();
        TriangleMesh::new(positions, (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect()).unwrap()
    }

    #[test]
    fn a_box_query_misses_no_triangle_that_overlaps_it() {
        let mesh = soup(5000);
        let clusters = MeshClusters::new(&mesh, true);
        let m = DAffine3::from_scale_rotation_translation(
            DVec3::new(3.0, -1.0, 2.0),
            glam::DQuat::from_rotation_y(0.7),
            DVec3::splat(5.0),
        );
        let (low, high) = (DVec3::new(5.2, 4.3, 4.5), DVec3::new(5.9, 4.6, 5.5));
        let mut found = vec![0; 5000];
        clusters.overlapping(&m, low, high, &mut |group| group.iter().for_each(|&t| found[t as usize] += 1));
        let mut overlapping = 0;
        for (t, &found) in found.iter().enumerate() {
            let c = mesh.corners(t).map(|c| m.transform_point3(c.as_dvec3()));
            let apart =
                c[0].min(c[1]).min(c[2]).cmpgt(high).any() || c[0].max(c[1]).max(c[2]).cmplt(low).any();
            assert!(found == 1 || (found == 0 && apart), "triangle {t}: {found}");
            overlapping += u32::from(!apart);
        }
        assert!(overlapping > 100);
        assert!(found.contains(&0), "the oracle must see groups left out");
        let (min, max) = clusters.transformed_bounds(&m);
        for c in mesh.positions() {
            let c = m.transform_point3(c.as_dvec3());
            assert!(c.cmpge(min - 1e-9).all() && c.cmple(max + 1e-9).all());
        }
    }

    #[test]
    fn meshes_that_cannot_occlude_have_no_triangles() {
        let mut geometry = Geometry::default();
        let glass = geometry
            .add_material(conray_core::Material { opacity: Opacity::Constant(0.0), ..Default::default() });
        let mesh = geometry.add_mesh(soup(10).with_material(glass)).unwrap();
        geometry.add_instance(mesh, conray_core::Affine3A::IDENTITY).unwrap();
        assert!(Clusters::new(&geometry).of_mesh(mesh).bounds().is_empty());
    }
}
