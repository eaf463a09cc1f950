//! The triangles of all placements, in the world.

use super::materials::{Materials, NONE};
use bytemuck::{Pod, Zeroable};
use conray_core::{Affine3A, Geometry, Mat3A, Opacity, Vec2, Vec3};
use obvhs::triangle::Triangle;

/// Rays pass it from behind.
const ONE_SIDED: u32 = 1;
/// Its front is where the corners go round clockwise.
const TURNED: u32 = 2;

/// A triangle in the world.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuTriangle {
    pub(crate) a: Vec3,
    pub(crate) material: u32,
    pub(crate) b: Vec3,
    pub(crate) uvs: u32,
    pub(crate) c: Vec3,
    pub(crate) flags: u32,
}

impl GpuTriangle {
    /// For the builder of the tree.
    pub(super) fn corners(&self) -> Triangle {
        Triangle { v0: self.a.into(), v1: self.b.into(), v2: self.c.into() }
    }
}

/// Triangles that occlude, and the UVs of those whose opacity is a texture.
#[derive(Default)]
pub(super) struct Triangles {
    pub(super) list: Vec<GpuTriangle>,
    /// Three for each such triangle.
    pub(super) uvs: Vec<Vec2>,
    /// Three vertex normals for each triangle, in the coordinates of its corners and of any length; 0 where its mesh has none.
    pub(super) normals: Vec<[Vec3; 3]>,
}

impl Triangles {
    /// Adds those of a mesh, in the world or in its own coordinates.
    pub(super) fn add(
        &mut self,
        geometry: &Geometry,
        mesh_index: usize,
        materials: &Materials,
        world_from_mesh: Option<&Affine3A>,
    ) {
        let (mesh, opacity) = (&geometry.meshes()[mesh_index], geometry.opacity(mesh_index));
        // Also of hidden meshes.
        if matches!(opacity, Opacity::Constant(opacity) if *opacity <= 0.0) {
            return;
        }
        let material = if opacity.is_opaque() { NONE } else { materials.place(mesh.material) };
        let uv_set = Materials::uv_set(geometry, mesh_index);
        let one_sided = if geometry.is_one_sided(mesh_index) { ONE_SIDED } else { 0 };
        let turn = world_from_mesh.map_or(Mat3A::IDENTITY, |affine| cofactors(affine.matrix3));
        let mirrored = world_from_mesh.is_some_and(|affine| affine.matrix3.determinant() < 0.0);
        for triangle in 0..mesh.triangles().len() {
            let place = |p| world_from_mesh.map_or(p, |affine| affine.transform_point3(p));
            let [a, b, c] = mesh.corners(triangle).map(place);
            let turned = if is_turned(mesh, triangle) != mirrored { TURNED } else { 0 };
            let uvs = uv_set.map_or(0, |uv_set| {
                let first = self.uvs.len() as u32;
                self.uvs.extend(mesh.corner_uvs(triangle, uv_set));
                first
            });
            let normals = mesh.triangles()[triangle].map(|v| mesh.normals().get(v as usize));
            self.normals.push(normals.map(|normal| turn * *normal.unwrap_or(&Vec3::ZERO)));
            self.list.push(GpuTriangle { a, material, b, uvs, c, flags: one_sided | turned });
        }
    }

    /// Adds others behind these.
    pub(super) fn append(&mut self, other: Self) {
        let first = self.uvs.len() as u32;
        self.list.extend(
            other.list.into_iter().map(|triangle| GpuTriangle { uvs: triangle.uvs + first, ..triangle }),
        );
        self.uvs.extend(other.uvs);
        self.normals.extend(other.normals);
    }

    /// In the order in which the leaves name them.
    pub(super) fn reorder(&mut self, order: &[u32]) {
        self.list = order.iter().map(|&index| self.list[index as usize]).collect();
        self.normals = order.iter().map(|&index| self.normals[index as usize]).collect();
    }
}

/// What turns normals, but for their length: the inverse transpose, where there is one.
fn cofactors(m: Mat3A) -> Mat3A {
    let turned = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
    let largest = turned.iter().map(|axis| axis.abs().max_element()).fold(f32::MIN_POSITIVE, f32::max);
    Mat3A::from_cols(turned[0], turned[1], turned[2]) * (1.0 / largest)
}

/// True where vertex normals point to the side from which the corners go round clockwise.
fn is_turned(mesh: &conray_core::TriangleMesh, triangle: usize) -> bool {
    let [a, b, c] = mesh.corners(triangle);
    let corners = mesh.triangles()[triangle];
    let sum: Vec3 = corners.iter().filter_map(|&v| mesh.normals().get(v as usize)).sum();
    sum.dot((b - a).cross(c - a)) < 0.0
}
