//! One entry point of the shaders: its pipeline, and runs of it, one after the other.

use crate::{Gpu, GpuError, clock::Clock, source};
use bytemuck::AnyBitPattern;
use futures_channel::oneshot;

/// Threads of a workgroup, as the shaders say.
pub(crate) const GROUP: u32 = 64;
/// Workgroups in a row; every device takes 65 535.
const ROW: u32 = 1 << 15;

/// An entry point.
pub(crate) struct Kernel {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    /// Of the second group of bindings: what changes from run to run.
    asked: wgpu::BindGroupLayout,
}

/// How a buffer is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bound {
    Uniform,
    Read,
    Write,
}

impl Kernel {
    /// Compiles the entry point of that name, which is that of its file too. `scene` is its first group of bindings.
    pub(crate) fn new(
        gpu: &Gpu,
        name: &'static str,
        scene: &wgpu::BindGroupLayout,
        asked: &[Bound],
    ) -> Result<Self, GpuError> {
        Self::of_text(gpu, name, source(&format!("{name}.wgsl")), scene, asked)
    }

    fn of_text(
        gpu: &Gpu,
        name: &'static str,
        text: String,
        scene: &wgpu::BindGroupLayout,
        asked: &[Bound],
    ) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let asked = layout(gpu, name, asked);
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &[Some(scene), Some(&asked)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(name),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { name, pipeline, asked })
    }

    /// Runs so many workgroups and waits for them.
    pub(crate) fn run(
        &self,
        gpu: &Gpu,
        scene: &wgpu::BindGroup,
        asked: &[&wgpu::Buffer],
        groups: u32,
    ) -> Result<(), GpuError> {
        let mut steps = Steps::new(gpu);
        steps.add(self, scene, asked, groups)?;
        steps.finish()
    }
}

/// Runs of kernels one after the other: each sees what those before it wrote.
pub(crate) struct Steps<'a> {
    gpu: &'a Gpu,
    encoder: wgpu::CommandEncoder,
    names: Vec<&'static str>,
}

impl<'a> Steps<'a> {
    pub(crate) fn new(gpu: &'a Gpu) -> Self {
        let encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        Self { gpu, encoder, names: Vec::new() }
    }

    /// So many workgroups of a kernel.
    pub(crate) fn add(
        &mut self,
        kernel: &Kernel,
        scene: &wgpu::BindGroup,
        asked: &[&wgpu::Buffer],
        groups: u32,
    ) -> Result<(), GpuError> {
        if self.names.len() == Clock::RUNS {
            std::mem::replace(self, Self::new(self.gpu)).finish()?;
        }
        let asked = bind(self.gpu, &kernel.asked, asked);
        let first = 2 * self.names.len() as u32;
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(kernel.name),
            timestamp_writes: self.gpu.clock.as_ref().map(|clock| wgpu::ComputePassTimestampWrites {
                query_set: &clock.stamps,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            }),
        });
        pass.set_pipeline(&kernel.pipeline);
        pass.set_bind_group(0, scene, &[]);
        pass.set_bind_group(1, &asked, &[]);
        pass.dispatch_workgroups(groups.clamp(1, ROW), groups.div_ceil(ROW).max(1), 1);
        self.names.push(kernel.name);
        Ok(())
    }

    /// Waits for all of them.
    pub(crate) fn finish(mut self) -> Result<(), GpuError> {
        if let Some(clock) = &self.gpu.clock {
            let stamps = 0..2 * self.names.len() as u32;
            self.encoder.resolve_query_set(&clock.stamps, stamps, &clock.resolved, 0);
        }
        self.gpu.queue.submit([self.encoder.finish()]);
        self.gpu.wait()?;
        self.gpu.clock.as_ref().map_or(Ok(()), |clock| clock.note(self.gpu, &self.names))
    }
}

/// Buffers that all runs share, those of a scene say, and how each is bound.
pub(crate) fn shared_bindings(
    gpu: &Gpu,
    label: &'static str,
    buffers: &[(Bound, &wgpu::Buffer)],
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let bound: Vec<Bound> = buffers.iter().map(|(bound, _)| *bound).collect();
    let buffers: Vec<&wgpu::Buffer> = buffers.iter().map(|(_, buffer)| *buffer).collect();
    let layout = layout(gpu, label, &bound);
    let bindings = bind(gpu, &layout, &buffers);
    (layout, bindings)
}

/// How buffers of a group are bound.
pub(crate) fn layout(gpu: &Gpu, label: &'static str, bound: &[Bound]) -> wgpu::BindGroupLayout {
    let entry = |(binding, bound): (u32, &Bound)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match bound {
                Bound::Uniform => wgpu::BufferBindingType::Uniform,
                _ => wgpu::BufferBindingType::Storage { read_only: *bound == Bound::Read },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(bound).map(entry).collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries };
    gpu.device.create_bind_group_layout(&descriptor)
}

pub(crate) fn bind(gpu: &Gpu, layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
    let mut entries = Vec::new();
    for (binding, buffer) in (0..).zip(buffers) {
        entries.push(wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
    }
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

impl Gpu {
    fn wait(&self) -> Result<(), GpuError> {
        let done = self.device.poll(wgpu::PollType::wait_indefinitely());
        done.map_err(|e| self.failed(e.to_string()))?;
        self.check()
    }

    /// The first values of a buffer.
    pub(crate) fn read<T: AnyBitPattern>(
        &self,
        buffer: &wgpu::Buffer,
        count: usize,
    ) -> Result<Vec<T>, GpuError> {
        pollster::block_on(self.read_later(buffer, count))
    }

    /// The same as a future: on a page it is there once the page had its turn, elsewhere at once.
    pub(crate) async fn read_later<T: AnyBitPattern>(
        &self,
        buffer: &wgpu::Buffer,
        count: usize,
    ) -> Result<Vec<T>, GpuError> {
        let size = buffer.size();
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("answers"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, size);
        self.queue.submit([encoder.finish()]);
        let (tell, told) = oneshot::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| _ = tell.send(result));
        self.wait()?;
        match told.await {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(self.failed(e.to_string())),
            Err(_) => return Err(self.failed("it did not answer")),
        }
        let bytes = staging.get_mapped_range(..).map_err(|e| self.failed(e.to_string()))?;
        let values = bytes[..count * size_of::<T>()].chunks_exact(size_of::<T>());
        Ok(values.map(bytemuck::pod_read_unaligned).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "needs a graphics adapter, if only a software one"]
    fn a_shader_that_is_refused_is_told_gpu() {
        for (from, to) in [("fn resolve", "fn resolved"), ("error = vec2", "error = vec3"), ("sum", "@")] {
            let gpu = Gpu::open(None).unwrap();
            let shared = layout(&gpu, "shared", &[Bound::Uniform, Bound::Read, Bound::Read]);
            let asked = [Bound::Uniform, Bound::Read, Bound::Write, Bound::Write];
            let of = |text| Kernel::of_text(&gpu, "resolve", text, &shared, &asked);
            let text = source("resolve.wgsl");
            assert!(of(text.clone()).is_ok());
            let Err(GpuError::Failed { reason, .. }) = of(text.replace(from, to)) else {
                panic!("{to} is taken")
            };
            assert!(reason.contains("resolve"), "{reason}");
        }
    }
}
