//! Targets: where surface points come from and where estimates go.
//!
//! A [`Target`] offers a slice of surface points and, given one estimate for each in the same order, resolves them:
//!
//! - [`CameraTarget`] asks for what a [`Camera`] sees and resolves to image [`Layers`], written by [`write_png`]
//!   (visibility alone) or [`write_exr`] (all layers and the settings);
//! - [`PointsTarget`] asks for the vertices of a PLY file and writes the same file with their visibility added.
//!
//! The crate traces nothing itself: primary hits come in through a closure. Every file is written to a temporary name
//! and renamed ([`write_atomically`]), so that a failure loses no earlier file. [`compare`] says how far two images are
//! apart. Visibility is linear everywhere, 1 is open.
//!
//! ```
//! use conray_core::{Estimate, SurfacePoint, Vec3, View};
//! use conray_target::{Camera, CameraTarget, PngDepth, Target, write_png};
//!
//! let (eye, look_at, up) = (Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y);
//! let view = View { name: "front".into(), eye, look_at, up, vertical_fov_deg: 40.0 };
//! // A plane through the origin stands in for a scene.
//! let target = CameraTarget::trace(Camera::new(&view, 64, 48)?, |ray| {
//!     let t = -ray.origin.z / ray.direction.z;
//!     Some(SurfacePoint::new(ray.origin + t * ray.direction, Vec3::Z))
//! });
//! let open = Estimate { visibility: 1.0, error: 0.0, rays: 0, bent: Vec3::Z, cone: None };
//! let layers = target.resolve(&vec![open; target.points().len()])?;
//! let folder = tempfile::tempdir()?;
//! write_png(folder.path().join("ao.png"), &layers, PngDepth::Eight)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod atlas;
mod atomic;
mod camera;
mod camera_target;
mod error;
mod exr;
mod fill;
mod input;
mod layers;
mod metrics;
mod ply;
mod png;
mod target;

pub use atlas::{
    Atlas, AtlasMap, AtlasTarget, Corner, MapSize, Part, Portion, Seam, SeamReport, SeamSide, Surface, Texel,
    UvUse, fill, level, seams,
};
pub use atomic::{check_writable, write_atomically};
pub use camera::{Camera, MAX_PIXELS, MAX_SIDE_PX};
pub use camera_target::CameraTarget;
pub use error::{Fault, TargetError};
pub use exr::{ExrImage, decode_exr_channels, encode_exr, read_exr_channels, write_exr};
pub use layers::{Channel, Layers};
pub use metrics::{Metrics, compare};
pub use ply::{MAX_POINTS, PlyError, PointValues, PointsTarget, Skipped};
pub use png::{GreyImage, PngDepth, encode_colour_png, encode_png, read_png, write_png};
pub use target::Target;
