//! What a caller may say about an octree, and what the octree says of itself.

use crate::VoxelError;

/// How an octree is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OctreeOptions {
    /// Leaves along the longest side of the octree's cube: a power of two from 16 to 2048. Default 512.
    pub resolution: u32,
    /// Most bytes that the build may hold at its peak, without the geometry; the resolution is halved until it does.
    /// `None`, the default, is no limit.
    pub max_memory_bytes: Option<u64>,
    /// Also keeps an opacity for each of the three axes at every node: 3 bytes a node. Default false.
    ///
    /// Crassin, Neyret, Sainz, Green, Eisemann, "Interactive Indirect Illumination Using Voxel Cone Tracing", 2011,
    /// section 6.3; one value per axis here, since occlusion is the same from both sides.
    pub directional: bool,
}

impl Default for OctreeOptions {
    fn default() -> Self {
        Self { resolution: 512, max_memory_bytes: None, directional: false }
    }
}

impl OctreeOptions {
    /// Coarsest resolution.
    pub const MIN_RESOLUTION: u32 = 16;
    /// Finest resolution.
    pub const MAX_RESOLUTION: u32 = 2048;

    /// Refuses resolutions outside the limits.
    pub(crate) fn validate(&self) -> Result<(), VoxelError> {
        let valid = self.resolution.is_power_of_two()
            && (Self::MIN_RESOLUTION..=Self::MAX_RESOLUTION).contains(&self.resolution);
        if valid { Ok(()) } else { Err(VoxelError::Resolution(self.resolution)) }
    }
}

/// Facts about a built octree.
#[derive(Clone, Debug, PartialEq)]
pub struct OctreeStats {
    /// Leaves along a side of the cube; less than asked for where memory was limited.
    pub resolution: u32,
    /// Edge of a leaf in world units.
    pub voxel_size: f32,
    /// Nodes that a triangle touches, by level; level 0 holds the leaves.
    pub occupied: Vec<u64>,
    /// Bricks of 512 nodes, by level.
    pub bricks: Vec<u64>,
    /// Bytes that the octree holds.
    pub memory_bytes: u64,
    /// Bytes held at the peak of the build, by the same count as [`crate::Octree::estimate_memory`].
    pub peak_bytes: u64,
}
