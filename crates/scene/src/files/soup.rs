//! Triangles whose corners refer to positions, UVs and normals apart, as OBJ has them, and their split into meshes.

use super::error::Fault;
use conray_core::{TriangleMesh, Vec2, Vec3};
use std::collections::HashMap;

/// Stands for "no UV" or "no normal".
pub(super) const NONE: u32 = u32::MAX;

/// One corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    /// Index of its position.
    pub position: u32,
    /// Index of its UV, or [`NONE`].
    pub uv: u32,
    /// Index of its normal, or [`NONE`] until [`fill_normals`](super::normals::fill_normals) has run.
    pub normal: u32,
}

/// Triangles in file order; all indices are in range.
#[derive(Debug, Default)]
pub(super) struct Soup {
    /// Finite positions.
    pub positions: Vec<Vec3>,
    /// Finite UVs.
    pub uvs: Vec<Vec2>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Corners of the triangles.
    pub triangles: Vec<[Corner; 3]>,
}

/// A mesh to be made: its name, its material and which stretches of triangles it takes.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub name: String,
    pub material: u32,
    pub runs: Vec<std::ops::Range<usize>>,
}

impl Soup {
    /// How many positions no triangle uses, and the first of them.
    pub(super) fn unused_positions(&self) -> (u64, usize) {
        let mut used = vec![false; self.positions.len()];
        self.triangles.iter().flatten().for_each(|c| used[c.position as usize] = true);
        let count = used.iter().filter(|u| !**u).count() as u64;
        (count, used.iter().position(|u| !u).unwrap_or(0))
    }

    /// Makes one mesh; corners that agree in position, UV and normal become one vertex.
    pub(super) fn mesh(&self, part: Part) -> Result<TriangleMesh, Fault> {
        let corners = || part.runs.iter().flat_map(|run| &self.triangles[run.clone()]);
        let count = part.runs.iter().map(ExactSizeIterator::len).sum();
        let has_uvs = corners().flatten().any(|c| c.uv != NONE);
        let has_normals = corners().flatten().any(|c| c.normal != NONE);

        let mut vertex_of: HashMap<Corner, u32> = HashMap::with_capacity(count);
        let mut vertices: Vec<Corner> = Vec::with_capacity(count);
        let mut triangles = Vec::with_capacity(count);
        for triangle in corners() {
            triangles.push(triangle.map(|corner| {
                *vertex_of.entry(corner).or_insert_with(|| {
                    vertices.push(corner);
                    vertices.len() as u32 - 1
                })
            }));
        }
        drop(vertex_of);

        let positions = vertices.iter().map(|c| self.positions[c.position as usize]).collect();
        let mut mesh = TriangleMesh::new(positions, triangles).map_err(|e| Fault::file(e.to_string()))?;
        if has_normals {
            let normal = |c: &Corner| self.normals.get(c.normal as usize).copied().unwrap_or(Vec3::Z);
            mesh = mesh
                .with_normals(vertices.iter().map(normal).collect())
                .map_err(|e| Fault::file(e.to_string()))?;
        }
        if has_uvs {
            let uv = |c: &Corner| self.uvs.get(c.uv as usize).copied().unwrap_or_default();
            mesh = mesh
                .with_uv_set(vertices.iter().map(uv).collect())
                .map_err(|e| Fault::file(e.to_string()))?;
        }
        Ok(mesh.with_name(part.name).with_material(part.material))
    }
}
