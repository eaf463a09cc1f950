//! The methods, one file each. Every method is a value with `estimate(&SurfacePoint) -> Estimate`.

mod above_surface;
mod cones;
mod paper;
mod point_rays;
mod quarters;
mod rays;
mod squares;
#[cfg(test)]
mod tests;

pub(crate) use cones::{Cones, Marches};
pub(crate) use paper::{Paper, cone_share, ray_count};
pub(crate) use rays::Rays;
