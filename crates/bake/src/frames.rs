//! Tangent frames: which way the axes of a texture run along a surface.
//!
//! By MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008), which glTF asks for where a file tells no tangents (glTF 2.0
//! Specification, section 3.7.2.1), so that directions in tangent space mean the same in every program.

use bevy_mikktspace::{Geometry as Mikk, TangentSpace, generate_tangents};
use conray_core::{Affine3A, TriangleMesh, Vec2, Vec3, Vec4};

/// For each triangle the tangents of its corners, in mesh space: along u, and in `w` the sign of the bitangent, which runs up in the picture and is
/// that times normal x tangent. Of no length where the UVs do not tell.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    corners: Vec<[Vec4; 3]>,
}

impl Frames {
    /// Those that the mesh's vertices have, where they have some.
    pub(crate) fn given(mesh: &TriangleMesh) -> Option<Self> {
        let tangents = Some(mesh.tangents()).filter(|tangents| !tangents.is_empty())?;
        let corners = mesh.triangles().iter().map(|t| t.map(|v| tangents[v as usize])).collect();
        Some(Self { corners })
    }

    /// Those of texture coordinates of each triangle's corners, rows from the top.
    pub(crate) fn of(mesh: &TriangleMesh, uvs: Vec<[Vec2; 3]>) -> Self {
        let corners = vec![[Vec4::ZERO; 3]; mesh.triangles().len()];
        let mut work = Surface { mesh, uvs, corners };
        // It fails where there is nothing to be told: no triangle, or only ones without area.
        _ = generate_tangents(&mut work);
        Self { corners: work.corners }
    }

    /// Bytes that they take.
    pub(crate) fn memory_bytes(&self) -> u64 {
        size_of_val(&self.corners[..]) as u64
    }

    /// Tangent, bitangent and normal in the world, at right angles, at a place of a triangle with weights of its second and third corner, where the unit normal is
    /// that. `None` where the UVs do not tell.
    pub(crate) fn basis(
        &self,
        triangle: u32,
        [u, v]: [f32; 2],
        world_from_mesh: &Affine3A,
        normal: Vec3,
    ) -> Option<[Vec3; 3]> {
        let [a, b, c] = self.corners[triangle as usize];
        let mean = (1.0 - u - v) * a + u * b + v * c;
        let along = world_from_mesh.transform_vector3(mean.truncate());
        let tangent = along.reject_from_normalized(normal).try_normalize()?;
        // A mirrored placement mirrors the picture too.
        let mirrored = if world_from_mesh.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        let sign = if a.w < 0.0 { -mirrored } else { mirrored };
        Some([tangent, sign * normal.cross(tangent), normal])
    }
}

struct Surface<'a> {
    mesh: &'a TriangleMesh,
    uvs: Vec<[Vec2; 3]>,
    corners: Vec<[Vec4; 3]>,
}

impl Mikk for Surface<'_> {
    fn num_faces(&self) -> usize {
        self.uvs.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.corners(face)[corner].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let vertex = self.mesh.triangles()[face][corner];
        let flat = || {
            let [a, b, c] = self.mesh.corners(face);
            (b - a).cross(c - a).normalize_or_zero()
        };
        self.mesh.normals().get(vertex as usize).copied().unwrap_or_else(flat).to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // The bitangent runs up in the picture.
        let uv = self.uvs[face][corner];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, corner: usize) {
        self.corners[face][corner] = found.map_or(Vec4::ZERO, |found| Vec4::from(found.tangent_encoded()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square in z = 0, facing +z, whose picture stands upright or is mirrored.
    fn square(mirrored: bool) -> (TriangleMesh, Vec<[Vec2; 3]>) {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let positions = corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let uv = |[x, y]: [f32; 2]| Vec2::new(if mirrored { 1.0 - x } else { x }, 1.0 - y);
        let uvs = triangles.iter().map(|t: &[u32; 3]| t.map(|v| uv(corners[v as usize]))).collect();
        (TriangleMesh::new(positions, triangles).unwrap(), uvs)
    }

    fn near(found: Option<[Vec3; 3]>, expected: [Vec3; 3]) {
        let found = found.unwrap();
        assert!((0..3).all(|k| (found[k] - expected[k]).length() < 1e-5), "{found:?} {expected:?}");
    }

    #[test]
    fn axes_run_right_and_up_in_the_picture() {
        for (mirrored, right) in [(false, Vec3::X), (true, Vec3::NEG_X)] {
            let (mesh, uvs) = square(mirrored);
            let frames = Frames::of(&mesh, uvs);
            for triangle in 0..2 {
                let at = frames.basis(triangle, [0.2, 0.3], &Affine3A::IDENTITY, Vec3::Z);
                near(at, [right, Vec3::Y, Vec3::Z]);
            }
        }
    }

    #[test]
    fn placements_turn_and_mirror_them() {
        let (mesh, uvs) = square(false);
        let frames = Frames::of(&mesh, uvs);
        let turned = Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        near(frames.basis(0, [0.0, 0.0], &turned, Vec3::Y), [Vec3::X, Vec3::NEG_Z, Vec3::Y]);
        let mirror = Affine3A::from_scale(Vec3::new(-2.0, 2.0, 2.0));
        near(frames.basis(0, [0.0, 0.0], &mirror, Vec3::Z), [Vec3::NEG_X, Vec3::Y, Vec3::Z]);
        // Smooth normals lean; the axes lean with them.
        let normal = Vec3::new(0.6, 0.0, 0.8);
        let leaning = [Vec3::new(0.8, 0.0, -0.6), Vec3::Y, normal];
        near(frames.basis(1, [0.5, 0.5], &Affine3A::IDENTITY, normal), leaning);
    }

    #[test]
    fn tangents_of_the_file_count_and_nonsense_gives_none() {
        let (mesh, uvs) = square(false);
        assert!(Frames::given(&mesh).is_none());
        let mesh = mesh.with_tangents(vec![Vec4::new(0.0, 1.0, 0.0, -1.0); 4]).unwrap();
        let given = Frames::given(&mesh).unwrap();
        near(given.basis(0, [0.0, 0.0], &Affine3A::IDENTITY, Vec3::Z), [Vec3::Y, Vec3::X, Vec3::Z]);
        assert_eq!(given.memory_bytes(), 96);
        let flat = Frames::of(&mesh, vec![[Vec2::ZERO; 3]; uvs.len()]);
        for triangle in 0..2 {
            let basis = flat.basis(triangle, [0.2, 0.2], &Affine3A::IDENTITY, Vec3::Z);
            assert!(basis.is_none_or(|basis| basis.iter().all(|axis| axis.is_finite())));
        }
        let empty = TriangleMesh::new(vec![], vec![]).unwrap();
        assert_eq!(Frames::of(&empty, vec![]).memory_bytes(), 0);
    }
}
