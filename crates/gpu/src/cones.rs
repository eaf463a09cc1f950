//! The march of cones on a device.

use crate::{
    Gpu, GpuError,
    kernel::{Bound, GROUP, Kernel, shared_bindings},
    octree::GpuOctree,
    points::GpuPoint,
};
use bytemuck::{bytes_of, cast_slice};
use conray_core::SurfacePoint;
use conray_estimate::AoPlan;
use conray_voxel::{ConeResult, Octree};

/// Marches cones.
pub(crate) struct Cones {
    octree: GpuOctree,
    bindings: wgpu::BindGroup,
    kernel: Kernel,
}

impl Cones {
    pub(crate) fn new(gpu: &Gpu, octree: &Octree) -> Result<Self, GpuError> {
        let octree = GpuOctree::new(gpu, octree)?;
        let [levels, table, words] = &octree.buffers;
        let (layout, bindings) =
            shared_bindings(gpu, "octree", &[levels, table, words].map(|b| (Bound::Read, b)));
        let asked = [Bound::Uniform, Bound::Read, Bound::Read, Bound::Write];
        let kernel = Kernel::new(gpu, "cones", &layout, &asked)?;
        Ok(Self { octree, bindings, kernel })
    }

    /// What the cones of points found, those of one point after those of the other.
    pub(crate) async fn march(
        &self,
        gpu: &Gpu,
        plan: &AoPlan,
        points: &[SurfacePoint],
    ) -> Result<Vec<ConeResult>, GpuError> {
        let cones = plan.cones.cones();
        let packed: Vec<GpuPoint> = points.iter().map(GpuPoint::of_cones).collect();
        let axes: Vec<[f32; 4]> = cones.iter().map(|cone| cone.axis.extend(0.0).to_array()).collect();
        let count = points.len() * cones.len();
        let storage = wgpu::BufferUsages::STORAGE;
        let asked = gpu.buffer("points", cast_slice(&packed), storage)?;
        let axes = gpu.buffer("axes of cones", cast_slice(&axes), storage)?;
        let results = gpu.answers::<[f32; 2]>("cones", count)?;
        let march = self.octree.march(plan, points.len() as u32);
        let march = gpu.buffer("plan", bytes_of(&march), wgpu::BufferUsages::UNIFORM)?;
        let groups = (count as u32).div_ceil(GROUP);
        self.kernel.run(gpu, &self.bindings, &[&march, &asked, &axes, &results], groups)?;
        let found: Vec<[f32; 2]> = gpu.read_later(&results, count).await?;
        Ok(found.into_iter().map(|[visibility, error]| ConeResult { visibility, error }).collect())
    }
}
