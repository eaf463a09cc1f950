//! Sparse voxel octree of opacities, and the march of cones through it.
//!
//! ```text
//! Geometry --clusters--> bricks touched (marks) --voxelise--> leaves --upward--> levels   (Octree::build)
//! ConeQuery --march, filtered look-ups--> ConeResult                                       (Octree::march)
//! all cones of a point, sixteen side by side                                              (Octree::cone_march)
//! ```
//!
//! A **leaf** is a voxel of the finest grid; level `l` has nodes of `2^l` leaves a side and a node's eight children
//! are at level `l - 1`. Every node knows the **mean** and the **standard deviation** of the opacities of its leaves
//! and whether it is **empty**: no triangle touches it. Levels are stored as sparse sets of bricks of 8 x 8 x 8 nodes.
//!
//! After Podee, Dobashi, Yamamoto, "Combining Cone and Ray Tracing for Ambient Occlusion Computation"; Crassin,
//! Neyret, Sainz, Green, Eisemann, "Interactive Indirect Illumination Using Voxel Cone Tracing", 2011.

mod build;
mod cells;
mod clip;
mod clusters;
mod compose;
mod cone_set;
mod coverage;
mod error;
mod filter_bits;
mod grid;
mod level;
mod lookup;
mod march;
mod marks;
mod morton;
mod octree;
mod options;
mod packed;
mod plain;
mod region;
mod rows;
mod steps;
mod upward;
mod validate;
mod voxelise;

pub use cone_set::{ConeMarch, ConePoint, Level as SimdLevel};
pub use error::VoxelError;
pub use lookup::Sample;
pub use march::{ConeQuery, ConeResult, Density, MarchOptions};
pub use octree::Octree;
pub use options::{OctreeOptions, OctreeStats};
pub use packed::{PackedLevel, PackedOctree};
