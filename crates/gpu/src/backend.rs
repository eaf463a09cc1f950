//! Plans carried out on a device.

use crate::{
    Gpu, GpuError, GpuScene,
    points::{AoUniform, GROUP, GpuPoint, GpuTally},
    source,
};
use bytemuck::{bytes_of, cast_slice};
use conray_core::{Estimate, SurfacePoint};
use conray_estimate::{AoPlan, Backend, BackendError, Control};
use std::{ops::Range, sync::mpsc};

/// Points that are asked about together: with as many rays as a workgroup has threads short enough that no driver takes the device for stuck.
const POINTS_AT_ONCE: usize = 1 << 18;
/// Workgroups in a row; every device takes 65 535.
const ROW: u32 = 1 << 15;

/// Estimates points on a device.
pub struct GpuBackend {
    gpu: Gpu,
    scene: GpuScene,
    rays: wgpu::ComputePipeline,
    asked: wgpu::BindGroupLayout,
}

impl GpuBackend {
    /// Compiles the shaders for a scene.
    ///
    /// # Errors
    /// A shader that the device refuses, or a device that fails.
    pub fn new(gpu: Gpu, scene: GpuScene) -> Result<Self, GpuError> {
        let buffer = |binding: u32, ty: wgpu::BufferBindingType| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let asked = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("points"),
            entries: &[
                buffer(0, wgpu::BufferBindingType::Uniform),
                buffer(1, wgpu::BufferBindingType::Storage { read_only: true }),
                buffer(2, wgpu::BufferBindingType::Storage { read_only: false }),
            ],
        });
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("rays"),
            source: wgpu::ShaderSource::Wgsl(source("rays.wgsl").into()),
        });
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("rays"),
            bind_group_layouts: &[Some(&scene.layout), Some(&asked)],
            immediate_size: 0,
        });
        let rays = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("rays"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("rays"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, scene, rays, asked })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Refuses a plan that is not built for devices.
    ///
    /// # Errors
    /// What is missing.
    pub fn check(plan: &AoPlan) -> Result<(), GpuError> {
        AoUniform::new(plan, 0..1, 0).map(|_| ())
    }

    fn estimated(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        estimates: &mut [Estimate],
        control: Control<'_>,
    ) -> Result<(), GpuError> {
        Self::check(plan)?;
        for (points, estimates) in points.chunks(POINTS_AT_ONCE).zip(estimates.chunks_mut(POINTS_AT_ONCE)) {
            if control.is_cancelled() {
                return Ok(());
            }
            if let Some(found) = self.tallies(plan, samples.clone(), points, control)? {
                for ((estimate, tally), point) in estimates.iter_mut().zip(&found).zip(points) {
                    let invalid = Estimate { visibility: 0.0, error: f32::INFINITY, ..Estimate::PENDING };
                    *estimate = if point.is_valid() { tally.estimate() } else { invalid };
                }
                (control.progress)(points.len());
            }
        }
        Ok(())
    }

    /// What the rays of points met; nothing where the work was stopped.
    fn tallies(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Option<Vec<GpuTally>>, GpuError> {
        let gpu = &self.gpu;
        let packed: Vec<GpuPoint> = points.iter().map(GpuPoint::from).collect();
        let empty = vec![GpuTally::default(); points.len()];
        let (storage, read) = (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::COPY_SRC);
        let asked = gpu.buffer("points", cast_slice(&packed), storage)?;
        let tallies = gpu.buffer("tallies", cast_slice(&empty), storage | read)?;
        let count = points.len() as u32;
        for first in samples.clone().step_by(GROUP as usize) {
            if control.is_cancelled() {
                return Ok(None);
            }
            let part = first..samples.end.min(first.saturating_add(GROUP));
            let uniform = AoUniform::new(plan, part, count)?;
            let groups = count.div_ceil(GROUP / uniform.stride).max(1);
            let uniform = gpu.buffer("plan", bytes_of(&uniform), wgpu::BufferUsages::UNIFORM)?;
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("points"),
                layout: &self.asked,
                entries: &[bound(0, &uniform), bound(1, &asked), bound(2, &tallies)],
            });
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&self.rays);
                pass.set_bind_group(0, &self.scene.bindings, &[]);
                pass.set_bind_group(1, &group, &[]);
                pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
            }
            gpu.queue.submit([encoder.finish()]);
            self.wait()?;
        }
        self.read(&tallies, points.len()).map(Some)
    }

    fn wait(&self) -> Result<(), GpuError> {
        let done = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        done.map_err(|e| self.gpu.failed(e.to_string()))?;
        self.gpu.check()
    }

    /// The tallies of a buffer.
    fn read(&self, tallies: &wgpu::Buffer, count: usize) -> Result<Vec<GpuTally>, GpuError> {
        let gpu = &self.gpu;
        let size = tallies.size();
        let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("answers"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(tallies, 0, &staging, 0, size);
        gpu.queue.submit([encoder.finish()]);
        let (tell, told) = mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| _ = tell.send(result));
        self.wait()?;
        match told.recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(gpu.failed(e.to_string())),
            Err(_) => return Err(gpu.failed("it did not answer")),
        }
        let bytes = staging.get_mapped_range(..).map_err(|e| gpu.failed(e.to_string()))?;
        let found = bytes[..count * size_of::<GpuTally>()]
            .chunks_exact(size_of::<GpuTally>())
            .map(bytemuck::pod_read_unaligned)
            .collect();
        Ok(found)
    }
}

fn bound(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
}

impl Backend for GpuBackend {
    fn estimate(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        estimates: &mut [Estimate],
        control: Control<'_>,
    ) -> Result<(), BackendError> {
        if points.len() != estimates.len() {
            return Err(BackendError::LengthMismatch { points: points.len(), estimates: estimates.len() });
        }
        self.estimated(plan, samples, points, estimates, control)
            .map_err(|e| BackendError::Device(e.to_string()))
    }
}
