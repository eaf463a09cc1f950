//! Two-level bounding volume hierarchy with robust ray queries.
//!
//! [`Bvh::build`] takes a [`Geometry`](conray_core::Geometry); [`Bvh::nearest`] finds what a camera sees,
//! [`Bvh::transmittance`] what of the light along a ray gets through, [`Bvh::visibility`] the same with a falloff, and
//! [`Bvh::surface_point`] makes a surface point of a hit; [`Bvh::transmittances`] answers for up to 64 rays of one origin at
//! once, and many times faster. All surfaces count from both sides. Hits lie at
//! `0 < t < t_max`, in world units for the unit directions that [`Ray`](conray_core::Ray) asks for, in scaled, sheared
//! and mirrored instances too.
//!
//! ```
//! use conray_bvh::Bvh;
//! use conray_core::{Affine3A, Geometry, Ray, TriangleMesh, Vec3};
//! use std::sync::Arc;
//!
//! let mut geometry = Geometry::default();
//! let triangle = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]])?;
//! let mesh = geometry.add_mesh(triangle)?;
//! geometry.add_instance(mesh, Affine3A::from_translation(Vec3::Z))?;
//! let bvh = Bvh::build(Arc::new(geometry))?;
//! let ray = Ray { origin: Vec3::new(0.2, 0.2, 0.0), direction: Vec3::Z, t_max: f32::INFINITY };
//! assert_eq!(bvh.nearest(&ray).map(|hit| hit.t), Some(1.0));
//! assert_eq!(bvh.transmittance(&ray), 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is exact and what is bounded
//!
//! There is no epsilon to choose. The chain of rounding errors is cut into links, each bounded by itself:
//!
//! 1. **Geometry.** The scene *is* its world-space corners as single precision rounds them, by one formula in every part
//!    of the crate (`placement.rs`). A transform's rounding is therefore part of the scene, not an error of a query;
//!    instances answer to the bit as their flattened copies do.
//! 2. **Boxes** are tested conservatively: `gamma(3)` on slab distances (Ize, "Robust BVH Ray Traversal", 2013), and for
//!    rays taken into a mesh's space a slack per axis that covers the way there and the corners' rounding (`mesh_space.rs`).
//!    Only boxes are tested there. A placement that cannot be undone is flattened, or searched without a tree.
//! 3. **Triangles** are tested watertight (Woop, Benthin, Wald, 2013); an edge belongs to exactly one of the two
//!    triangles that share it; distances come in double precision from unrounded differences (`triangle.rs`). A hit
//!    counts from `t` above the error bound of that computation, some 1e-14 of the triangle's size.
//! 4. **Surface points** carry a [`position_error`] that covers what single precision edge functions and rounded normals
//!    can do (`surface.rs`). Rays from [`SurfacePoint::ray_origin`](conray_core::SurfacePoint::ray_origin) into
//!    directions with `d . n >= 0` never meet their own triangle, and see every wall that is further away than the
//!    offset itself: about 1e-6 of the triangle's size.
//!
//! Not covered: surface points whose `position_error` was made without knowing the triangle, as
//! [`SurfacePoint::new`](conray_core::SurfacePoint::new) must, on triangles that are far larger than their distance from
//! the origin, seen at grazing angles next to an edge; use [`position_error`] where the triangle is known. And meshes
//! whose corners round to a bumpy surface *are* bumpy: neighbours may shade each other at angles of some ulps.
//!
//! # Determinism
//!
//! The tree is the same for any number of threads. Answers do not even depend on the tree: of equal distances the lowest
//! instance and triangle wins, and fractional opacities are multiplied in the order of their distances.
//!
//! # Where to find what
//!
//! `build.rs` decides what is flattened; `binary.rs`, `refine.rs`, `collapse.rs` and `wide.rs` make trees; `lanes.rs`, `node.rs`
//! and `packet.rs` are the memory layout; `traverse.rs` walks it for single rays, `triangle.rs` tests triangles, `hits.rs` is
//! what queries do with hits. `bundle.rs` and the folder beside it trace up to 64 rays of one origin together. Everything
//! that loops over lanes is generic over the level of SIMD, which is chosen once per hierarchy.

mod binary;
mod blas;
mod build;
mod bundle;
mod bvh;
mod collapse;
mod hits;
mod lanes;
mod mesh_space;
mod node;
mod packet;
mod placement;
mod query;
mod ray;
mod refine;
mod surface;
mod top;
mod traverse;
mod triangle;
mod validate;
mod visits;
mod wide;

pub use build::BvhError;
pub use bundle::{BUNDLE_RAYS, Directions, Level};
pub use bvh::{Bvh, BvhStats};
pub use query::Hit;
pub use surface::{position_error, triangle_point};
pub use validate::InvalidBvh;
pub use visits::Visit;
#[cfg(feature = "visits")]
pub use visits::take_visits;
