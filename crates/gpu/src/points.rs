//! What a shader reads of points and plan, and what it tells: twins of shaders/shared/points.wgsl.

use crate::GpuError;
use bytemuck::{Pod, Zeroable};
use conray_core::{Falloff, SurfacePoint, Vec3};
use conray_estimate::{AoPlan, RayTally, Sampling};
use std::ops::Range;

/// What all points share.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct AoUniform {
    pub(crate) distance: f32,
    pub(crate) reach: f32,
    pub(crate) bias: f32,
    pub(crate) falloff: u32,
    pub(crate) seed: u32,
    pub(crate) first_sample: u32,
    pub(crate) samples: u32,
    pub(crate) points: u32,
    pub(crate) stride: u32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
    pub(crate) pad_c: u32,
}

impl AoUniform {
    /// For some samples, no more than a workgroup has threads, of so many points.
    pub(crate) fn new(plan: &AoPlan, samples: Range<u32>, points: u32) -> Result<Self, GpuError> {
        if plan.sampling != Sampling::Sobol {
            return Err(GpuError::Unsupported("sampling other than sobol"));
        }
        Ok(Self {
            distance: plan.distance.min(f32::MAX),
            reach: plan.reach,
            bias: plan.bias,
            falloff: falloff_number(plan.falloff),
            seed: plan.seed,
            first_sample: samples.start,
            samples: samples.len() as u32,
            points,
            stride: (samples.len() as u32).next_power_of_two(),
            pad_a: 0,
            pad_b: 0,
            pad_c: 0,
        })
    }
}

/// As shaders tell it.
pub(crate) fn falloff_number(falloff: Falloff) -> u32 {
    match falloff {
        Falloff::None => 0,
        Falloff::Linear => 1,
        Falloff::Smooth => 2,
    }
}

/// A surface point.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuPoint {
    pub(crate) origin: Vec3,
    pub(crate) id: u32,
    pub(crate) geometric_normal: Vec3,
    pub(crate) pad_a: u32,
    pub(crate) shading_normal: Vec3,
    pub(crate) pad_b: u32,
}

impl GpuPoint {
    /// Where its rays start.
    pub(crate) fn of_rays(point: &SurfacePoint) -> Self {
        Self::at(point, point.ray_origin())
    }

    /// Where its cones stand.
    pub(crate) fn of_cones(point: &SurfacePoint) -> Self {
        Self::at(point, point.position)
    }

    fn at(point: &SurfacePoint, origin: Vec3) -> Self {
        Self {
            origin,
            id: point.id,
            geometric_normal: point.geometric_normal,
            pad_a: 0,
            shading_normal: point.shading_normal,
            pad_b: 0,
        }
    }
}

/// What the rays of a point met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuTally {
    pub(crate) open: Vec3,
    pub(crate) rays: u32,
    pub(crate) sum: f32,
    pub(crate) squares: f32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
}

impl GpuTally {
    /// As the CPU keeps it.
    pub(crate) fn tally(&self) -> RayTally {
        RayTally { rays: self.rays, sum: self.sum, squares: self.squares, open: self.open }
    }
}
