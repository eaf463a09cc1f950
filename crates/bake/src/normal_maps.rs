//! Normals that normal maps give to surfaces.

use crate::{extent::world_corners, frames::Frames};
use conray_core::{Geometry, NormalMap, SurfacePoint, Vec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// A normal that leans below the surface is lifted until it rises by so much.
const LEAST_RISE: f32 = 1e-2;

/// The normal maps of what is baked, each with the tangent frames of the mesh that reads it.
#[derive(Clone, Debug, Default)]
pub struct NormalMaps {
    of_mesh: BTreeMap<u32, Mapped>,
}

#[derive(Clone, Debug)]
struct Mapped {
    map: NormalMap,
    frames: Frames,
}

impl NormalMaps {
    /// Those of the materials of instances, where these have some and the mesh has the UVs to read them.
    pub fn of(geometry: &Geometry, instances: &[u32]) -> Self {
        let mesh_of = |&instance: &u32| geometry.instances()[instance as usize].mesh;
        let meshes: BTreeSet<u32> = instances.iter().map(mesh_of).collect();
        let mapped = |index: u32| {
            let mesh = &geometry.meshes()[index as usize];
            let map = geometry.materials().get(mesh.material as usize)?.normal_map.clone()?;
            mesh.uv_sets().get(map.uv_set)?;
            let uvs = |triangle| {
                mesh.corner_uvs(triangle, map.uv_set).map(|uv| map.texture_from_uv.transform_point2(uv))
            };
            let frames = Frames::given(mesh)
                .unwrap_or_else(|| Frames::of(mesh, (0..mesh.triangles().len()).map(uvs).collect()));
            Some((index, Mapped { map, frames }))
        };
        let of_mesh: Vec<(u32, Mapped)> = meshes.into_par_iter().filter_map(mapped).collect();
        Self { of_mesh: of_mesh.into_iter().collect() }
    }

    /// True where no surface has one.
    pub fn is_empty(&self) -> bool {
        self.of_mesh.is_empty()
    }

    /// Bytes of the tangent frames; the textures are the scene's.
    pub fn memory_bytes(&self) -> u64 {
        self.of_mesh.values().map(|mapped| mapped.frames.memory_bytes()).sum()
    }

    /// The unit normal at a point of the front of a triangle, at weights of its second and third corner, in the mean over a square with sides of `spread` in
    /// world units; that of the shading where there is no normal map. It rises at least a little from the surface.
    pub(crate) fn normal(
        &self,
        geometry: &Geometry,
        [instance, triangle]: [u32; 2],
        [u, v]: [f32; 2],
        point: &SurfacePoint,
        spread: f32,
    ) -> Vec3 {
        let placed = &geometry.instances()[instance as usize];
        let Some(Mapped { map, frames }) = self.of_mesh.get(&placed.mesh) else {
            return point.shading_normal;
        };
        let world_from_mesh = &placed.world_from_mesh;
        let basis = frames.basis(triangle, [u, v], world_from_mesh, point.shading_normal);
        let Some([tangent, bitangent, normal]) = basis else { return point.shading_normal };
        let mesh = geometry.mesh_of(instance as usize);
        let uvs = mesh.corner_uvs(triangle as usize, map.uv_set);
        let [a, b, c] = world_corners(geometry, instance, triangle as usize);
        let area = 0.5 * (b - a).cross(c - a).length();
        let texels = spread * (map.texels(uvs) / area).sqrt();
        let [x, y, z] = map.at((1.0 - u - v) * uvs[0] + u * uvs[1] + v * uvs[2], texels).to_array();
        let mapped = x * tangent + y * bitangent + z * normal;
        let rise = mapped.dot(point.geometric_normal);
        let lift = (LEAST_RISE - rise).max(0.0);
        (mapped + lift * point.geometric_normal).normalize_or(point.shading_normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{Affine2, Affine3A, Material, NormalTexture, TriangleMesh, Vec2, Wrap};
    use std::sync::Arc;

    /// A triangle in z = 0 with a normal map of one colour.
    fn geometry(texel: [u8; 3], uv_set: usize) -> Geometry {
        let texture = Arc::new(NormalTexture::new(1, 1, vec![texel]).unwrap());
        let texture_from_uv = Affine2::IDENTITY;
        let map = NormalMap { texture, uv_set, texture_from_uv, wrap: [Wrap::Repeat; 2], scale: 1.0 };
        let mut geometry = Geometry::default();
        geometry.add_material(Material { normal_map: Some(map), ..Material::default() });
        let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap();
        let mesh = mesh.with_uv_set(vec![Vec2::Y, Vec2::ONE, Vec2::ZERO]).unwrap();
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        geometry
    }

    fn normal(texel: [u8; 3], uv_set: usize) -> Vec3 {
        let geometry = geometry(texel, uv_set);
        let maps = NormalMaps::of(&geometry, &[0]);
        assert_eq!(maps.is_empty(), uv_set > 0);
        let point = SurfacePoint::new(Vec3::new(0.2, 0.2, 0.0), Vec3::Z);
        maps.normal(&geometry, [0, 0], [0.2, 0.2], &point, 0.1)
    }

    #[test]
    fn normals_lean_as_the_map_says() {
        let leaning = normal([218, 128, 218], 0);
        assert!((leaning - Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt())).length() < 0.01, "{leaning}");
        let up = normal([128, 218, 218], 0);
        assert!((up - Vec3::new(0.0, 0.5f32.sqrt(), 0.5f32.sqrt())).length() < 0.01, "{up}");
        assert_eq!(normal([218, 128, 218], 1), Vec3::Z, "there is no such UV set");
    }

    #[test]
    fn normals_never_lean_below_the_surface() {
        let below = normal([255, 128, 0], 0);
        assert!(below.z > 0.0 && below.z < 0.1 && (below.length() - 1.0).abs() < 1e-5, "{below}");
    }
}
