//! The rays of the published blend on a device: some in each cone of each point. Twins of shaders/cone_rays.wgsl.

use crate::{
    Gpu, GpuError,
    kernel::{Bound, GROUP, Kernel},
    points::{GpuPoint, GpuTally, falloff_number},
    rays::Rays,
};
use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use conray_core::{Cone, SurfacePoint, Vec2, Vec3};
use conray_estimate::{AoPlan, Control};
use std::ops::Range;

/// What all rays share.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ConeRaysUniform {
    pub(crate) distance: f32,
    pub(crate) bias: f32,
    pub(crate) falloff: u32,
    pub(crate) seed: u32,
    pub(crate) frames_start: u32,
    pub(crate) frames_end: u32,
    pub(crate) first: u32,
    pub(crate) stride: u32,
    pub(crate) cones: u32,
    pub(crate) points: u32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
}

/// Where a cone's rays go.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuCone {
    pub(crate) axis: Vec3,
    pub(crate) cos_half_angle: f32,
    pub(crate) low: Vec2,
    pub(crate) edge: f32,
    pub(crate) pad: u32,
}

impl From<&Cone> for GpuCone {
    fn from(cone: &Cone) -> Self {
        let (low, edge) = cone.cell().unwrap_or((Vec2::ZERO, 0.0));
        Self { axis: cone.axis, cos_half_angle: cone.half_angle_rad.cos(), low, edge, pad: 0 }
    }
}

/// Whose rays are asked for.
pub(crate) struct Asked<'a> {
    pub(crate) frames: Range<u32>,
    pub(crate) points: &'a [SurfacePoint],
    /// Rays of each cone of each point in a frame.
    pub(crate) counts: &'a [u32],
}

/// Traces the rays of cones.
pub(crate) struct ConeRays {
    kernel: Kernel,
}

impl ConeRays {
    pub(crate) fn new(gpu: &Gpu, rays: &Rays) -> Result<Self, GpuError> {
        let asked = [Bound::Uniform, Bound::Read, Bound::Read, Bound::Read, Bound::Write];
        Ok(Self { kernel: Kernel::new(gpu, "cone_rays", &rays.scene.layout, &asked)? })
    }

    /// What the rays of the cones of points met; nothing where the work was stopped.
    pub(crate) async fn tallies(
        &self,
        gpu: &Gpu,
        rays: &Rays,
        plan: &AoPlan,
        Asked { frames, points, counts }: &Asked<'_>,
        control: Control<'_>,
    ) -> Result<Option<Vec<GpuTally>>, GpuError> {
        let packed: Vec<GpuPoint> = points.iter().map(GpuPoint::of_rays).collect();
        let cones: Vec<GpuCone> = plan.cones.cones().iter().map(GpuCone::from).collect();
        let storage = wgpu::BufferUsages::STORAGE;
        let asked = gpu.buffer("points", cast_slice(&packed), storage)?;
        let cone_buffer = gpu.buffer("cones", cast_slice(&cones), storage)?;
        let count_buffer = gpu.buffer("rays of cones", cast_slice(counts), storage)?;
        let tallies = gpu.answers::<GpuTally>("tallies", counts.len())?;
        let most = counts.iter().max().map_or(0, |most| most.saturating_mul(frames.len() as u32));
        let stride = most.next_power_of_two().min(GROUP);
        for first in (0..most).step_by(stride as usize) {
            if control.is_cancelled() {
                return Ok(None);
            }
            let uniform = ConeRaysUniform {
                distance: plan.distance.min(f32::MAX),
                bias: plan.bias,
                falloff: falloff_number(plan.falloff),
                seed: plan.seed,
                frames_start: frames.start,
                frames_end: frames.end,
                first,
                stride,
                cones: cones.len() as u32,
                points: points.len() as u32,
                pad_a: 0,
                pad_b: 0,
            };
            let uniform = gpu.buffer("plan", bytes_of(&uniform), wgpu::BufferUsages::UNIFORM)?;
            let groups = (counts.len() as u32).div_ceil(GROUP / stride);
            let asked = [&uniform, &asked, &cone_buffer, &count_buffer, &tallies];
            self.kernel.run(gpu, &rays.scene.bindings, &asked, groups)?;
        }
        gpu.read_later(&tallies, counts.len()).await.map(Some)
    }
}
