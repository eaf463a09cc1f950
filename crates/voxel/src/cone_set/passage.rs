//! How what sixteen cones meet composes: `compose.rs`, side by side and in the same order.

use super::{
    lanes::{LANES, Lanes},
    slopes::WideSlope,
};
use crate::{
    ConeResult,
    compose::{CLEAR_CHANGE, CLOSED, UNKNOWN_SHARE},
    steps::Step,
};
use fearless_simd::{Simd, f32x16, prelude::*};

/// What sixteen cones have met so far: `Composition`.
pub(super) struct Passage<S: Simd> {
    now: f32x16<S>,
    /// What passed after the last step, and after the one before.
    before: [f32x16<S>; 2],
    closed: f32x16<S>,
    error: f32x16<S>,
    /// The step after the last one that was added.
    next: usize,
}

impl<S: Simd> Passage<S> {
    #[inline(always)]
    pub(super) fn open(simd: S) -> Self {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        Self { now: one, before: [one; 2], closed: zero, error: zero, next: 0 }
    }

    /// Adds step number `index`, at which cones that meet nothing have a slope of zero; bits of those of the cones in `met` that
    /// are closed now.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        simd: S,
        index: usize,
        step: &Step,
        slope: &WideSlope<S>,
        axis: &[f32x16<S>; 3],
        met: u32,
    ) -> u32 {
        if index > self.next {
            self.before = [self.now; 2];
        }
        self.next = index + 1;
        let falloff = f32x16::splat(simd, step.falloff);
        let in_nodes = f32x16::splat(simd, step.length / step.node);
        self.error += self.now * slope.sd * in_nodes * falloff;
        let less = (blocked(simd, step, slope, axis) * self.before[1]).min(self.now);
        self.now -= less;
        self.before = [self.now, self.before[0]];
        self.closed += less * falloff;
        let closed = self.now.simd_lt(f32x16::splat(simd, CLOSED)).to_bitmask() as u32 & met;
        if closed != 0 {
            self.close(simd, closed, falloff);
        }
        closed
    }

    /// Counts the rest of some cones as closed.
    #[inline(always)]
    fn close(&mut self, simd: S, closed: u32, falloff: f32x16<S>) {
        let mut which = Lanes([0.0; LANES]);
        for (lane, which) in which.0.iter_mut().enumerate() {
            *which = if closed >> lane & 1 == 1 { 1.0 } else { 0.0 };
        }
        // Nothing is added to the others: 0 times a number.
        self.closed += self.now * falloff * f32x16::from_slice(simd, &which.0);
    }

    /// Visibility and error of each.
    #[inline(always)]
    pub(super) fn results(self, simd: S) -> [ConeResult; LANES] {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let (mut visibility, mut error) = (Lanes([0.0; LANES]), Lanes([0.0; LANES]));
        (one - self.closed).max(zero).min(one).store_slice(&mut visibility.0);
        self.error.store_slice(&mut error.0);
        let mut results = [ConeResult { visibility: 1.0, error: 0.0 }; LANES];
        for (result, (&visibility, &error)) in results.iter_mut().zip(visibility.0.iter().zip(&error.0)) {
            *result = ConeResult { visibility, error };
        }
        results
    }
}

/// `blocked_by` and `met_share`, sixteen times.
#[inline(always)]
fn blocked<S: Simd>(simd: S, step: &Step, slope: &WideSlope<S>, axis: &[f32x16<S>; 3]) -> f32x16<S> {
    let node = f32x16::splat(simd, step.node);
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let unknown = f32x16::splat(simd, UNKNOWN_SHARE);
    let (x, y, z) = (slope.gradient[0] * node, slope.gradient[1] * node, slope.gradient[2] * node);
    let largest = x.abs().max(y.abs()).max(z.abs());
    let clear = (largest / (f32x16::splat(simd, CLEAR_CHANGE) * slope.mean)).min(one);
    let dot = x * axis[0] + y * axis[1] + z * axis[2];
    let known = clear * (dot.abs() / largest) + (one - clear) * unknown;
    let share = largest.simd_le(zero).select(unknown, known);
    slope.mean * f32x16::splat(simd, step.length) * share
}
