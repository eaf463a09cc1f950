//! The methods, one file each. Every method is a value with `estimate(&SurfacePoint) -> Estimate`.

mod cones;
mod paper;
mod point_rays;
mod rays;
#[cfg(test)]
mod tests;

pub(crate) use cones::Cones;
pub(crate) use paper::Paper;
pub(crate) use rays::Rays;
