//! Carrying out a plan in passes over all points, so that work stopped early still covers everything.

use crate::{Error, Outcome, Session, Work};
use conray_core::{Estimate, SurfacePoint};
use conray_estimate::{
    AoPlan, BackendError, Budget, Choice, Control, Ended, Explanation, Meter, Round, merge,
};
use std::{
    ops::Range,
    sync::atomic::{AtomicU64, Ordering},
};

/// Rays of the first pass: a quarter of a bundle, which costs little more than fewer would.
const FIRST_PASS: u32 = 16;
/// Rays of a pass at most, so that stopping is quick.
const LARGEST_PASS: u32 = 256;
/// Rays of a bundle: passes end where bundles do, those of the first few rays at a quarter.
const BUNDLE: u32 = 64;
/// Share of the time left that a pass may be foreseen to take.
const PLANNED: f64 = 0.97;

/// A device of somebody else's, which answers later.
#[cfg(feature = "gpu")]
pub(crate) type Elsewhere = conray_gpu::GpuBackend;
#[cfg(not(feature = "gpu"))]
pub(crate) type Elsewhere = std::convert::Infallible;

/// The next samples after `start`, none where the budget is spent: few first, then three times as many as all before, up to
/// [`LARGEST_PASS`]; no more than `wanted` in all, in whole bundles where the budget allows.
fn next_pass(start: u32, wanted: f64, most: u32) -> Option<Range<u32>> {
    let now = if start == 0 { FIRST_PASS } else { (3 * start).min(LARGEST_PASS) };
    let block = if start < BUNDLE { FIRST_PASS } else { BUNDLE };
    // The conversion holds infinity at the largest integer.
    let wanted = (wanted / f64::from(block)) as u32;
    let end = start.saturating_add(now).min(wanted.saturating_mul(block)).max(if start == 0 {
        FIRST_PASS
    } else {
        0
    });
    let end = end.min(most);
    (end > start).then_some(start..end)
}

impl Session {
    /// Estimates every point until the plan's budget is spent, telling of progress and stopping when asked to.
    ///
    /// Progress is told in thousandths of the budget, [`crate::PROGRESS_UNITS`] in all. Where time is the budget, one
    /// pass of 16 rays is the least that is done. Where a device fails, what was estimated by then is handed back with [`Work::failure`].
    ///
    /// # Errors
    /// What the backend lacks for the plan.
    pub fn run(&self, points: &[SurfacePoint], control: Control<'_>) -> Result<Outcome, Error> {
        self.run_within(&self.plan, points, control)
    }

    /// The same for another plan.
    pub(crate) fn run_within(
        &self,
        plan: &AoPlan,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Outcome, Error> {
        let budget = if plan.method.has_budget() { plan.budget } else { Budget::rays(1) };
        let meter = Meter::new(control, budget.seconds);
        let mut work = Passes { whole_only: false, ..Passes::of_whole_passes(points.len()) };
        let ended = pollster::block_on(self.passes_until(None, plan, &mut work, budget, points, &meter));
        let (ended, failure) = match ended {
            Err(Error::Backend(BackendError::Device(reason))) => (Ended::Failed, Some(reason)),
            ended => (ended?, None),
        };
        meter.finish();
        let reached = work.estimates.iter().filter(|e| !e.is_pending()).count() as u64;
        let cones = if plan.method.needs_octree() { reached * plan.cones.cones().len() as u64 } else { 0 };
        let done = Work {
            completed: !matches!(ended, Ended::Cancelled | Ended::Failed),
            ended,
            failure,
            expected_rmse: work.rmse(),
            seconds: meter.elapsed(),
            points: points.len() as u64,
            rays: work.estimates.iter().map(|e| u64::from(e.rays)).sum(),
            cones,
            explanation: plan.method.has_budget().then(|| work.explanation(&budget)),
        };
        Ok(Outcome { estimates: work.estimates, work: done })
    }

    /// Carries out passes until the budget is spent, and says what ended them. Rays of the budget are those of all passes, its seconds those of the
    /// meter. They are carried out where the session works, or elsewhere, and that alone is waited for.
    pub(crate) async fn passes_until(
        &self,
        elsewhere: Option<&Elsewhere>,
        plan: &AoPlan,
        work: &mut Passes,
        budget: Budget,
        points: &[SurfacePoint],
        meter: &Meter<'_>,
    ) -> Result<Ended, Error> {
        loop {
            let wanted = work.wanted(&budget, meter);
            if meter.control.is_cancelled() {
                return Ok(Ended::Cancelled);
            }
            if work.samples > 0 && budget.error.is_some_and(|goal| work.rmse() <= f64::from(goal)) {
                return Ok(Ended::Error);
            }
            let Some(range) = next_pass(work.samples, wanted, budget.rays) else {
                return Ok(match work.samples >= budget.rays {
                    true if !plan.method.has_budget() => Ended::Done,
                    true => Ended::Rays,
                    false => Ended::Time,
                });
            };
            self.pass(elsewhere, plan, work, range, wanted.min(budget.rays.into()), points, meter).await?;
        }
    }

    /// Carries out one pass and adds it to those before.
    #[expect(clippy::too_many_arguments, reason = "where, what, how far and how long")]
    async fn pass(
        &self,
        elsewhere: Option<&Elsewhere>,
        plan: &AoPlan,
        work: &mut Passes,
        range: Range<u32>,
        wanted: f64,
        points: &[SurfacePoint],
        meter: &Meter<'_>,
    ) -> Result<(), BackendError> {
        let (before, now) = (range.start, range.end - range.start);
        let mut found = vec![Estimate::PENDING; points.len()];
        let done = AtomicU64::new(0);
        let progress = |more: usize| {
            let done = more as u64 + done.fetch_add(more as u64, Ordering::Relaxed);
            let samples = f64::from(before) + f64::from(now) * done as f64 / points.len() as f64;
            meter.at(samples / wanted);
        };
        let control = Control { progress: &progress, ..meter.control };
        let told = match elsewhere {
            #[cfg(feature = "gpu")]
            Some(device) => device.estimate_later(plan, range, points, &mut found, control).await,
            _ => self.pool.install(|| self.backend.estimate(plan, range, points, &mut found, control)),
        };
        if work.whole_only && (told.is_err() || control.is_cancelled()) {
            return told;
        }
        for (all, pass) in work.estimates.iter_mut().zip(&found) {
            *all = merge(all, before, pass, now);
        }
        if told.is_ok() && !control.is_cancelled() {
            work.samples += now;
            let rays_per_point = work.samples.into();
            let (expected_rmse, seconds) = (work.rmse(), meter.elapsed());
            work.rounds.push(Round { rays_per_point, expected_rmse, seconds });
        }
        told
    }
}

/// Passes done so far.
#[derive(Debug)]
pub(crate) struct Passes {
    pub(crate) estimates: Vec<Estimate>,
    /// True where a pass that is interrupted leaves no trace, so that it can be done again.
    whole_only: bool,
    /// Samples of each point.
    samples: u32,
    rounds: Vec<Round>,
}

impl Passes {
    /// None yet, over so many points.
    pub(crate) fn of_whole_passes(points: usize) -> Self {
        Self { estimates: vec![Estimate::PENDING; points], whole_only: true, samples: 0, rounds: Vec::new() }
    }

    /// Samples a point at which time or error will be met, as far as can be told.
    fn wanted(&self, budget: &Budget, meter: &Meter<'_>) -> f64 {
        let Some(last) = self.rounds.last() else { return f64::INFINITY };
        let samples = f64::from(self.samples);
        let by_time = samples * (1.0 + PLANNED * meter.left() / last.seconds);
        // Errors of passes are added as independent ones, so what is expected falls with the square root.
        let by_error = |goal| {
            (samples * (last.expected_rmse / f64::from(goal)).powi(2)).max(samples + f64::from(BUNDLE))
        };
        let by_error = budget.error.map_or(f64::INFINITY, by_error);
        // Errors are met by going over, times by staying under.
        by_time.min((by_error / f64::from(FIRST_PASS)).ceil() * f64::from(FIRST_PASS))
    }

    /// Expected RMSE over the points that can be estimated.
    pub(crate) fn rmse(&self) -> f64 {
        let valid = self.estimates.iter().filter(|e| e.is_pending() || e.error.is_finite());
        let (sum, count) =
            valid.fold((0.0, 0u64), |(sum, count), e| (sum + f64::from(e.error).powi(2), count + 1));
        if count > 0 { (sum / count as f64).sqrt() } else { f64::INFINITY }
    }

    fn explanation(&self, budget: &Budget) -> Explanation {
        let points = self.estimates.iter().filter(|e| e.is_pending() || e.error.is_finite()).count() as u64;
        let last = self.rounds.last();
        Explanation {
            points,
            choice: Choice::Evenly,
            bundle_rays: BUNDLE,
            foreseen_rays: last.map_or(budget.rays.into(), |last| last.rays_per_point),
            ray_seconds: last.map(|last| last.seconds / (last.rays_per_point * points.max(1) as f64)),
            weighing_seconds: None,
            foreseen_rmse: None,
            rounds: self.rounds.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AoSettings, Method};
    use conray_estimate::Backend;
    use std::sync::Arc;

    /// Says that all is open, until it fails in the middle of a pass.
    struct Failing {
        calls: AtomicU64,
    }

    impl Backend for Failing {
        fn estimate(
            &self,
            _: &AoPlan,
            samples: Range<u32>,
            _: &[SurfacePoint],
            estimates: &mut [Estimate],
            _: Control<'_>,
        ) -> Result<(), BackendError> {
            let fails = self.calls.fetch_add(1, Ordering::Relaxed) > 0;
            let reached = if fails { estimates.len() / 2 } else { estimates.len() };
            let open =
                Estimate { visibility: 1.0, error: 0.1, rays: samples.len() as u32, ..Estimate::PENDING };
            estimates[..reached].fill(open);
            if fails { Err(BackendError::Device("lost".into())) } else { Ok(()) }
        }
    }

    #[test]
    fn a_device_that_fails_leaves_what_it_had_done() {
        let scene = conray_scene::builtin("cornell").unwrap();
        let settings = AoSettings { method: Method::Rays, rays: Some(64), ..AoSettings::default() };
        let mut session = Session::build(scene.geometry, &settings).unwrap();
        let points = [SurfacePoint::new(crate::Vec3::ZERO, crate::Vec3::Z); 8];
        let failing = |calls| Arc::new(Failing { calls: AtomicU64::new(calls) });
        session.backend = failing(0);
        let outcome = session.run(&points, Control::none()).unwrap();
        assert_eq!((outcome.work.ended, outcome.work.completed), (Ended::Failed, false));
        assert_eq!(outcome.work.failure.as_deref(), Some("lost"));
        let rays: Vec<u32> = outcome.estimates.iter().map(|e| e.rays).collect();
        assert_eq!(rays, [64, 64, 64, 64, 16, 16, 16, 16]);
        // Who asks for estimates alone is told.
        session.backend = failing(0);
        assert!(session.estimate(&points).is_err_and(|e| e.to_string() == "lost"));
        session.backend = failing(1);
        let outcome = session.run(&points, Control::none()).unwrap();
        assert_eq!(outcome.estimates.iter().filter(|e| e.is_pending()).count(), 4);
    }

    fn passes(wanted: f64, most: u32) -> Vec<Range<u32>> {
        let next = |range: &Range<u32>| next_pass(range.end, wanted, most);
        std::iter::successors(next_pass(0, wanted, most), next).collect()
    }

    #[test]
    fn passes_cover_every_sample_once_and_start_small() {
        for samples in [1, 3, 4, 5, 64, 100, 1000, 4096] {
            let ranges = passes(f64::INFINITY, samples);
            assert!(ranges[0].end <= 16);
            assert_eq!(ranges[0].start, 0);
            assert_eq!(ranges.last().unwrap().end, samples);
            assert!(ranges.windows(2).all(|w| w[0].end == w[1].start));
            assert!(ranges.iter().all(|r| r.end > r.start && r.end - r.start <= LARGEST_PASS));
        }
        assert_eq!(
            passes(f64::INFINITY, 600).iter().map(|r| r.end).collect::<Vec<_>>(),
            [16, 64, 256, 512, 600]
        );
    }

    #[test]
    fn passes_stop_at_whole_bundles_within_what_is_wanted() {
        let ends = |wanted| passes(wanted, 1 << 20).iter().map(|r| r.end).collect::<Vec<_>>();
        assert_eq!(ends(0.0), [16], "the least that can be done");
        assert_eq!(ends(47.0), [16, 32]);
        assert_eq!(ends(150.0), [16, 64, 128]);
    }
}
