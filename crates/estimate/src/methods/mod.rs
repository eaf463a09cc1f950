//! The methods, one file each. Every method is a value with a function `estimate` from a point to its estimate; those with
//! cones are given what [`Marches`] found for the points of a chunk.

mod above_surface;
mod cones;
mod paper;
mod point_rays;
mod quarters;
mod rays;
mod squares;
#[cfg(test)]
mod tests;

pub use cones::ConeAnswers;
pub(crate) use cones::{Cones, Marches};
pub use paper::BlendAnswers;
pub(crate) use paper::{Paper, cone_share, ray_count};
pub(crate) use point_rays::PointRays;
pub use point_rays::Tally as RayTally;
pub(crate) use rays::Rays;
pub(crate) use squares::Squares;
