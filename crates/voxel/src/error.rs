//! Why an octree could not be built.

use thiserror::Error;

/// Why an octree could not be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum VoxelError {
    /// A resolution that is no power of two or outside the limits.
    #[error("a resolution of {0} voxels is not a power of two from 16 to 2048")]
    Resolution(u32),
    /// No triangle that could occlude, or all of them in one point: there is nothing to voxelise.
    #[error("the geometry has no extent")]
    NoExtent,
    /// Coordinates for which single precision cannot hold the octree's cube.
    #[error("the geometry is too large: {0:e} units along its longest side")]
    TooLarge(f64),
    /// Even the coarsest octree does not fit the limit.
    #[error("an octree of {resolution} voxels needs {needed} bytes, more than the limit of {limit}")]
    MemoryLimit {
        /// The coarsest resolution that was tried.
        resolution: u32,
        /// Bytes that it needs at the peak of its build.
        needed: u64,
        /// The limit that was set.
        limit: u64,
    },
}
