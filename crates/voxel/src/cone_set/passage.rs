//! How what sixteen cones meet composes: `compose.rs`, side by side and in the same order.

use super::{lanes::store, samples::Found};
use crate::{ConeResult, compose::CLOSED, steps::Step};
use fearless_simd::{Simd, f32x16, mask32x16, prelude::*};

/// What sixteen cones have met so far: `Composition`.
#[derive(Clone, Copy)]
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

    /// Adds step number `index`, number `k` of its part, at which the cones in `met` found something; bits of those of them
    /// that are closed now.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        simd: S,
        index: usize,
        step: &Step,
        found: &Found,
        k: usize,
        met: u32,
    ) -> u32 {
        if index > self.next {
            self.before = [self.now; 2];
        }
        self.next = index + 1;
        let falloff = f32x16::splat(simd, step.falloff);
        let in_nodes = f32x16::splat(simd, step.length / step.node);
        // What was written for other cones is of another part, or of cones that closed meanwhile.
        let (counts, zero) = (mask32x16::from_bitmask(simd, u64::from(met)), f32x16::splat(simd, 0.0));
        let sd = counts.select(f32x16::from_slice(simd, &found.sd[k].0), zero);
        let blocked = counts.select(f32x16::from_slice(simd, &found.blocked[k].0), zero);
        self.error += self.now * sd * in_nodes * falloff;
        let less = (blocked * self.before[1]).min(self.now);
        self.now -= less;
        self.before = [self.now, self.before[0]];
        self.closed += less * falloff;
        let closed = self.now.simd_lt(f32x16::splat(simd, CLOSED)).to_bitmask() as u32 & met;
        if closed != 0 {
            // The rest counts as closed; nothing is added to the others, 0 times a number.
            let (one, which) = (f32x16::splat(simd, 1.0), mask32x16::from_bitmask(simd, u64::from(closed)));
            self.closed += self.now * falloff * which.select(one, zero);
        }
        closed
    }

    /// Visibility and error of each.
    #[inline(always)]
    pub(super) fn store(self, simd: S, results: &mut [ConeResult]) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let [visibility, error] = store(&[(one - self.closed).max(zero).min(one), self.error]);
        for (result, (&visibility, &error)) in results.iter_mut().zip(visibility.0.iter().zip(&error.0)) {
            *result = ConeResult { visibility, error };
        }
    }
}
