//! What a surface blocks of a cone, and how surfaces along a cone compose.

use crate::{ConeResult, steps::Step};
use conray_core::Vec3;

/// Where less than this passes, the rest counts as closed.
pub(crate) const CLOSED: f32 = 1e-3;

/// Where the mean changes across a node by less than this share of itself, its direction is noise.
pub(crate) const CLEAR_CHANGE: f32 = 0.25;

/// [`met_share`] in the mean over surfaces of any direction: the cosine at which lines meet them is 2/3 in the mean (that of
/// cos^2 over that of cos), and the largest component of a unit normal 0.83.
pub(crate) const UNKNOWN_SHARE: f32 = 0.8;

/// How much of the mean opacity along a line counts, by the angle at which the line meets the surface, in [0, sqrt 3].
///
/// A leaf's opacity is its surface's area times the largest component of the normal `n`, and a line in direction `d` crosses
/// the area times `|n . d|`. Opacity falls off from a surface on both sides, so its gradient lies along the normal.
/// Without this a wall met at a grazing angle would count many times over. `change` is the gradient times the edge of
/// the sampled node.
#[inline]
pub(crate) fn met_share(mean: f32, change: Vec3, axis: Vec3) -> f32 {
    let largest = change.abs().max_element();
    if largest <= 0.0 {
        return UNKNOWN_SHARE;
    }
    let clear = (largest / (CLEAR_CHANGE * mean)).min(1.0);
    clear * (change.dot(axis).abs() / largest) + (1.0 - clear) * UNKNOWN_SHARE
}

/// Share of a cone that passes, step by step.
///
/// What two steps in a row block adds up, since the filter smears one surface over them; what lies farther apart
/// composes: it blocks its share of what passed before those two steps.
pub(crate) struct Passing {
    now: f32,
    /// After the last step, and after the one before.
    before: [f32; 2],
}

impl Passing {
    /// All passes.
    pub(crate) const ALL: Self = Self { now: 1.0, before: [1.0; 2] };

    /// What passes, in [0, 1].
    #[inline]
    pub(crate) fn share(&self) -> f32 {
        self.now
    }

    /// Ends one or more steps that block nothing.
    #[inline]
    pub(crate) fn pause(&mut self) {
        self.before = [self.now; 2];
    }

    /// Ends a step that blocks the share `blocked` >= 0 of what reaches it; returns how much less passes.
    #[inline]
    pub(crate) fn step(&mut self, blocked: f32) -> f32 {
        let less = (blocked * self.before[1]).min(self.now);
        self.now -= less;
        self.before = [self.now, self.before[0]];
        less
    }
}

/// What a cone has met so far.
pub(crate) struct Composition {
    passing: Passing,
    closed: f32,
    error: f32,
    /// The step after the last one that met something.
    next: usize,
}

impl Composition {
    /// Nothing yet.
    pub(crate) const OPEN: Self = Self { passing: Passing::ALL, closed: 0.0, error: 0.0, next: 0 };

    /// Adds step number `index`, which blocks the share `blocked` of what reaches it and where the SD is `sd`; steps left
    /// out between meet nothing. True where too little passes to go on.
    #[inline]
    pub(crate) fn add(&mut self, index: usize, step: &Step, blocked: f32, sd: f32) -> bool {
        if index > self.next {
            self.passing.pause();
        }
        self.next = index + 1;
        self.error += self.passing.share() * sd * (step.length / step.node) * step.falloff;
        self.closed += self.passing.step(blocked) * step.falloff;
        let is_closed = self.passing.share() < CLOSED;
        if is_closed {
            self.closed += self.passing.share() * step.falloff;
        }
        is_closed
    }

    /// Visibility and error.
    pub(crate) fn result(&self) -> ConeResult {
        let visibility = if self.closed == 0.0 { 1.0 } else { (1.0 - self.closed).clamp(0.0, 1.0) };
        ConeResult { visibility, error: self.error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(steps: &[f32]) -> f32 {
        let mut passing = Passing::ALL;
        let less: f32 = steps.iter().map(|&s| passing.step(s)).sum();
        assert!((less - (1.0 - passing.share())).abs() < 1e-6);
        passing.share()
    }

    #[test]
    fn one_surface_adds_and_two_compose() {
        // However a surface falls onto the steps, it blocks what it blocks.
        for part in [0.0, 0.2, 0.5, 0.9] {
            assert!((through(&[0.0, part * 0.6, (1.0 - part) * 0.6, 0.0]) - 0.4).abs() < 1e-6);
            assert!(through(&[part, 1.0 - part]) < 1e-6);
        }
        assert!((through(&[0.6, 0.0, 0.5]) - 0.2).abs() < 1e-6);
        assert_eq!(through(&[3.0, 3.0]), 0.0);
    }

    #[test]
    fn the_gradient_tells_the_angle_and_noise_does_not() {
        let axis = Vec3::new(0.6, 0.0, 0.8);
        assert!((met_share(0.5, Vec3::new(0.0, 0.0, -0.4), axis) - 0.8).abs() < 1e-6);
        assert!((met_share(0.5, Vec3::new(0.3, 0.0, -0.3), axis) - 0.2).abs() < 1e-6);
        assert_eq!(met_share(0.5, Vec3::ZERO, axis), UNKNOWN_SHARE);
        assert!((met_share(0.5, Vec3::X * 1e-6, axis) - UNKNOWN_SHARE).abs() < 1e-4);
    }
}
