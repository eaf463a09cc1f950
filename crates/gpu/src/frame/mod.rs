//! Pictures made wholly on a device: what a camera sees, the first rays of method `hybrid`, what they come to, what is shown of it.
//!
//! ```text
//! see.wgsl -> places, points -> lattice.wgsl -> tallies -> weighing/ -> known -> resolve.wgsl -> picture, error
//! ```
//!
//! One submission a picture and nothing handed back but the error: for those who look while a camera moves. Below eight rays a pixel all rays of the method
//! are first rays, so up to there a picture is what [`conray_estimate::Hybrid`] makes of as many; how rays err is told instead of
//! found out, and the length in which places are told is that of the scene.

mod structs;

use crate::{
    GpuBackend, GpuError,
    backend::absent,
    kernel::{Bound, GROUP, Kernel, Steps},
    points::{AoUniform, GpuPoint},
    weighing::{GpuPlace, Weigher, WeighingUniform},
};
use bytemuck::{Zeroable, bytes_of, cast_slice};
use conray_core::{Bounds, LANES, Vec3};
use conray_estimate::{AoPlan, HybridConstants, Method, RayErrors};
pub(crate) use structs::{CameraUniform, LatticeUniform, ShownUniform};

/// Pixels on each side of a block of the lattice, and of a workgroup that sees.
const BLOCK: u32 = 16;
const SEEN: u32 = 8;
/// Rays of a unit.
const UNIT: u32 = 16;
/// Places of a block.
const RANKS: u32 = BLOCK * BLOCK;

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
    /// Rays traced from them, at most.
    pub rays: u64,
}

/// Makes pictures of one size of one scene.
pub struct Frames<'a> {
    backend: &'a GpuBackend,
    kernels: &'a FrameKernels,
    plan: AoPlan,
    /// Width, height, and places from row to row.
    size: [u32; 3],
    /// The length in which places are told.
    unit: f32,
    weigher: Weigher<'a>,
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

/// Ranks of a block below which a lattice of so many rays a pixel has rays.
fn ranks(rays_per_pixel: f32) -> u32 {
    let part = (rays_per_pixel / UNIT as f32).max(1.0 / RANKS as f32);
    (0..RANKS).filter(|&rank| (rank as f32 + 0.5) / (RANKS as f32) < part).count() as u32
}

impl GpuBackend {
    /// Pictures of that width and height, of a scene with those bounds.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] with the numbers, a scene that was not uploaded, a plan that is not built for devices, or a device that fails.
    pub fn frames(&self, plan: &AoPlan, bounds: Bounds, size: [u32; 2]) -> Result<Frames<'_>, GpuError> {
        // Refuses what is not built.
        AoUniform::new(plan, 0..1, 0)?;
        let rays = self.rays.as_ref().ok_or_else(|| absent(Method::Hybrid))?;
        let (gpu, weighing) = (self.gpu(), self.weigh_kernels()?);
        let kernels = self.frame_kernels(&rays.scene.layout, &weighing.shared)?;
        let [width, height] = size.map(|side| side.max(1));
        let size = [width, height, width.next_multiple_of(LANES as u32)];
        let uniform = WeighingUniform::of_size(&HybridConstants::default(), size);
        let weigher = Weigher::empty(gpu, weighing, uniform)?;
        let count = (size[2] * height) as usize;
        let unit = plan.distance.min(0.25 * (bounds.max - bounds.min).length());
        let uniform = wgpu::BufferUsages::UNIFORM;
        let shown = ShownUniform { background: 0, width, pad_a: 0, pad_b: 0 };
        Ok(Frames {
            backend: self,
            kernels,
            plan: plan.clone(),
            size,
            unit: if unit > 0.0 && unit.is_finite() { unit } else { 1.0 },
            weigher,
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

impl Frames<'_> {
    /// Makes a picture of about so many rays a pixel, 1/16 to 16, sixteen each at places spread evenly. `errors` tells how rays err: as
    /// [`conray_estimate::Hybrid::ray_errors`] found out in such a scene, or [`RayErrors::UNKNOWN`].
    ///
    /// # Errors
    /// A device that fails.
    pub fn render(
        &self,
        camera: &FrameCamera,
        rays_per_pixel: f32,
        errors: &RayErrors,
    ) -> Result<FrameFound, GpuError> {
        let gpu = self.backend.gpu();
        let scene = &self.backend.rays.as_ref().ok_or_else(|| absent(Method::Hybrid))?.scene;
        let [width, height, stride] = self.size;
        let ranks = ranks(rays_per_pixel);
        gpu.write(&self.camera, &[CameraUniform::new(camera, self.size, self.unit)])?;
        gpu.write(&self.lattice, &[LatticeUniform::new(&self.plan, self.size, ranks)])?;
        self.weigher.set_rays(errors)?;
        let b = &self.weigher.buffers;
        let mut steps = Steps::new(gpu);
        let seen = [&self.camera, &self.normals, &b.places, &self.points, &b.tallies];
        steps.add(&self.kernels.see, &scene.bindings, &seen, stride / SEEN * height.div_ceil(SEEN))?;
        let units = width.div_ceil(BLOCK) * height.div_ceil(BLOCK) * ranks;
        let asked = [&self.lattice, &b.places, &self.points, &b.tallies];
        steps.add(&self.kernels.lattice, &scene.bindings, &asked, units.div_ceil(GROUP / UNIT))?;
        self.weigher.add_to(&mut steps)?;
        let shown = [&self.shown, &b.known, &self.picture, &self.parts];
        steps.add(&self.kernels.resolve, &self.weigher.shared, &shown, (stride * height).div_ceil(GROUP))?;
        steps.finish()?;
        let parts: Vec<[f32; 2]> = gpu.read(&self.parts, (stride * height).div_ceil(GROUP) as usize)?;
        let sum = |k: usize| parts.iter().map(|part| f64::from(part[k])).sum::<f64>();
        let points = sum(1);
        Ok(FrameFound {
            expected_rmse: (sum(0) / points.max(1.0)).sqrt(),
            points: points as u64,
            rays: u64::from(units * UNIT),
        })
    }

    /// The picture, row by row: visibility as grey of eight bits a channel, the first of them lowest; 0 where nothing is seen.
    ///
    /// # Errors
    /// A device that fails.
    pub fn picture(&self) -> Result<Vec<u32>, GpuError> {
        let [width, height, _] = self.size;
        self.backend.gpu().read(&self.picture, (width * height) as usize)
    }

    /// Visibility and expected error of each pixel, row by row; none where nothing is seen.
    ///
    /// # Errors
    /// A device that fails.
    pub fn known(&self) -> Result<Vec<Option<[f32; 2]>>, GpuError> {
        let [width, height, stride] = self.size;
        let count = (stride * height) as usize;
        let known: Vec<[f32; 4]> = self.backend.gpu().read(&self.weigher.buffers.known, count)?;
        let places: Vec<GpuPlace> = self.backend.gpu().read(&self.weigher.buffers.places, count)?;
        let pixel = |k: u32| {
            let at = (k / width * stride + k % width) as usize;
            (places[at].sharpness > 0.0).then(|| [known[at][0], known[at][1].sqrt()])
        };
        Ok((0..width * height).map(pixel).collect())
    }

    /// What is seen of each pixel, row by row: position and shading normal; none where that is nothing.
    ///
    /// # Errors
    /// A device that fails.
    pub fn seen(&self, eye: Vec3) -> Result<Vec<Option<[Vec3; 2]>>, GpuError> {
        let [width, height, stride] = self.size;
        let count = (stride * height) as usize;
        let places: Vec<GpuPlace> = self.backend.gpu().read(&self.weigher.buffers.places, count)?;
        let pixel = |k: u32| {
            let place = &places[(k / width * stride + k % width) as usize];
            (place.sharpness > 0.0).then(|| [eye + self.unit * place.position, place.normal])
        };
        Ok((0..width * height).map(pixel).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn so_many_places_of_a_block_have_rays() {
        assert_eq!([0.0, 1.0 / 16.0, 1.0, 4.0, 16.0].map(ranks), [1, 1, 16, 64, 256]);
    }
}
