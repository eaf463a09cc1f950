//! What the kernels of a picture read: twins of shaders/see.wgsl, lattice.wgsl and resolve.wgsl.

use super::{FrameCamera, passes::Pass};
use crate::points::falloff_number;
use bytemuck::{Pod, Zeroable};
use conray_core::{Vec3, hash_u32};
use conray_estimate::AoPlan;

/// The camera.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CameraUniform {
    pub(crate) eye: Vec3,
    pub(crate) width: u32,
    pub(crate) right: Vec3,
    pub(crate) height: u32,
    pub(crate) up: Vec3,
    pub(crate) stride: u32,
    pub(crate) forward: Vec3,
    pub(crate) pixel_side: f32,
    pub(crate) unit: f32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
    pub(crate) pad_c: u32,
}

impl CameraUniform {
    pub(super) fn new(camera: &FrameCamera, [width, height, stride]: [u32; 3], unit: f32) -> Self {
        let FrameCamera { eye, right, up, forward, pixel_side } = *camera;
        Self { eye, width, right, height, up, stride, forward, pixel_side, unit, ..Self::zeroed() }
    }
}

/// Rays of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LatticeUniform {
    pub(crate) distance: f32,
    pub(crate) reach: f32,
    pub(crate) bias: f32,
    pub(crate) falloff: u32,
    pub(crate) seed: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) stride: u32,
    pub(crate) first_rank: u32,
    pub(crate) ranks: u32,
    pub(crate) unit: u32,
    pub(crate) pad: u32,
}

impl LatticeUniform {
    pub(super) fn new(plan: &AoPlan, [width, height, stride]: [u32; 3], pass: &Pass) -> Self {
        Self {
            distance: plan.distance.min(f32::MAX),
            reach: plan.reach,
            bias: plan.bias,
            falloff: falloff_number(plan.falloff),
            seed: hash_u32(plan.seed),
            width,
            height,
            stride,
            first_rank: pass.ranks.start,
            ranks: pass.ranks.len() as u32,
            unit: pass.unit,
            pad: 0,
        }
    }
}

/// How a picture is shown.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ShownUniform {
    pub(crate) background: u32,
    pub(crate) width: u32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
}
