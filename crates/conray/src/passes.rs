//! Carrying out a plan in passes over all points, so that work stopped early still covers everything.

use crate::{Error, Session};
use conray_core::{Estimate, SurfacePoint};
use conray_estimate::{Backend, Control, merge};
use std::{ops::Range, time::Instant};

/// What became of the points.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// One per point, in order; pending where the work was stopped before it reached the point.
    pub estimates: Vec<Estimate>,
    /// False where the work was stopped early.
    pub completed: bool,
    /// Wall-clock time of the estimation alone.
    pub seconds: f64,
    /// Rays traced.
    pub rays: u64,
    /// Cones marched.
    pub cones: u64,
}

/// Rays of the first pass: a quarter of a bundle, which costs little more than fewer would.
const FIRST_PASS: u32 = 16;
/// Rays of a pass at most, so that stopping is quick.
const LARGEST_PASS: u32 = 256;

/// Ranges of samples: few first, then three times as many as all before, up to [`LARGEST_PASS`], so that the ranges end
/// where bundles of 64 do.
///
/// The ranges depend on the number of samples alone, so results are the same bits wherever they are computed.
fn passes(samples: u32) -> impl Iterator<Item = Range<u32>> {
    let mut start = 0;
    std::iter::from_fn(move || {
        (start < samples).then(|| {
            let now = if start == 0 { FIRST_PASS } else { (3 * start).min(LARGEST_PASS) };
            let end = (start + now).min(samples);
            std::mem::replace(&mut start, end)..end
        })
    })
}

impl Session {
    /// Estimates every point, telling of progress and stopping when asked to.
    ///
    /// Progress counts points times samples, [`Session::work`] in all.
    ///
    /// # Errors
    /// What the backend lacks for the plan.
    pub fn run(&self, points: &[SurfacePoint], control: Control<'_>) -> Result<Outcome, Error> {
        let start = Instant::now();
        let mut estimates = vec![Estimate::PENDING; points.len()];
        let mut pass_estimates = estimates.clone();
        for range in passes(self.plan.samples()) {
            let (before, now) = (range.start, range.end - range.start);
            let progress = |points: usize| (control.progress)(points * now as usize);
            let pass_control = Control { progress: &progress, ..control };
            pass_estimates.fill(Estimate::PENDING);
            self.pool.install(|| {
                self.backend.estimate(&self.plan, range, points, &mut pass_estimates, pass_control)
            })?;
            for (all, pass) in estimates.iter_mut().zip(&pass_estimates) {
                *all = merge(all, before, pass, now);
            }
            if control.is_cancelled() {
                break;
            }
        }
        let reached = estimates.iter().filter(|e| !e.is_pending()).count() as u64;
        let marches_cones = self.plan.method.needs_octree();
        Ok(Outcome {
            completed: !control.is_cancelled(),
            seconds: start.elapsed().as_secs_f64(),
            rays: estimates.iter().map(|e| u64::from(e.rays)).sum(),
            cones: if marches_cones { reached * self.plan.cones.cones().len() as u64 } else { 0 },
            estimates,
        })
    }

    /// Units of progress that [`Session::run`] will report for that many points.
    pub fn work(&self, points: usize) -> u64 {
        points as u64 * u64::from(self.plan.samples())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_cover_every_sample_once_and_start_small() {
        for samples in [1, 3, 4, 5, 64, 100, 1000, 4096] {
            let ranges: Vec<_> = passes(samples).collect();
            assert!(ranges[0].end <= 16);
            assert_eq!(ranges[0].start, 0);
            assert_eq!(ranges.last().unwrap().end, samples);
            assert!(ranges.windows(2).all(|w| w[0].end == w[1].start));
            assert!(ranges.iter().all(|r| r.end > r.start && r.end - r.start <= LARGEST_PASS));
        }
        assert_eq!(passes(600).map(|r| r.end).collect::<Vec<_>>(), [16, 64, 256, 512, 600]);
    }
}
