//! Progress in thousandths of a budget, whatever the budget counts.

use crate::Control;
use std::sync::atomic::{AtomicU64, Ordering};
use web_time::Instant;

/// Units of progress of a whole budget.
pub const PROGRESS_UNITS: u64 = 1000;

/// Tells a caller how much of a budget is spent: never backwards, and all of it at the end.
pub struct Meter<'a> {
    /// Whom to tell, and who may stop the work.
    pub control: Control<'a>,
    start: Instant,
    seconds: Option<f64>,
    told: AtomicU64,
}

impl<'a> Meter<'a> {
    /// Starts the clock, for at most so many seconds.
    pub fn new(control: Control<'a>, seconds: Option<f64>) -> Self {
        Self { control, start: Instant::now(), seconds, told: AtomicU64::new(0) }
    }

    /// Seconds since the start.
    pub fn elapsed(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Seconds of the budget that are left, not below 0; infinite without a limit.
    pub fn left(&self) -> f64 {
        self.seconds.map_or(f64::INFINITY, |seconds| (seconds - self.elapsed()).max(0.0))
    }

    /// A share of the other budgets is spent; of time, what the clock says.
    pub fn at(&self, share: f64) {
        let of_time = self.seconds.map_or(0.0, |seconds| self.elapsed() / seconds);
        // The end is told once, by `finish`.
        let share = share.max(of_time).clamp(0.0, 0.999);
        self.tell((share * PROGRESS_UNITS as f64) as u64);
    }

    /// The work is over; where it was stopped, progress stays where it was.
    pub fn finish(&self) {
        if !self.control.is_cancelled() {
            self.tell(PROGRESS_UNITS);
        }
    }

    fn tell(&self, units: u64) {
        let before = self.told.fetch_max(units, Ordering::Relaxed);
        if units > before {
            (self.control.progress)((units - before) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn it_never_goes_back_and_ends_at_the_whole() {
        let (told, cancelled) = (AtomicU64::new(0), AtomicBool::new(false));
        let progress = |units: usize| {
            told.fetch_add(units as u64, Ordering::Relaxed);
        };
        let meter = Meter::new(Control { cancelled: &cancelled, progress: &progress }, None);
        for (share, units) in [(0.1, 100), (0.05, 100), (0.5, 500), (7.0, 999), (f64::NAN, 999)] {
            meter.at(share);
            assert_eq!(told.load(Ordering::Relaxed), units, "{share}");
        }
        assert_eq!(meter.left(), f64::INFINITY);
        meter.finish();
        assert_eq!(told.load(Ordering::Relaxed), PROGRESS_UNITS);
    }

    #[test]
    fn a_spent_clock_is_progress_and_a_stopped_one_does_not_end_it() {
        let (told, cancelled) = (AtomicU64::new(0), AtomicBool::new(true));
        let progress = |units: usize| {
            told.fetch_add(units as u64, Ordering::Relaxed);
        };
        let meter = Meter::new(Control { cancelled: &cancelled, progress: &progress }, Some(1e-9));
        while meter.left() > 0.0 {}
        meter.at(0.0);
        meter.finish();
        assert_eq!(told.load(Ordering::Relaxed), 999);
    }
}
