//! Ambient occlusion by combining voxel cone tracing with ray tracing.
//!
//! A [`Session`] holds what was built for one scene - a BVH for rays and, where the method marches cones, an octree -
//! and answers any number of questions: surface points in, [`Estimate`]s out. No files are needed:
//!
//! ```
//! use conray::{AoSettings, Geometry, Method, Session, SurfacePoint, TriangleMesh, Affine3A, Vec3};
//!
//! // A ceiling, 20 units wide, half a unit above the point asked about.
//! let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)].map(|(x, y)| Vec3::new(x, y, 0.5));
//! let mut geometry = Geometry::default();
//! let ceiling = geometry.add_mesh(TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?)?;
//! geometry.add_instance(ceiling, Affine3A::IDENTITY)?;
//!
//! let settings = AoSettings { method: Method::Rays, distance: 1.0.into(), rays: Some(1024), ..Default::default() };
//! let session = Session::build(geometry, &settings)?;
//! let estimates = session.estimate(&[SurfacePoint::new(Vec3::ZERO, Vec3::Z)])?;
//!
//! // Rays that reach the ceiling within the distance of 1 lean less than 60 degrees: (h / D)^2 stays open.
//! assert!((estimates[0].visibility - 0.25).abs() < 0.01);
//! # Ok::<(), conray::Error>(())
//! ```
//!
//! The same mesh may be placed often ([`Geometry::add_instance`] with other transforms) and is stored once.
//! Long work is followed and stopped through [`Session::run`]. Files, cameras and images are beside it:
//! [`scene::load`] and [`scene::builtin`] give a [`scene::Scene`]; [`target`] has the camera image and point clouds.
//!
//! The same settings and seed give the same bits, whatever the number of threads. There is no global state.

mod device;
mod error;
mod events;
mod looking;
mod passes;
mod refinement;
mod session;
mod shared;
mod state;
mod threads;
mod together;
mod words;
mod work;

pub use conray_bvh::{Bvh, Hit};
pub use conray_core::{
    Affine2, Affine3A, AlphaTexture, Backs, Bounds, ConeEstimate, ConeSet, Estimate, Falloff, Geometry,
    GeometryError, Instance, Layout, Material, Moments, Opacity, Ray, SurfacePoint, TextureOpacity,
    TriangleMesh, Vec2, Vec3, View, Wrap,
};
pub use conray_estimate::{
    AUTO_DISTANCE_SHARE, Alpha, AoPlan, AoSettings, Backend, BackendError, Budget, Choice, ConeView,
    ConeViews, Control, CpuBackend, Distance, Ended, Epsilon, Explanation, HARDLY_SEEN, Hybrid,
    HybridConstants, Level, Method, PROGRESS_UNITS, RayErrors, Round, Sampling, SettingsError, StateError,
    limits, merge,
};
pub use conray_scene as scene;
pub use conray_target as target;
pub use conray_voxel::{Octree, VoxelError};

#[cfg(feature = "gpu")]
pub use conray_gpu as gpu;
pub use device::Device;
pub use error::Error;
pub use events::{Event, Observer, Stage};
pub use looking::RayView;
pub use refinement::Refinement;
pub use session::{BuildReport, Session, SessionOptions};
pub use words::{changed_settings, settings_text};
pub use work::{Outcome, Work};
