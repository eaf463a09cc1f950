//! The samples of a part that meet something, sixteen side by side whichever cones and steps they belong to.

use super::{
    kernel::POINTS,
    lanes::{LANES, Lanes, load},
    nodes::Filters,
};
use crate::{
    Octree,
    compose::{CLEAR_CHANGE, UNKNOWN_SHARE},
    steps::{MOST_STEPS_OF_PART, Part, Step},
};
use fearless_simd::{Simd, f32x16, prelude::*};

/// What the cones find at the steps of a part; meaningless where they meet nothing.
pub(super) struct Found {
    /// Share of a cone that is blocked, at least 0.
    pub(super) blocked: [Lanes<f32>; MOST_STEPS_OF_PART],
    /// SD of opacities.
    pub(super) sd: [Lanes<f32>; MOST_STEPS_OF_PART],
}

impl Found {
    pub(super) const fn new() -> Self {
        let zero = [Lanes([0.0; LANES]); MOST_STEPS_OF_PART];
        Self { blocked: zero, sd: zero }
    }
}

/// Groups of sixteen that are collected before they are looked up.
const GROUPS: usize = 8;

/// Samples that are to be looked up.
pub(super) struct Samples {
    count: usize,
    groups: [Sixteen; GROUPS],
}

/// Sixteen samples.
struct Sixteen {
    /// In nodes of the coarser level.
    at: [Lanes<f32>; 3],
    axis: [Lanes<f32>; 3],
    share: Lanes<f32>,
    node: Lanes<f32>,
    length: Lanes<f32>,
    /// Which point, step of the part and cone each belongs to.
    owner: [[u8; 3]; LANES],
    /// On the finer level, and on the coarser one.
    filters: [Filters; 2],
}

impl Samples {
    pub(super) const fn new() -> Self {
        Self { count: 0, groups: [const { Sixteen::new() }; GROUPS] }
    }

    /// Adds the sample of a cone at a step, with the number of its point, that of the step in its part and the cone's; true when
    /// there is no room for another.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        step: &Step,
        owner: (usize, usize, usize),
        at: &[Lanes<f32>; 3],
        axis: &[Lanes<f32>; 3],
    ) -> bool {
        let (group, n, lane) =
            (&mut self.groups[self.count / LANES % GROUPS], self.count % LANES, owner.2 % LANES);
        for axes in 0..3 {
            group.at[axes].0[n] = at[axes].0[lane];
            group.axis[axes].0[n] = axis[axes].0[lane];
        }
        group.share.0[n] = step.share;
        group.node.0[n] = step.node;
        group.length.0[n] = step.length;
        group.owner[n] = [owner.0 as u8, owner.1 as u8, lane as u8];
        self.count += 1;
        self.count == GROUPS * LANES
    }

    /// Looks up what there is, and begins anew.
    #[inline(always)]
    pub(super) fn look_up<S: Simd>(
        &mut self,
        simd: S,
        octree: &Octree,
        part: &Part,
        found: &mut [Found; POINTS],
    ) {
        let groups = self.count.div_ceil(LANES).min(GROUPS);
        let numbers = [part.level, part.coarse];
        let levels = if part.coarse > part.level { 2 } else { 1 };
        for group in &mut self.groups[..groups] {
            let at = load(simd, &group.at);
            for (filters, &number) in group.filters.iter_mut().zip(&numbers).take(levels) {
                filters.place(simd, &octree.levels[number], &at, part.coarse - number);
            }
        }
        for (g, group) in self.groups[..groups].iter_mut().enumerate() {
            let count = (self.count - g * LANES).min(LANES);
            for (filters, &number) in group.filters.iter_mut().zip(&numbers).take(levels) {
                filters.read(&octree.levels[number], count);
            }
        }
        for (g, group) in self.groups[..groups].iter().enumerate() {
            let count = (self.count - g * LANES).min(LANES);
            group.store(simd, part, count, found);
        }
        self.count = 0;
    }
}

impl Sixteen {
    const fn new() -> Self {
        let zero = Lanes([0.0; LANES]);
        Self {
            at: [zero; 3],
            axis: [zero; 3],
            share: zero,
            node: zero,
            length: zero,
            owner: [[0; 3]; LANES],
            filters: [const { Filters::new() }; 2],
        }
    }

    /// What the first `count` samples found.
    #[inline(always)]
    fn store<S: Simd>(&self, simd: S, part: &Part, count: usize, found: &mut [Found; POINTS]) {
        let mut slope = self.filters[0].slopes(simd, part.level);
        if part.coarse > part.level {
            let share = f32x16::from_slice(simd, &self.share.0);
            slope = slope.lerp(self.filters[1].slopes(simd, part.coarse), share);
        }
        let node = f32x16::from_slice(simd, &self.node.0);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let unknown = f32x16::splat(simd, UNKNOWN_SHARE);
        // `met_share` and `blocked_by`, sixteen times.
        let (x, y, z) = (slope.gradient[0] * node, slope.gradient[1] * node, slope.gradient[2] * node);
        let largest = x.abs().max(y.abs()).max(z.abs());
        let clear = (largest / (f32x16::splat(simd, CLEAR_CHANGE) * slope.mean)).min(one);
        let axis = load(simd, &self.axis);
        let dot = x * axis[0] + y * axis[1] + z * axis[2];
        let known = clear * (dot.abs() / largest) + (one - clear) * unknown;
        let share = largest.simd_le(zero).select(unknown, known);
        let blocked = slope.mean * f32x16::from_slice(simd, &self.length.0) * share;
        let (mut blocks, mut sds) = (Lanes([0.0; LANES]), Lanes([0.0; LANES]));
        blocked.store_slice(&mut blocks.0);
        slope.sd.store_slice(&mut sds.0);
        for n in 0..count.min(LANES) {
            let [point, k, lane] = self.owner[n].map(usize::from);
            let (found, k, lane) = (&mut found[point % POINTS], k % MOST_STEPS_OF_PART, lane % LANES);
            found.blocked[k].0[lane] = blocks.0[n];
            found.sd[k].0[lane] = sds.0[n];
        }
    }
}
