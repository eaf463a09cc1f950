//! Bounds on what a file may ask for, so that a small or hostile file cannot exhaust memory or time.

use super::error::Fault;

/// Bounds on what a scene file may ask for; exceeding one is an error that names it.
///
/// The defaults allow scenes of several hundred million triangles. Whatever the limits, a count that a file declares
/// is compared with the bytes that are there to back it before memory is set aside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one file, and of all buffers of a glTF together. Default 16 GiB.
    pub max_file_bytes: u64,
    /// Triangles stored, over all meshes; instances do not count. Default 400 million.
    pub max_triangles: u64,
    /// Vertices, normals or UVs stored, over all meshes. Default 1 200 million.
    pub max_vertices: u64,
    /// Texels of all opacity textures together, and of each image that must be decoded. Default 2^28 (16384 x 16384).
    pub max_texture_pixels: u64,
    /// Nodes of a glTF's scene. Default 4 million.
    pub max_nodes: u64,
    /// Levels of a glTF's node tree. Default 4096.
    pub max_node_depth: u64,
    /// Placements of meshes, over all nodes. Default 64 million.
    pub max_instances: u64,
    /// What a glTF's geometry may take in memory, in multiples of the bytes of its files, beyond the first 64 MiB.
    /// It stops small files whose primitives all copy the same data. Default 100.
    pub max_expansion: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_file_bytes: 16 << 30,
            max_triangles: 400_000_000,
            max_vertices: 1_200_000_000,
            max_texture_pixels: 1 << 28,
            max_nodes: 4_000_000,
            max_node_depth: 4096,
            max_instances: 64_000_000,
            max_expansion: 100,
        }
    }
}

impl Limits {
    /// Refuses more than `limit` of something.
    pub(super) fn check(what: &'static str, found: u64, limit: u64) -> Result<(), Fault> {
        if found <= limit { Ok(()) } else { Err(Fault::LimitExceeded { what, found, limit }) }
    }

    /// Vertices as far as 32-bit indices reach; the highest index means "none".
    pub(super) fn check_vertices(&self, found: usize) -> Result<(), Fault> {
        Self::check("vertices", found as u64, self.max_vertices.min(u64::from(u32::MAX) - 1))
    }

    /// Triangles as far as a mesh may hold them.
    pub(super) fn check_triangles(&self, found: usize) -> Result<(), Fault> {
        Self::check("triangles", found as u64, self.max_triangles.min(i32::MAX as u64))
    }
}
