//! The octree as shaders read it, and the march through it: twins of shaders/shared/octree.wgsl and shaders/cones.wgsl.

use crate::{Gpu, GpuError, points::falloff_number};
use bytemuck::{Pod, Zeroable, cast_slice};
use conray_core::Vec3;
use conray_estimate::AoPlan;
use conray_voxel::{MarchOptions, Octree};

/// What all cones of a plan share.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MarchUniform {
    pub(crate) origin: Vec3,
    pub(crate) voxel_size: f32,
    pub(crate) resolution: f32,
    pub(crate) spread: f32,
    pub(crate) step: f32,
    pub(crate) lift: f32,
    pub(crate) distance: f32,
    pub(crate) top: f32,
    pub(crate) falloff: u32,
    pub(crate) cones: u32,
    pub(crate) points: u32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
    pub(crate) pad_c: u32,
}

/// An octree on a device.
pub(crate) struct GpuOctree {
    origin: Vec3,
    voxel_size: f32,
    resolution: u32,
    levels: usize,
    pub(crate) buffers: [wgpu::Buffer; 3],
}

impl GpuOctree {
    pub(crate) fn new(gpu: &Gpu, octree: &Octree) -> Result<Self, GpuError> {
        let [words, places] = octree.packed_counts();
        gpu.check_size("opacities of the octree", 4 * words)?;
        gpu.check_size("places of the octree's bricks", 4 * places)?;
        let packed = octree.packed();
        let storage = wgpu::BufferUsages::STORAGE;
        let buffers = [
            gpu.buffer("levels", cast_slice(&packed.levels), storage)?,
            gpu.buffer("places of the octree's bricks", cast_slice(&packed.table), storage)?,
            gpu.buffer("opacities of the octree", cast_slice(&packed.words), storage)?,
        ];
        let (origin, voxel_size, resolution) = (packed.origin, packed.voxel_size, packed.resolution);
        Ok(Self { origin, voxel_size, resolution, levels: packed.levels.len(), buffers })
    }

    /// The march of a plan's cones from so many points.
    pub(crate) fn march(&self, plan: &AoPlan, points: u32) -> MarchUniform {
        let options = MarchOptions::default();
        MarchUniform {
            origin: self.origin,
            voxel_size: self.voxel_size,
            resolution: self.resolution as f32,
            spread: 2.0 * plan.cones.half_angle_rad().clamp(0.0, 1.5).tan() * options.width,
            step: options.step.clamp(0.1, 4.0),
            lift: options.lift,
            distance: (plan.distance / self.voxel_size).min(f32::MAX),
            top: self.levels as f32 - 1.0,
            falloff: falloff_number(plan.falloff),
            cones: plan.cones.cones().len() as u32,
            points,
            pad_a: 0,
            pad_b: 0,
            pad_c: 0,
        }
    }
}
