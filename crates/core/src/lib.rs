//! The vocabulary of conray: geometry and its opacity, surface points, hemisphere cells, sampling, moments, estimates.
//!
//! No input or output and no threads: everything here is a value or a function of values. World space is right-handed,
//! lengths are in the units of the scene, angles in radians unless the name says `deg`.
//!
//! The one polarity of the code base is **visibility**: 1 is open, 0 is closed.

mod bounds;
mod estimate;
mod falloff;
mod fingerprint;
mod frame;
mod geometry;
mod hemisphere;
mod lanes;
mod layout;
mod moments;
mod normal_map;
mod opacity;
mod passing;
mod point_sets;
mod rounding;
mod sobol;
mod surface;
mod view;
mod warp;
mod wrap;

pub use bounds::Bounds;
pub use estimate::{ConeEstimate, Estimate};
pub use falloff::Falloff;
pub use fingerprint::{Feed, Fingerprint};
pub use frame::Frame;
pub use geometry::{Geometry, GeometryError, Instance, Material, TriangleMesh};
pub use glam::{Affine2, Affine3A, Mat3A, Mat4, Quat, Vec2, Vec3, Vec3A, Vec4};
pub use hemisphere::{Cone, ConeSet, HemisphereCones};
pub use lanes::{LANES, cosine_cone_lanes, cosine_hemisphere_lanes, owen_sobol_2d_lanes, simd_levels};
pub use layout::Layout;
pub use moments::Moments;
pub use normal_map::{NormalMap, NormalTexture};
pub use opacity::{AlphaTexture, Opacity, TextureOpacity};
pub use passing::Backs;
pub use point_sets::{JitteredPoints, RandomPoints};
pub use rounding::gamma;
pub use sobol::{hash_u32, owen_sobol_2d};
pub use surface::{Ray, SurfacePoint};
pub use view::View;
pub use warp::{concentric_disc, cosine_hemisphere, cosine_hemisphere_pdf, square_from_disc, uniform_cone};
pub use wrap::Wrap;
