//! What occludes: triangle meshes, their placements in the world and the opacity of their materials.

use crate::{Affine3A, Backs, Bounds, NormalMap, Opacity, Vec2, Vec3, Vec4};
use thiserror::Error;

/// Why an array of positions and indices is no mesh.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GeometryError {
    /// An index points past the end.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are {vertices} vertices")]
    VertexOutOfRange {
        /// Which triangle, from 0.
        triangle: usize,
        /// What it refers to.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite: {position}")]
    NotFinite {
        /// Which vertex, from 0.
        vertex: usize,
        /// Its position.
        position: Vec3,
    },
    /// A per-vertex array has another length than the positions.
    #[error("{what} has {found} entries for {vertices} vertices")]
    LengthMismatch {
        /// Which array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// A mesh, material or UV set that does not exist.
    #[error("{what} {index} does not exist: there are {count}")]
    UnknownIndex {
        /// Kind of thing.
        what: &'static str,
        /// Its index, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A placement with NaN or infinite members.
    #[error("the transform of instance {0} is not finite")]
    TransformNotFinite(usize),
    /// More triangles or meshes than 32-bit indices reach.
    #[error("{what}: {count} are more than the limit of {limit}")]
    TooMany {
        /// Kind of thing.
        what: &'static str,
        /// How many.
        count: usize,
        /// The limit.
        limit: usize,
    },
}

/// Triangles with one material, in coordinates of their own.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    /// For messages and patterns; may be empty.
    pub name: String,
    /// Vertex positions, all finite.
    positions: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside; all in range.
    triangles: Vec<[u32; 3]>,
    /// Unit vertex normals, one per vertex, or none: then the surface is flat.
    normals: Vec<Vec3>,
    /// For each vertex a unit tangent and the sign of the bitangent, or none.
    tangents: Vec<Vec4>,
    /// UV sets, each with one entry per vertex.
    uv_sets: Vec<Vec<Vec2>>,
    /// Index into [`Geometry::materials`].
    pub material: u32,
}

impl TriangleMesh {
    /// A mesh from plain arrays; every index and coordinate is checked.
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, GeometryError> {
        let vertices = positions.len();
        if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
            return Err(GeometryError::NotFinite { vertex, position: positions[vertex] });
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(GeometryError::VertexOutOfRange { triangle, vertex, vertices });
            }
        }
        let limit = i32::MAX as usize;
        if triangles.len() > limit {
            return Err(GeometryError::TooMany { what: "triangles", count: triangles.len(), limit });
        }
        Ok(Self { positions, triangles, ..Self::default() })
    }

    /// Adds unit normals, one per vertex.
    pub fn with_normals(mut self, normals: Vec<Vec3>) -> Result<Self, GeometryError> {
        self.check_length("normals", normals.len())?;
        self.normals = normals;
        Ok(self)
    }

    /// Adds tangents of normal maps, one per vertex: unit vectors, and in `w` the sign of the bitangent, which is that times normal x tangent.
    pub fn with_tangents(mut self, tangents: Vec<Vec4>) -> Result<Self, GeometryError> {
        self.check_length("tangents", tangents.len())?;
        self.tangents = tangents;
        Ok(self)
    }

    /// Adds a UV set, one entry per vertex; sets are numbered in the order of adding.
    pub fn with_uv_set(mut self, uvs: Vec<Vec2>) -> Result<Self, GeometryError> {
        self.check_length("UV set", uvs.len())?;
        self.uv_sets.push(uvs);
        Ok(self)
    }

    /// The same mesh with another material.
    pub fn with_material(self, material: u32) -> Self {
        Self { material, ..self }
    }

    /// The same mesh under another name.
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    fn check_length(&self, what: &'static str, found: usize) -> Result<(), GeometryError> {
        let vertices = self.positions.len();
        if found == vertices { Ok(()) } else { Err(GeometryError::LengthMismatch { what, found, vertices }) }
    }

    /// Vertex positions.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Vertex indices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Unit vertex normals; empty where the mesh is flat-shaded.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Tangents of normal maps, as [`TriangleMesh::with_tangents`] takes them; empty where there are none.
    pub fn tangents(&self) -> &[Vec4] {
        &self.tangents
    }

    /// UV sets.
    pub fn uv_sets(&self) -> &[Vec<Vec2>] {
        &self.uv_sets
    }

    /// Corners of one triangle, in mesh space.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// UVs of one triangle's corners; zero where the set does not exist.
    #[inline]
    pub fn corner_uvs(&self, triangle: usize, uv_set: usize) -> [Vec2; 3] {
        match self.uv_sets.get(uv_set) {
            Some(set) => self.triangles[triangle].map(|v| set[v as usize]),
            None => [Vec2::ZERO; 3],
        }
    }

    /// Bounds in mesh space of all vertices that a triangle uses.
    pub fn bounds(&self) -> Bounds {
        Bounds::of_points(self.triangles.iter().flatten().map(|&v| self.positions[v as usize]))
    }
}

/// What a surface is made of, as far as ambient occlusion cares.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// How much the surface blocks.
    pub opacity: Opacity,
    /// Whether the file calls the surface visible from both sides. Occlusion counts both sides always.
    pub double_sided: bool,
    /// How a texture bends the normals, where that is known; occlusion by the surface does not depend on it.
    pub normal_map: Option<NormalMap>,
}

/// One placement of a mesh in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// For messages and patterns; may be empty.
    pub name: String,
    /// Index into [`Geometry::meshes`].
    pub mesh: u32,
    /// From mesh coordinates to world coordinates.
    pub world_from_mesh: Affine3A,
}

/// All that occludes.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    pub(crate) meshes: Vec<TriangleMesh>,
    pub(crate) instances: Vec<Instance>,
    pub(crate) materials: Vec<Material>,
    /// Meshes that occlude nothing, in ascending order.
    pub(crate) hidden: Vec<u32>,
    /// Which surfaces rays pass from behind.
    pub(crate) backs: Backs,
}

impl Geometry {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Adds a mesh and returns its index; it occludes only where an instance places it.
    ///
    /// Add materials first. A mesh with material 0 is accepted while there are no materials: it is opaque.
    pub fn add_mesh(&mut self, mesh: TriangleMesh) -> Result<u32, GeometryError> {
        let (index, count) = (mesh.material as usize, self.materials.len());
        if index >= count && !(index == 0 && count == 0) {
            return Err(GeometryError::UnknownIndex { what: "material", index, count });
        }
        self.meshes.push(mesh);
        Ok(self.meshes.len() as u32 - 1)
    }

    /// Places a mesh in the world and returns the instance's index.
    pub fn add_instance(&mut self, mesh: u32, world_from_mesh: Affine3A) -> Result<u32, GeometryError> {
        self.add_named_instance(mesh, world_from_mesh, String::new())
    }

    /// Places a mesh in the world under a name.
    pub fn add_named_instance(
        &mut self,
        mesh: u32,
        world_from_mesh: Affine3A,
        name: String,
    ) -> Result<u32, GeometryError> {
        let (index, count) = (mesh as usize, self.meshes.len());
        if index >= count {
            return Err(GeometryError::UnknownIndex { what: "mesh", index, count });
        }
        if !world_from_mesh.is_finite() {
            return Err(GeometryError::TransformNotFinite(self.instances.len()));
        }
        self.instances.push(Instance { name, mesh, world_from_mesh });
        Ok(self.instances.len() as u32 - 1)
    }

    /// The meshes.
    pub fn meshes(&self) -> &[TriangleMesh] {
        &self.meshes
    }

    /// The placements.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The materials; may be empty, then all is opaque.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The mesh that an instance places.
    pub fn mesh_of(&self, instance: usize) -> &TriangleMesh {
        &self.meshes[self.instances[instance].mesh as usize]
    }

    /// Opacity of a mesh's material.
    pub fn opacity(&self, mesh: usize) -> &Opacity {
        const OPAQUE: &Opacity = &Opacity::Constant(1.0);
        const NOTHING: &Opacity = &Opacity::Constant(0.0);
        if self.is_hidden(mesh) {
            return NOTHING;
        }
        self.materials.get(self.meshes[mesh].material as usize).map_or(OPAQUE, |m| &m.opacity)
    }

    /// Opacity in [0, 1] at a point of a triangle with barycentric weights `u` of corner 1 and `v` of corner 2.
    pub fn opacity_at(&self, mesh: usize, triangle: usize, u: f32, v: f32) -> f32 {
        match self.opacity(mesh) {
            Opacity::Constant(opacity) => *opacity,
            Opacity::Texture(texture) => {
                let [a, b, c] = self.meshes[mesh].corner_uvs(triangle, texture.uv_set);
                texture.at(a * (1.0 - u - v) + b * u + c * v)
            }
        }
    }

    /// Treats every surface as opaque (`--alpha opaque`).
    pub fn make_opaque(&mut self) {
        for material in &mut self.materials {
            material.opacity = Opacity::Constant(1.0);
        }
    }

    /// Triangles over all instances.
    pub fn triangle_count(&self) -> u64 {
        self.instances.iter().map(|i| self.meshes[i.mesh as usize].triangles.len() as u64).sum()
    }

    /// Triangles stored, each mesh counted once.
    pub fn stored_triangle_count(&self) -> u64 {
        self.meshes.iter().map(|m| m.triangles.len() as u64).sum()
    }

    /// World bounds of all instances: exact for those of few vertices, else of the mesh's transformed box.
    pub fn bounds(&self) -> Bounds {
        let mesh_bounds: Vec<Bounds> = self.meshes.iter().map(TriangleMesh::bounds).collect();
        let mut uses = vec![0u32; self.meshes.len()];
        self.instances.iter().for_each(|i| uses[i.mesh as usize] += 1);
        self.instances.iter().fold(Bounds::EMPTY, |bounds, i| {
            let (m, mesh) = (i.mesh as usize, &self.meshes[i.mesh as usize]);
            bounds.union(if uses[m] == 1 {
                let world = |&v: &u32| i.world_from_mesh.transform_point3(mesh.positions[v as usize]);
                Bounds::of_points(mesh.triangles.iter().flatten().map(world))
            } else {
                mesh_bounds[m].transformed(&i.world_from_mesh)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> TriangleMesh {
        TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap()
    }

    #[test]
    fn bad_arrays_are_refused_by_name() {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let out = TriangleMesh::new(corners.clone(), vec![[0, 1, 3]]).unwrap_err();
        assert_eq!(out, GeometryError::VertexOutOfRange { triangle: 0, vertex: 3, vertices: 3 });
        let nan = TriangleMesh::new(vec![Vec3::NAN], vec![]).unwrap_err();
        assert!(matches!(nan, GeometryError::NotFinite { vertex: 0, .. }));
        assert!(triangle().with_normals(vec![Vec3::Z]).is_err());
        let mut geometry = Geometry::default();
        assert!(geometry.add_mesh(triangle().with_material(1)).is_err());
        assert!(geometry.add_instance(0, Affine3A::IDENTITY).is_err());
        let mesh = geometry.add_mesh(triangle()).unwrap();
        assert!(geometry.add_instance(mesh, Affine3A::from_translation(Vec3::NAN)).is_err());
    }

    #[test]
    fn bounds_follow_the_instances() {
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(triangle()).unwrap();
        geometry.add_instance(mesh, Affine3A::from_translation(Vec3::splat(2.0))).unwrap();
        assert_eq!(geometry.bounds(), Bounds { min: Vec3::splat(2.0), max: Vec3::new(3.0, 3.0, 2.0) });
        geometry.add_instance(mesh, Affine3A::from_scale(Vec3::splat(-1.0))).unwrap();
        assert_eq!(geometry.bounds().min, Vec3::new(-1.0, -1.0, 0.0));
        assert_eq!((geometry.triangle_count(), geometry.stored_triangle_count()), (2, 1));
    }
}
