//! Sparse voxel octree of opacities and the cone march.
