//! The march of the cones of some points, sixteen of each, that share their steps.

use super::{
    asked::{Asked, ask},
    lanes::{Bits, Fan, LANES, Lanes, LocalAxes, store},
    passage::Passage,
    paths::Paths,
    samples::{Found, Samples},
};
use crate::{
    ConeResult, Octree,
    steps::{MarchPlan, Part},
};
use fearless_simd::Simd;

/// Points that are marched together: their samples fill vectors that those of one would leave half empty.
pub(super) const POINTS: usize = 8;

/// Sixteen cones of each of some points.
pub(super) struct Group<'a> {
    pub(super) octree: &'a Octree,
    pub(super) plan: &'a MarchPlan,
    /// Where to march from, at most [`POINTS`]; `None` for points that are left out.
    pub(super) fans: &'a [Option<Fan>],
    pub(super) axes: &'a LocalAxes,
}

/// What a march writes down. Lanes that nothing was written to may be read, but what comes of them counts for nothing.
pub(super) struct Scratch {
    asked: [Asked; POINTS],
    axis: [[Lanes<f32>; 3]; POINTS],
    samples: Samples,
    found: [Found; POINTS],
}

impl Scratch {
    pub(super) const fn new() -> Self {
        Self {
            asked: [const { Asked::new() }; POINTS],
            axis: [[Lanes([0.0; LANES]); 3]; POINTS],
            samples: Samples::new(),
            found: [const { Found::new() }; POINTS],
        }
    }
}

impl Group<'_> {
    /// Marches the cones of all points; lanes without a cone, and points that are left out, are open.
    #[inline(always)]
    pub(super) fn march<S: Simd>(
        &self,
        simd: S,
        scratch: &mut Scratch,
        results: &mut [[ConeResult; LANES]; POINTS],
    ) {
        // Loops in place of closures, which do not always become part of code for a level of SIMD.
        let mut active = [0; POINTS];
        let mut paths = [Paths::new(simd, &Fan::NOWHERE, self.axes); POINTS];
        let mut passages = [Passage::open(simd); POINTS];
        let count = self.fans.len().min(POINTS);
        for p in 0..count {
            if let Some(fan) = &self.fans[p] {
                active[p] = self.axes.all;
                paths[p] = Paths::new(simd, fan, self.axes);
                scratch.axis[p] = store(&paths[p].axis);
            }
        }
        for part in &self.plan.parts {
            let (steps, coarser) = (&self.plan.steps[part.steps.clone()], &self.octree.levels[part.coarse]);
            ask(simd, &mut scratch.asked[..count], coarser, part.coarse, steps, &paths[..count]);
            self.look_up(simd, part, &active, scratch);
            for p in 0..POINTS {
                for (k, step) in steps.iter().enumerate() {
                    let met = scratch.asked[p].met[k] & active[p];
                    if met != 0 {
                        let (index, found) = (part.steps.start + k, &scratch.found[p]);
                        active[p] &= !passages[p].add(simd, index, step, found, k, met);
                    }
                }
            }
            if active == [0; POINTS] {
                break;
            }
        }
        for p in 0..POINTS {
            passages[p].store(simd, &mut results[p]);
        }
    }

    /// Looks up what the `active` cones meet in a part.
    #[inline(always)]
    fn look_up<S: Simd>(&self, simd: S, part: &Part, active: &[u32; POINTS], scratch: &mut Scratch) {
        let Scratch { asked, axis, samples, found } = scratch;
        let steps = &self.plan.steps[part.steps.clone()];
        for p in 0..POINTS {
            for (k, step) in steps.iter().enumerate() {
                for lane in Bits(asked[p].met[k] & active[p]) {
                    if samples.add(step, (p, k, lane), &asked[p].at[k], &axis[p]) {
                        samples.look_up(simd, self.octree, part, found);
                    }
                }
            }
        }
        samples.look_up(simd, self.octree, part, found);
    }
}
