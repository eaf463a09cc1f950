//! The methods on a graphics processor, by wgpu: any adapter of Vulkan, Metal or DirectX 12.
//!
//! ```text
//! adapters() / Gpu::open -> Gpu            device.rs: device, queue, limits, what went wrong
//! Geometry -> GpuScene                     scene/: triangles under compressed wide nodes, opacities
//! Octree -> octree.rs                      bricks of opacities and where they are
//! points, plan -> GpuBackend -> estimates  backend.rs, rays.rs, bundles.rs, cones.rs; kernel.rs: one entry point and runs of it
//! places, tallies -> what is known         weighing/: what rays of neighbours tell, for method `hybrid`
//! camera, plan -> Frames -> pictures       frame/: all of it on the device, for those who look while a camera moves
//! ```
//!
//! Shaders are in `shaders/`: entry points flat, what they include in `shared/`. Of method `hybrid` the rays are traced and weighed here, and
//! the CPU chooses who gets the next ones. Samples and steps are those of the CPU, so results differ by rounding alone.

mod backend;
mod bundles;
mod clock;
mod cone_rays;
mod cones;
mod device;
mod error;
mod frame;
mod kernel;
mod layouts;
mod octree;
mod points;
mod rays;
mod scene;
mod shader;
mod weighing;

pub use backend::GpuBackend;
pub use clock::KernelTime;
pub use device::{AdapterFacts, Gpu, adapters};
pub use error::GpuError;
pub use frame::{FrameCamera, FrameFound, FramePixel, Frames};
pub use layouts::{StructLayout, layouts};
pub use shader::{entry_points, source};
