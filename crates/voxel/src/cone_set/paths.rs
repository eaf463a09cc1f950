//! The lines on which sixteen cones are sampled.

use super::lanes::{Fan, LocalAxes};
use crate::steps::Step;
use conray_core::Vec3;
use fearless_simd::{Simd, f32x16, prelude::*};

#[derive(Clone, Copy)]
pub(super) struct Paths<S: Simd> {
    /// In leaves, like all lengths of steps.
    apex: [f32x16<S>; 3],
    normal: [f32x16<S>; 3],
    pub(super) axis: [f32x16<S>; 3],
    /// Height over the tangent plane gained per length.
    rise: f32x16<S>,
}

impl<S: Simd> Paths<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, fan: &Fan, axes: &LocalAxes) -> Self {
        let apex = splat(simd, fan.apex);
        let normal = splat(simd, fan.normal);
        let (fx, fy, fz) = (splat(simd, fan.frame.x), splat(simd, fan.frame.y), splat(simd, fan.frame.z));
        let x = f32x16::from_slice(simd, &axes.components[0].0);
        let y = f32x16::from_slice(simd, &axes.components[1].0);
        let z = f32x16::from_slice(simd, &axes.components[2].0);
        // Products and sums apart, never fused, in the order of `Frame::to_world`: the same bits at every level.
        let axis_x = fx[0] * x + fy[0] * y + fz[0] * z;
        let axis_y = fx[1] * x + fy[1] * y + fz[1] * z;
        let axis_z = fx[2] * x + fy[2] * y + fz[2] * z;
        let rise = normal[0] * axis_x + normal[1] * axis_y + normal[2] * axis_z;
        Self { apex, normal, axis: [axis_x, axis_y, axis_z], rise }
    }

    /// The same in nodes of a level.
    #[inline(always)]
    pub(super) fn in_nodes(&self, simd: S, level: usize) -> ScaledPaths<'_, S> {
        let nodes = 1.0 / (1u32 << level) as f32;
        let by = f32x16::splat(simd, nodes);
        ScaledPaths { paths: self, nodes, apex: [self.apex[0] * by, self.apex[1] * by, self.apex[2] * by] }
    }
}

/// The lines in nodes of a level.
pub(super) struct ScaledPaths<'a, S: Simd> {
    paths: &'a Paths<S>,
    /// Nodes in a leaf.
    nodes: f32,
    apex: [f32x16<S>; 3],
}

impl<S: Simd> ScaledPaths<'_, S> {
    /// Where the cones are sampled at a step: [`Step::position`] in nodes, sixteen times. Powers of two change no bit, so each
    /// may be multiplied where it costs least.
    #[inline(always)]
    pub(super) fn at(&self, simd: S, step: &Step) -> [f32x16<S>; 3] {
        let Paths { normal, axis, rise, .. } = self.paths;
        let middle = f32x16::splat(simd, step.middle * self.nodes);
        let lift = f32x16::splat(simd, step.lift * self.nodes);
        let lift = (lift - middle * *rise).max(f32x16::splat(simd, 0.0));
        [
            self.apex[0] + axis[0] * middle + normal[0] * lift,
            self.apex[1] + axis[1] * middle + normal[1] * lift,
            self.apex[2] + axis[2] * middle + normal[2] * lift,
        ]
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: Vec3) -> [f32x16<S>; 3] {
    [f32x16::splat(simd, v.x), f32x16::splat(simd, v.y), f32x16::splat(simd, v.z)]
}
