//! What occludes, as shaders read it: twins of shaders/shared/scene.wgsl.

mod materials;
mod trees;
mod triangles;

use crate::{
    Gpu, GpuError,
    kernel::{Bound, shared_bindings},
};
use bytemuck::cast_slice;
use conray_core::{Geometry, Vec3};
pub(crate) use materials::GpuMaterial;
use materials::Materials;
pub(crate) use trees::GpuPlacement;
use trees::Trees;
pub(crate) use triangles::GpuTriangle;

/// A scene on a device.
pub(crate) struct GpuScene {
    pub(crate) bindings: wgpu::BindGroup,
    pub(crate) layout: wgpu::BindGroupLayout,
    /// Three vertex normals for each triangle, for those who look at the scene.
    pub(crate) normals: Vec<[Vec3; 3]>,
}

impl GpuScene {
    /// Builds the trees on the CPU and uploads them: meshes that are shown several times are held once.
    ///
    /// # Errors
    /// What is too large for the adapter, with the numbers, or a device that fails.
    pub(crate) fn new(gpu: &Gpu, geometry: &Geometry) -> Result<Self, GpuError> {
        // Told before any work.
        let count = geometry.stored_triangle_count();
        gpu.check_size("triangles", count.saturating_mul(size_of::<GpuTriangle>() as u64))?;
        let materials = Materials::new(geometry);
        let trees = Trees::new(geometry, &materials);
        let storage = wgpu::BufferUsages::STORAGE;
        let buffers = [
            gpu.buffer("nodes", cast_slice(&trees.nodes), storage)?,
            gpu.buffer("triangles", cast_slice(&trees.triangles.list), storage)?,
            gpu.buffer("opacities", cast_slice(&materials.words(&trees.triangles.uvs)), storage)?,
            gpu.buffer("placements", cast_slice(&trees.placements), storage)?,
        ];
        let (layout, bindings) = shared_bindings(gpu, "scene", &buffers.each_ref().map(|b| (Bound::Read, b)));
        gpu.check()?;
        Ok(Self { bindings, layout, normals: trees.triangles.normals })
    }
}
