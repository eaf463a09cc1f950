//! Method `rays` on a device.

use crate::{
    Gpu, GpuError,
    kernel::{Bound, GROUP, Kernel},
    points::{AoUniform, GpuPoint, GpuTally},
    scene::GpuScene,
};
use bytemuck::{bytes_of, cast_slice};
use conray_core::SurfacePoint;
use conray_estimate::{AoPlan, Control};
use std::ops::Range;

/// Traces rays.
pub(crate) struct Rays {
    pub(crate) scene: GpuScene,
    kernel: Kernel,
}

impl Rays {
    pub(crate) fn new(gpu: &Gpu, scene: GpuScene) -> Result<Self, GpuError> {
        let asked = [Bound::Uniform, Bound::Read, Bound::Write];
        let kernel = Kernel::new(gpu, "rays", &scene.layout, &asked)?;
        Ok(Self { scene, kernel })
    }

    /// What the rays of points met; nothing where the work was stopped.
    pub(crate) async fn tallies(
        &self,
        gpu: &Gpu,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Option<Vec<GpuTally>>, GpuError> {
        let packed: Vec<GpuPoint> = points.iter().map(GpuPoint::of_rays).collect();
        let asked = gpu.buffer("points", cast_slice(&packed), wgpu::BufferUsages::STORAGE)?;
        let tallies = gpu.answers::<GpuTally>("tallies", points.len())?;
        let count = points.len() as u32;
        for first in samples.clone().step_by(GROUP as usize) {
            if control.is_cancelled() {
                return Ok(None);
            }
            let part = first..samples.end.min(first.saturating_add(GROUP));
            let uniform = AoUniform::new(plan, part, count)?;
            let groups = count.div_ceil(GROUP / uniform.stride);
            let uniform = gpu.buffer("plan", bytes_of(&uniform), wgpu::BufferUsages::UNIFORM)?;
            self.kernel.run(gpu, &self.scene.bindings, &[&uniform, &asked, &tallies], groups)?;
        }
        gpu.read_later(&tallies, points.len()).await.map(Some)
    }
}
