//! The methods on a graphics processor, by wgpu: any adapter of Vulkan, Metal or DirectX 12.
//!
//! ```text
//! adapters() / Gpu::open -> Gpu            device.rs: device, queue, limits, what went wrong
//! Geometry -> GpuScene                     scene/: world triangles under compressed wide nodes, opacities
//! points, plan -> GpuBackend -> estimates  backend.rs, points.rs; shaders/: entry points flat, shared/ what they include
//! ```
//!
//! Method `rays` is there; others are told to be missing ([`GpuError::Method`]). Samples are those of the CPU, bit for bit up to the direction, so results
//! differ by rounding alone.

mod backend;
mod device;
mod error;
mod layouts;
mod points;
mod scene;
mod shader;

pub use backend::GpuBackend;
pub use device::{AdapterFacts, Gpu, adapters};
pub use error::GpuError;
pub use layouts::{StructLayout, layouts};
pub use scene::{GpuScene, SceneBytes};
pub use shader::{SHADERS, source};
