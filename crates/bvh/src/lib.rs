//! Two-level bounding volume hierarchy with robust ray queries.
mod binary;
mod blas;
mod build;
mod bvh;
mod hits;
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
mod wide;

pub use build::BvhError;
pub use bvh::{Bvh, BvhStats};
pub use query::Hit;
pub use surface::{position_error, triangle_point};
pub use validate::InvalidBvh;
