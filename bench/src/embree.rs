//! Embree 4, loaded at run time: the rival of our ray kernels.
//!
//! Declarations after the documented C API ("Intel Embree API Reference", version 4). The library is never linked;
//! `bench/fetch-rivals` fetches it. Everything unsafe about it is in this module and those below it.
#![allow(unsafe_code, reason = "a C library is called")]

mod api;
mod device;
mod rays;
mod scene;

pub use device::Device;
pub use rays::{Packet, Ray1};
pub use scene::{Embree, Nearest, SceneFlags};

#[cfg(test)]
mod tests;
