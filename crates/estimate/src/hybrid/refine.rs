//! Rounds of rays until a budget is spent.

use super::{
    Hybrid, HybridDevice, Order, UNIT, bundles, choose,
    columns::PART,
    tallies::Tally,
    weighing::{OnDevice, Weighed},
};
use crate::{AoPlan, Budget, Choice, Control, Ended, Meter, Round};
use conray_bvh::Bvh;
use conray_core::SurfacePoint;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use web_time::Instant;

/// Below a unit of rays for so many points it is early.
const EARLY: u64 = 8;
/// A round costs some time of its own: none for less than one part in so many.
const WORTHWHILE: u64 = 50;

/// Orders that a thread carries out before it looks at the clock: stopping is quick, and looking costs little.
const CHUNK: usize = 64;

/// All that a round needs besides the work so far.
pub(super) struct Work<'a> {
    pub(super) plan: &'a AoPlan,
    pub(super) bvh: &'a Bvh,
    /// Where bundles are traced; on the CPU where it is none.
    pub(super) device: Option<&'a dyn HybridDevice>,
    /// Where they are weighed.
    pub(super) weigher: OnDevice<'a>,
    pub(super) points: &'a [SurfacePoint],
    pub(super) budget: Budget,
    pub(super) meter: &'a Meter<'a>,
}

/// Units of rays of the next round, of those left. Late rounds choose better, early ones cost more than their rays.
fn this_round(had: u64, left: u64, points: u64) -> u64 {
    let much = if EARLY * had < points { 4 * had } else { 2 * had };
    if left > much { had.max(left.div_ceil(3)) } else { left }
}

impl Hybrid {
    /// Adds rays, in rounds, until the budget is spent, and says what ended it; stops within a round when cancelled. Rays of the
    /// budget are those of all calls together, its seconds those of this call, with the answers of [`Hybrid::estimates`].
    ///
    /// `points` are those that the work began with. Progress is told in thousandths ([`crate::PROGRESS_UNITS`]). The result depends
    /// on the plan, the points and the budgets so far, not on threads; with seconds it depends on the clock. What an
    /// interrupted round found counts in the estimates at once, and the next call goes on with that round: in the end the bits
    /// are those of work that was never interrupted.
    ///
    /// # Panics
    /// If there are fewer points than the work began with.
    pub fn refine(
        &mut self,
        plan: &AoPlan,
        bvh: &Bvh,
        points: &[SurfacePoint],
        budget: Budget,
        control: Control<'_>,
    ) -> Ended {
        self.refine_on(None, plan, bvh, points, budget, control)
    }

    /// The same with rays traced and weighed on a device: where that fails it says so ([`Ended::Failed`], [`Hybrid::failure`]), and what it had found
    /// is as that of an interrupted round.
    ///
    /// # Panics
    /// As [`Hybrid::refine`].
    pub fn refine_on(
        &mut self,
        device: Option<&dyn HybridDevice>,
        plan: &AoPlan,
        bvh: &Bvh,
        points: &[SurfacePoint],
        budget: Budget,
        control: Control<'_>,
    ) -> Ended {
        let meter = Meter::new(control, budget.seconds);
        self.failure = None;
        let weigher = self.weigher_on(device);
        let ended = self.rounds_until(&Work { plan, bvh, device, weigher, points, budget, meter: &meter });
        meter.finish();
        if self.failure.is_some() { Ended::Failed } else { ended }
    }

    fn rounds_until(&mut self, work: &Work<'_>) -> Ended {
        let control = work.meter.control;
        if self.covered == 0 {
            return Ended::Done;
        }
        if work.budget.seconds.is_some() && !control.is_cancelled() {
            self.time_rays(work);
        }
        // An interrupted round is gone on with by what was known when it began, and known where it goes on: devices round as they do.
        let known_elsewhere = self.known_on_device != work.weigher.is_some() && self.choice == Choice::Hybrid;
        if self.started && (known_elsewhere || self.known_of_unfinished) && !control.is_cancelled() {
            self.weigh(&work.weigher, work.bvh.level(), Weighed::WholeRounds);
        }
        loop {
            if control.is_cancelled() || self.failure.is_some() {
                return Ended::Cancelled;
            }
            if work.budget.error.is_some_and(|goal| self.started && self.expected_rmse() <= f64::from(goal)) {
                return Ended::Error;
            }
            self.foreseen = self.foresee(work);
            if !self.started || self.outgrown(work) {
                self.begin(work);
                continue;
            }
            if !self.round(work) {
                let timed = work.budget.seconds.is_some();
                return match control.is_cancelled() {
                    true => Ended::Cancelled,
                    false if timed && self.foreseen < f64::from(work.budget.rays) => Ended::Time,
                    false => Ended::Rays,
                };
            }
        }
    }

    /// The lattice, anew where there was one in smaller bundles.
    fn begin(&mut self, work: &Work<'_>) {
        if self.started {
            self.begun_anew = Some(self.rounds.len());
            self.pilot_rays = self.rays_of_rounds();
            self.tallies.fill(Tally::default());
            self.units = 0;
            self.started = false;
        }
        self.start(work, self.foreseen);
        self.weigh_shown(work, self.started);
        self.note(work);
        if work.budget.seconds.is_some() && self.started {
            self.choose_method(work);
        }
    }

    /// One round; false where nothing worthwhile is left to do, or it was stopped.
    fn round(&mut self, work: &Work<'_>) -> bool {
        let until = work.meter.elapsed() + work.meter.left() - self.tail_seconds();
        if self.choice == Choice::Evenly {
            let more = work.meter.elapsed() < until && self.level(work, until);
            if more {
                self.note(work);
            }
            return more;
        }
        let unit = u64::from(UNIT);
        let goal = (self.foreseen * self.covered as f64 / unit as f64).round() as u64;
        let had = self.rays_of_rounds() / unit;
        let left = goal.saturating_sub(had);
        if left * WORTHWHILE <= goal {
            return false;
        }
        let mut now = this_round(had, left, self.covered).max(u64::from(self.rays.first));
        if work.meter.left() < 5.0 * self.tail_seconds() {
            // Another weighing would take more than it gives.
            now = left;
        }
        let Self { constants, pixels, tallies, known, rays, units, .. } = &*self;
        let orders = choose::choose(constants, pixels, tallies, known, rays, *units, now);
        if orders.is_empty() {
            return false;
        }
        let whole = self.trace(work, &orders, until);
        self.weigh_shown(work, whole);
        self.note(work);
        whole
    }

    /// Weighs what is shown, but for what an interrupted round found where nobody looks at it.
    fn weigh_shown(&mut self, work: &Work<'_>, is_whole: bool) {
        if is_whole || !self.weighs_later || self.failure.is_some() {
            self.weigh(&work.weigher, work.bvh.level(), Weighed::Shown);
        }
    }

    /// Keeps what a whole round came to.
    fn note(&mut self, work: &Work<'_>) {
        if work.budget.seconds.is_some() {
            self.time_answers();
        }
        if self.unfinished.is_empty() && self.started {
            let (rays_per_point, expected_rmse) = (self.rays_per_point(), self.expected_rmse());
            self.rounds.push(Round { rays_per_point, expected_rmse, seconds: work.meter.elapsed() });
        }
    }

    /// Carries out orders, which stand in the order of their places, but for those that an interrupted round did; false where they were
    /// interrupted again. What is not reached until that many seconds of the clock is left out.
    pub(super) fn trace(&mut self, work: &Work<'_>, orders: &[Order], until: f64) -> bool {
        debug_assert!(orders.is_sorted_by_key(|order| order.at));
        let start = Instant::now();
        let done_before = std::mem::take(&mut self.unfinished);
        let (before, all) = (self.rays_of_rounds(), self.foreseen * self.covered as f64);
        let traced = AtomicU64::new(0);
        let told = |units: u64| {
            let new = units * u64::from(UNIT);
            let traced = new + traced.fetch_add(new, Ordering::Relaxed);
            work.meter.at((before + traced) as f64 / all);
        };
        let done = |order: &Order| {
            let done = done_before.get(order.at as usize)?;
            (done.units == order.units).then_some(*done)
        };
        let left: Vec<Order> = orders.iter().filter(|order| done(order).is_none()).copied().collect();
        let new = match work.device {
            None => self.trace_here(work, &left, until, told),
            Some(device) => self.trace_on(device, work, &left, until, told),
        };
        let mut new = new.into_iter();
        let found: Vec<Tally> =
            orders.iter().map(|order| done(order).or_else(|| new.next()).unwrap_or_default()).collect();
        let (control, failed) = (work.meter.control, self.failure.is_some());
        let traced = traced.into_inner();
        if traced > 0 {
            self.costs.ray_seconds = Some(start.elapsed().as_secs_f64() / traced as f64);
        }
        let whole = !(control.is_cancelled() || failed) || found.iter().all(|found| found.units > 0);
        if whole {
            self.units += found.iter().map(|found| u64::from(found.units)).sum::<u64>();
        } else {
            self.unfinished = vec![Tally::default(); self.pixels.len()];
        }
        let kept = if whole { &mut self.tallies } else { &mut self.unfinished };
        kept.par_chunks_mut(PART).enumerate().for_each(|(part, kept)| {
            let from = |place: usize| orders.partition_point(|order| (order.at as usize) < place);
            let these = from(part * PART)..from((part + 1) * PART);
            for (order, found) in orders[these.clone()].iter().zip(&found[these]) {
                kept[order.at as usize % PART].merge(found);
            }
        });
        whole
    }

    /// Carries out orders on the CPU: the tallies, empty past where it was stopped.
    fn trace_here(
        &self,
        work: &Work<'_>,
        orders: &[Order],
        until: f64,
        told: impl Fn(u64) + Sync,
    ) -> Vec<Tally> {
        let mut found = vec![Tally::default(); orders.len()];
        let chunks = orders.par_chunks(CHUNK).zip(found.par_chunks_mut(CHUNK));
        chunks.for_each(|(orders, found)| {
            let late = until < f64::INFINITY && work.meter.elapsed() > until;
            if late || work.meter.control.is_cancelled() {
                return told(0);
            }
            for (order, found) in orders.iter().zip(&mut *found) {
                let at = order.at as usize;
                let (point, had) = (self.pixels.point[at] as usize, self.tallies[at].units);
                let units = had..had + order.units;
                *found = bundles::trace(work.plan, work.bvh, &work.points[point], units, 0);
            }
            told(found.iter().map(|found| u64::from(found.units)).sum());
        });
        found
    }
}
