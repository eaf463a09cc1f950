//! Bundles of method `hybrid` on a device: twins of shaders/bundles.wgsl.

use crate::{
    Gpu, GpuError,
    kernel::{Bound, GROUP, Kernel},
    points::{GpuPoint, falloff_number},
    rays::Rays,
};
use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use conray_core::{SurfacePoint, Vec3, hash_u32};
use conray_estimate::{AoPlan, Batch, BatchFound, UnitFound};

/// Rays of a unit.
const UNIT: u32 = 16;

/// What all rays share.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct BundlesUniform {
    pub(crate) distance: f32,
    pub(crate) reach: f32,
    pub(crate) bias: f32,
    pub(crate) falloff: u32,
    pub(crate) seed: u32,
    pub(crate) units: u32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
}

/// A unit that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuUnit {
    pub(crate) point: u32,
    pub(crate) index: u32,
}

/// What it found.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuUnitTold {
    pub(crate) bent: Vec3,
    pub(crate) mean: f32,
    pub(crate) variance: f32,
    pub(crate) of_full: f32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
}

/// Traces bundles.
pub(crate) struct BundleRays {
    kernel: Kernel,
}

impl BundleRays {
    pub(crate) fn new(gpu: &Gpu, rays: &Rays) -> Result<Self, GpuError> {
        let asked = [Bound::Uniform, Bound::Read, Bound::Read, Bound::Write];
        Ok(Self { kernel: Kernel::new(gpu, "bundles", &rays.scene.layout, &asked)? })
    }

    /// What each batch found, in order.
    pub(crate) fn trace(
        &self,
        gpu: &Gpu,
        rays: &Rays,
        plan: &AoPlan,
        points: &[SurfacePoint],
        batches: &[Batch],
        salt: u32,
    ) -> Result<Vec<BatchFound>, GpuError> {
        let packed: Vec<GpuPoint> =
            batches.iter().map(|batch| GpuPoint::of_rays(&points[batch.point as usize])).collect();
        let (units, firsts) = laid_out(batches);
        let uniform = BundlesUniform {
            distance: plan.distance.min(f32::MAX),
            reach: plan.reach,
            bias: plan.bias,
            falloff: falloff_number(plan.falloff),
            seed: hash_u32(plan.seed ^ salt),
            units: units.len() as u32,
            pad_a: 0,
            pad_b: 0,
        };
        let storage = wgpu::BufferUsages::STORAGE;
        let uniform = gpu.buffer("plan", bytes_of(&uniform), wgpu::BufferUsages::UNIFORM)?;
        let asked = gpu.buffer("points", cast_slice(&packed), storage)?;
        let unit_buffer = gpu.buffer("units of rays", cast_slice(&units), storage)?;
        let told = gpu.answers::<GpuUnitTold>("what units found", units.len())?;
        let groups = (units.len() as u32).div_ceil(GROUP / UNIT);
        self.kernel.run(gpu, &rays.scene.bindings, &[&uniform, &asked, &unit_buffer, &told], groups)?;
        let told: Vec<GpuUnitTold> = gpu.read(&told, units.len())?;
        let each = batches.iter().zip(firsts);
        Ok(each.map(|(batch, first)| batch_of(&told[first..first + batch.count as usize])).collect())
    }
}

/// The units of batches, those of full bundles first, so that each of these is a workgroup; and the place of each batch's first.
fn laid_out(batches: &[Batch]) -> (Vec<GpuUnit>, Vec<usize>) {
    let (mut units, mut firsts) = (Vec::new(), vec![0; batches.len()]);
    for full in [true, false] {
        for (k, batch) in batches.iter().enumerate().filter(|(_, batch)| batch.is_full() == full) {
            firsts[k] = units.len();
            let indices = batch.first..batch.first + batch.count;
            units.extend(indices.map(|index| GpuUnit { point: k as u32, index }));
        }
    }
    (units, firsts)
}

fn batch_of(told: &[GpuUnitTold]) -> BatchFound {
    let mut found = BatchFound { variance: told[0].of_full, ..BatchFound::default() };
    for (unit, told) in found.units.iter_mut().zip(told) {
        *unit = UnitFound { mean: told.mean, variance: told.variance, bent: told.bent };
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_bundles_begin_workgroups() {
        let batch = |point, first, count| Batch { point, first, count };
        let batches = [batch(5, 0, 1), batch(6, 4, 4), batch(7, 2, 2), batch(8, 8, 4)];
        let (units, firsts) = laid_out(&batches);
        assert_eq!(firsts, [8, 0, 9, 4]);
        let of = |k: usize| units[firsts[k]..][..batches[k].count as usize].to_vec();
        assert_eq!(of(2), [GpuUnit { point: 2, index: 2 }, GpuUnit { point: 2, index: 3 }]);
        assert_eq!(units.len(), 11);
    }
}
