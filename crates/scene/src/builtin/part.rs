//! Indexed parts with normals: what loose faces become, and what meshes are made of.

use super::faces::{Faces, face_normal};
use conray_core::{Affine3A, GeometryError, TriangleMesh, Vec2, Vec3};
use std::collections::HashMap;

/// Triangles with shared vertices, unit normals and one UV set.
#[derive(Clone, Debug, Default)]
pub(crate) struct Part {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Edges sharper than this stay sharp where a part does not say otherwise.
pub(crate) const USUAL_CREASE_DEG: f32 = 38.0;

impl Faces {
    /// Shares vertices and gives them normals: a corner takes the mean of its neighbours' normals by their angles there,
    /// of those neighbours that lean from its own face by less than `crease_deg` (at most 80).
    ///
    /// The weights are those of Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998.
    pub(crate) fn smooth(&self, crease_deg: f32) -> Part {
        let least_cosine = crease_deg.min(80.0).to_radians().cos();
        let normals: Vec<Vec3> = self.triangles.iter().map(|t| face_normal(t.map(|c| c.position))).collect();
        let (point_of_corner, corners_of_point) = self.weld();
        let mut part = Part::default();
        let mut vertices: HashMap<(u32, [u32; 5]), u32> = HashMap::new();
        for (face, triangle) in self.triangles.iter().enumerate() {
            part.triangles.push([0, 1, 2].map(|k| {
                let point = point_of_corner[3 * face + k];
                let near = |&&(other, _): &&(u32, f32)| {
                    other as usize == face || normals[other as usize].dot(normals[face]) > least_cosine
                };
                let sum: Vec3 = corners_of_point[point as usize]
                    .iter()
                    .filter(near)
                    .map(|&(other, angle)| angle * normals[other as usize])
                    .sum();
                let normal = sum.try_normalize().unwrap_or(normals[face]);
                let uv = triangle[k].uv;
                let key = [normal.x, normal.y, normal.z, uv.x, uv.y].map(f32::to_bits);
                *vertices.entry((point, key)).or_insert_with(|| {
                    part.positions.push(triangle[k].position);
                    part.normals.push(normal);
                    part.uvs.push(uv);
                    part.positions.len() as u32 - 1
                })
            }));
        }
        part
    }

    /// The point of each corner, and for each point the faces that meet there with their angles.
    fn weld(&self) -> (Vec<u32>, Vec<Vec<(u32, f32)>>) {
        let mut ids: HashMap<[u32; 3], u32> = HashMap::new();
        let mut point_of_corner = Vec::with_capacity(3 * self.triangles.len());
        let mut corners_of_point: Vec<Vec<(u32, f32)>> = Vec::new();
        for (face, triangle) in self.triangles.iter().enumerate() {
            let p = triangle.map(|c| c.position);
            for k in 0..3 {
                let id = *ids.entry(position_key(p[k])).or_insert(corners_of_point.len() as u32);
                if id as usize == corners_of_point.len() {
                    corners_of_point.push(Vec::new());
                }
                let (to, from) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                corners_of_point[id as usize].push((face as u32, to.angle_between(from)));
                point_of_corner.push(id);
            }
        }
        (point_of_corner, corners_of_point)
    }

    /// Shares vertices and keeps every edge sharp.
    pub(crate) fn flat(&self) -> Part {
        // Half a degree: faces in one plane may share vertices despite rounding.
        self.smooth(0.5)
    }
}

/// Bits of a position, with both zeros alike.
pub(crate) fn position_key(p: Vec3) -> [u32; 3] {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

impl Part {
    /// Adds a copy of another part, moved by a transform that may turn, scale and mirror.
    pub(crate) fn place(&mut self, other: &Self, m: &Affine3A) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|&p| m.transform_point3(p)));
        let determinant = m.matrix3.determinant();
        // Normals go by the inverse transpose; the sign makes up for the turned winding of mirrored copies.
        let normal_matrix = m.matrix3.inverse().transpose();
        self.normals.extend(other.normals.iter().map(|&n| (normal_matrix * n).normalize()));
        self.uvs.extend_from_slice(&other.uvs);
        self.triangles.extend(other.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| v + first);
            if determinant < 0.0 { [a, c, b] } else { [a, b, c] }
        }));
    }

    /// Adds another part as it is.
    pub(crate) fn add(&mut self, other: &Self) {
        self.place(other, &Affine3A::IDENTITY);
    }

    /// The part as a mesh with one UV set.
    pub(crate) fn into_mesh(self, name: &str, material: u32) -> Result<TriangleMesh, GeometryError> {
        let mesh = TriangleMesh::new(self.positions, self.triangles)?;
        Ok(mesh.with_normals(self.normals)?.with_uv_set(self.uvs)?.with_material(material).with_name(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::shapes::cuboid;

    #[test]
    fn a_box_keeps_its_edges_below_the_crease_and_loses_them_above() {
        let cube = cuboid(Vec3::splat(-1.0), Vec3::ONE);
        assert_eq!(cube.flat().positions.len(), 24);
        let sharp = cube.smooth(80.0);
        assert!(sharp.normals.iter().all(|n| n.abs().max_element() == 1.0));
        let tent = Faces::sheet(2, 1, |u, v| Vec3::new(u, v, 0.1 - 0.2 * (u - 0.5).abs()));
        let ridge = |part: &Part| -> Vec<Vec3> {
            (0..part.positions.len())
                .filter(|&v| part.positions[v].x == 0.5)
                .map(|v| part.normals[v])
                .collect()
        };
        assert!(ridge(&tent.smooth(60.0)).iter().all(|n| n.distance(Vec3::Z) < 1e-6));
        assert_eq!(ridge(&tent.flat()).len(), 4, "two ends of the ridge, two faces each");
    }

    #[test]
    fn mirrored_and_stretched_copies_keep_normals_with_winding() {
        let ball = crate::builtin::shapes::icosphere(1);
        for scale in [Vec3::new(-1.0, 2.0, 0.5), Vec3::new(3.0, 0.2, 1.0), Vec3::splat(-2.0)] {
            let mut part = Part::default();
            part.place(&ball, &Affine3A::from_scale(scale));
            for t in &part.triangles {
                let n = face_normal(t.map(|v| part.positions[v as usize]));
                for v in t {
                    assert!(part.normals[*v as usize].dot(n) > 0.0);
                    assert!(n.dot(part.positions[*v as usize]) > 0.0, "outside stays outside");
                }
            }
        }
    }
}
