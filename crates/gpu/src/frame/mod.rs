//! Pictures made wholly on a device: what a camera sees, the first rays of method `hybrid`, what they come to, what is shown of it.
//!
//! ```text
//! see.wgsl -> places, points -> lattice.wgsl -> tallies -> weighing/ -> known -> resolve.wgsl -> picture, error
//! ```
//!
//! One submission a picture and nothing handed back but the error: for those who look while a camera moves. Below eight rays a pixel all rays of the method
//! are first rays, so up to there a picture is what [`conray_estimate::Hybrid`] makes of as many; how rays err is told instead of
//! found out, and the length in which places are told is that of the scene. Further rays go everywhere alike.
//!
//! What waits for the device is there twice: for a thread that may block, and as a future for a page, which may not.

mod passes;
mod read;
mod structs;

pub use read::FramePixel;

use crate::{
    GpuBackend, GpuError,
    backend::absent,
    kernel::{Bound, GROUP, Kernel, Steps},
    points::{AoUniform, GpuPoint},
    weighing::{Weighing, WeighingUniform},
};
use bytemuck::{Zeroable, bytes_of, cast_slice};
use conray_core::{Bounds, LANES, Vec3};
use conray_estimate::{AoPlan, HybridConstants, Method, RayErrors};
use passes::{Pass, UNIT};
use std::sync::Arc;
pub(crate) use structs::{CameraUniform, LatticeUniform, ShownUniform};

/// Pixels on each side of a workgroup that sees.
const SEEN: u32 = 8;

/// Where a pinhole camera stands: unit vectors to the right, up and into the picture, and the side of a pixel on the plane at unit depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameCamera {
    /// Where rays start.
    pub eye: Vec3,
    /// To the right in the picture.
    pub right: Vec3,
    /// Up in the picture.
    pub up: Vec3,
    /// Into the picture.
    pub forward: Vec3,
    /// Side of a pixel on the plane at unit depth.
    pub pixel_side: f32,
}

/// The kernels of pictures.
pub(crate) struct FrameKernels {
    see: Kernel,
    lattice: Kernel,
    resolve: Kernel,
}

/// A picture as it was made last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameFound {
    /// Expected root mean square error over the pixels that see something; 0 where none does.
    pub expected_rmse: f64,
    /// How many those are.
    pub points: u64,
    /// Rays traced for it so far, at most: of places that see nothing there are none.
    pub rays: u64,
}

/// Makes pictures of one size of one scene.
pub struct Frames {
    backend: Arc<GpuBackend>,
    plan: AoPlan,
    /// Width, height, and places from row to row.
    size: [u32; 3],
    /// The length in which places are told.
    unit: f32,
    /// The last rays, and those of all passes of the picture.
    last: Pass,
    rays: u64,
    /// Where the camera stood.
    eye: Vec3,
    weighing: Weighing,
    camera: wgpu::Buffer,
    lattice: wgpu::Buffer,
    shown: wgpu::Buffer,
    normals: wgpu::Buffer,
    points: wgpu::Buffer,
    picture: wgpu::Buffer,
    parts: wgpu::Buffer,
}

impl FrameKernels {
    pub(crate) fn new(
        gpu: &crate::Gpu,
        scene: &wgpu::BindGroupLayout,
        weighed: &wgpu::BindGroupLayout,
    ) -> Result<Self, GpuError> {
        use Bound::{Read, Uniform, Write};
        Ok(Self {
            see: Kernel::new(gpu, "see", scene, &[Uniform, Read, Write, Write, Write])?,
            lattice: Kernel::new(gpu, "lattice", scene, &[Uniform, Read, Read, Write])?,
            resolve: Kernel::new(gpu, "resolve", weighed, &[Uniform, Read, Write, Write])?,
        })
    }
}

impl GpuBackend {
    /// Pictures of that width and height, of a scene with those bounds.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] with the numbers, a scene that was not uploaded, a plan that is not built for devices, or a device that fails.
    pub fn frames(
        self: &Arc<Self>,
        plan: &AoPlan,
        bounds: Bounds,
        size: [u32; 2],
    ) -> Result<Frames, GpuError> {
        // Refuses what is not built.
        AoUniform::new(plan, 0..1, 0)?;
        let rays = self.rays.as_ref().ok_or_else(|| absent(Method::Hybrid))?;
        let (gpu, kernels) = (self.gpu(), self.weigh_kernels()?);
        self.frame_kernels()?;
        let [width, height] = size.map(|side| side.max(1));
        let size = [width, height, width.next_multiple_of(LANES as u32)];
        let uniform = WeighingUniform::of_size(&HybridConstants::default(), size);
        let weighing = Weighing::new(gpu, kernels, uniform)?;
        let count = (size[2] * height) as usize;
        let unit = plan.distance.min(0.25 * (bounds.max - bounds.min).length());
        let uniform = wgpu::BufferUsages::UNIFORM;
        let shown = ShownUniform { background: 0, width, pad_a: 0, pad_b: 0 };
        Ok(Frames {
            backend: Arc::clone(self),
            plan: plan.clone(),
            size,
            unit: if unit > 0.0 && unit.is_finite() { unit } else { 1.0 },
            last: Pass::first(0.0),
            rays: 0,
            eye: Vec3::ZERO,
            weighing,
            camera: gpu.buffer("camera", bytes_of(&CameraUniform::zeroed()), uniform)?,
            lattice: gpu.buffer("lattice", bytes_of(&LatticeUniform::zeroed()), uniform)?,
            shown: gpu.buffer("what is shown", bytes_of(&shown), uniform)?,
            normals: gpu.buffer("normals", cast_slice(&rays.scene.normals), wgpu::BufferUsages::STORAGE)?,
            points: gpu.answers::<GpuPoint>("points", count)?,
            picture: gpu.answers::<u32>("the picture", (width * height) as usize)?,
            parts: gpu.answers::<[f32; 2]>("parts of errors", count.div_ceil(GROUP as usize))?,
        })
    }
}

impl Frames {
    /// Makes a picture of about so many rays a pixel, 1/16 to 16, sixteen each at places spread evenly. `errors` tells how rays err: as
    /// [`conray_estimate::Hybrid::ray_errors`] found out in such a scene, or [`RayErrors::UNKNOWN`].
    ///
    /// # Errors
    /// A device that fails.
    pub fn render(
        &mut self,
        camera: &FrameCamera,
        rays_per_pixel: f32,
        errors: &RayErrors,
    ) -> Result<FrameFound, GpuError> {
        pollster::block_on(self.render_later(camera, rays_per_pixel, errors))
    }

    /// The same as a future.
    ///
    /// # Errors
    /// A device that fails.
    pub async fn render_later(
        &mut self,
        camera: &FrameCamera,
        rays_per_pixel: f32,
        errors: &RayErrors,
    ) -> Result<FrameFound, GpuError> {
        (self.last, self.rays, self.eye) = (Pass::first(rays_per_pixel), 0, camera.eye);
        self.pass(Some(camera), errors).await
    }

    /// Adds about so many rays a pixel to the picture that was made last, 1/16 to 16: every pixel has sixteen before another has more, and so on.
    ///
    /// # Errors
    /// A device that fails.
    pub fn refine(&mut self, rays_per_pixel: f32, errors: &RayErrors) -> Result<FrameFound, GpuError> {
        pollster::block_on(self.refine_later(rays_per_pixel, errors))
    }

    /// The same as a future.
    ///
    /// # Errors
    /// A device that fails.
    pub async fn refine_later(
        &mut self,
        rays_per_pixel: f32,
        errors: &RayErrors,
    ) -> Result<FrameFound, GpuError> {
        self.last = self.last.next(rays_per_pixel);
        self.pass(None, errors).await
    }

    /// Sees anew where a camera is given, traces the last pass, and weighs and shows all.
    async fn pass(
        &mut self,
        camera: Option<&FrameCamera>,
        errors: &RayErrors,
    ) -> Result<FrameFound, GpuError> {
        let (gpu, kernels) = (self.backend.gpu(), self.backend.frame_kernels()?);
        let scene = &self.backend.rays.as_ref().ok_or_else(|| absent(Method::Hybrid))?.scene;
        let [width, height, stride] = self.size;
        gpu.write(&self.lattice, &[LatticeUniform::new(&self.plan, self.size, &self.last)])?;
        self.weighing.set_rays(gpu, errors)?;
        let b = &self.weighing.buffers;
        let mut steps = Steps::new(gpu);
        if let Some(camera) = camera {
            gpu.write(&self.camera, &[CameraUniform::new(camera, self.size, self.unit)])?;
            let seen = [&self.camera, &self.normals, &b.places, &self.points, &b.tallies];
            let groups = stride / SEEN * height.div_ceil(SEEN);
            steps.add(&kernels.see, &scene.bindings, &seen, groups)?;
        }
        let units = self.last.units([width, height]);
        let asked = [&self.lattice, &b.places, &self.points, &b.tallies];
        steps.add(&kernels.lattice, &scene.bindings, &asked, units.div_ceil(GROUP / UNIT))?;
        self.weighing.add_to(&mut steps, self.backend.weigh_kernels()?)?;
        let (shown, parts) =
            ([&self.shown, &b.known, &self.picture, &self.parts], (stride * height).div_ceil(GROUP));
        steps.add(&kernels.resolve, &self.weighing.shared, &shown, parts)?;
        steps.finish()?;
        let parts: Vec<[f32; 2]> = gpu.read_later(&self.parts, parts as usize).await?;
        let sum = |k: usize| parts.iter().map(|part| f64::from(part[k])).sum::<f64>();
        let points = sum(1);
        self.rays += u64::from(units) * u64::from(UNIT);
        let expected_rmse = (sum(0) / points.max(1.0)).sqrt();
        Ok(FrameFound { expected_rmse, points: points as u64, rays: self.rays })
    }
}
