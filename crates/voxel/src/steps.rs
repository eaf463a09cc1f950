//! Where a march samples: distances that depend on the cones' aperture alone, so that all cones of a set share them.

use crate::{MarchOptions, Octree};
use conray_core::{Falloff, Vec3};
use std::ops::Range;

/// One sample of a march; lengths in leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    /// The finer of the two levels that are sampled.
    pub(crate) level: usize,
    /// Weight of the next coarser level, in [0, 1).
    pub(crate) share: f32,
    /// Edge of the sampled node; between levels, of the node that would be there.
    pub(crate) node: f32,
    /// What the sample stands for along the axis: ends at the AO distance.
    pub(crate) length: f32,
    /// Distance of the sample from the apex along the axis.
    pub(crate) middle: f32,
    /// Least height of the sample above the tangent plane.
    pub(crate) lift: f32,
    /// Weight of what is met here.
    pub(crate) falloff: f32,
}

impl Step {
    /// The coarser of the levels that are sampled: its filter holds that of the finer one.
    #[inline]
    pub(crate) fn coarse(&self) -> usize {
        self.level + usize::from(self.share > 0.0)
    }

    /// Position of the sample of a cone that gains the height `rise` per length.
    ///
    /// The set kernel computes the same in the same order, so that its bits are the same.
    #[inline]
    pub(crate) fn position(&self, apex: Vec3, axis: Vec3, normal: Vec3, rise: f32) -> Vec3 {
        let lift = (self.lift - self.middle * rise).max(0.0);
        apex + axis * self.middle + normal * lift
    }
}

/// More steps than a cone takes that crosses the finest octree; ends the march from absurd places.
const MOST_STEPS: u32 = 1 << 15;

/// The steps of a march, one by one.
pub(crate) struct Steps {
    /// Node edge per length.
    spread: f32,
    step: f32,
    lift: f32,
    distance: f32,
    falloff: Falloff,
    top: f32,
    t: f32,
    end: f32,
    left: u32,
}

impl Steps {
    /// The steps of a cone whose apex, in leaves, is `outside` the cube by so much.
    pub(crate) fn new(
        octree: &Octree,
        half_angle_rad: f32,
        distance: f32,
        falloff: Falloff,
        options: &MarchOptions,
        outside: f32,
    ) -> Self {
        let spread = 2.0 * half_angle_rad.clamp(0.0, 1.5).tan() * options.width.max(0.0);
        // A sample at t is no farther from the apex than t and its lift, so none before this is in the cube.
        let start = (outside - options.lift) / (1.0 + options.lift * spread);
        let diagonal = 1.732_051 * octree.resolution() as f32;
        let distance = distance / octree.voxel_size();
        Self {
            spread,
            step: options.step.clamp(0.1, 4.0),
            lift: options.lift,
            distance,
            falloff,
            top: octree.levels() as f32 - 1.0,
            t: start.max(0.0),
            end: distance.min(outside + diagonal),
            left: MOST_STEPS,
        }
    }
}

impl Iterator for Steps {
    type Item = Step;

    #[inline]
    fn next(&mut self) -> Option<Step> {
        if self.t >= self.end || self.left == 0 {
            return None;
        }
        self.left -= 1;
        let level = (self.spread * self.t).max(1.0).log2().min(self.top);
        let node = level.exp2();
        let length = self.step * node;
        // A step is not shortened where it is sampled, so that a longer distance never opens a cone.
        let middle = self.t + 0.5 * length;
        let step = Step {
            level: level as usize,
            share: level.fract(),
            node,
            length: length.min(self.end - self.t),
            middle,
            lift: self.lift * node,
            falloff: self.falloff.weight(middle / self.distance),
        };
        self.t += length;
        Some(step)
    }
}

/// The most steps of a part: those of a march with the default options among the leaves, and more than those of a level.
pub(crate) const MOST_STEPS_OF_PART: usize = 6;

/// Steps in a row on the same levels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    /// Which steps of the plan.
    pub(crate) steps: Range<usize>,
    /// The finer level.
    pub(crate) level: usize,
    /// The coarser one, or the same.
    pub(crate) coarse: usize,
}

/// All steps of a march, in parts.
#[derive(Clone, Debug)]
pub(crate) struct MarchPlan {
    pub(crate) steps: Vec<Step>,
    pub(crate) parts: Vec<Part>,
}

impl MarchPlan {
    pub(crate) fn new(steps: Steps) -> Self {
        let steps: Vec<_> = steps.collect();
        let mut parts: Vec<Part> = vec![];
        for (index, step) in steps.iter().enumerate() {
            let (level, coarse) = (step.level, step.coarse());
            match parts.last_mut() {
                Some(part)
                    if (part.level, part.coarse) == (level, coarse)
                        && part.steps.len() < MOST_STEPS_OF_PART =>
                {
                    part.steps.end = index + 1;
                }
                _ => parts.push(Part { steps: index..index + 1, level, coarse }),
            }
        }
        Self { steps, parts }
    }
}
