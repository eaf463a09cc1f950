//! Time and progress shared out between parts of some work: portions of maps, or objects of a portion.

use conray::{Budget, Control, PROGRESS_UNITS};
use std::sync::atomic::{AtomicU64, Ordering};

/// What of the budget and of the progress belongs to each part of some work.
pub(crate) struct Shares {
    budget: Budget,
    /// About how much there is to do in each.
    weights: Vec<f64>,
    done: usize,
    told: u64,
}

impl Shares {
    pub(crate) fn new(weights: Vec<f64>, budget: Budget) -> Self {
        Self { budget, weights, done: 0, told: 0 }
    }

    /// Carries out the work on the next part with its part of the time that is left; `work` tells the seconds that it took.
    pub(crate) fn next<T, E>(
        &mut self,
        control: Control<'_>,
        work: impl FnOnce(Budget, Control<'_>) -> Result<(f64, T), E>,
    ) -> Result<T, E> {
        let left: f64 = self.weights[self.done..].iter().sum();
        let share = self.weights[self.done] / left;
        let budget = Budget { seconds: self.budget.seconds.map(|seconds| seconds * share), ..self.budget };
        let units = ((PROGRESS_UNITS - self.told) as f64 * share).round() as u64;
        let (found, told) = (AtomicU64::new(0), AtomicU64::new(0));
        let progress = |more: usize| {
            let done = found.fetch_add(more as u64, Ordering::Relaxed) + more as u64;
            let due = (done * units / PROGRESS_UNITS).min(units);
            let before = told.fetch_max(due, Ordering::Relaxed);
            if due > before {
                (control.progress)((due - before) as usize);
            }
        };
        let (seconds, result) = work(budget, Control { progress: &progress, ..control })?;
        self.budget.seconds = self.budget.seconds.map(|all| (all - seconds).max(f64::MIN_POSITIVE));
        self.told += told.into_inner();
        self.done += 1;
        Ok(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{cell::Cell, sync::atomic::AtomicBool};

    #[test]
    fn parts_share_time_and_progress_by_what_is_to_do() {
        let budget = Budget { seconds: Some(8.0), ..Budget::rays(64) };
        let mut shares = Shares::new(vec![1.0, 2.0, 1.0], budget);
        let told = AtomicU64::new(0);
        let progress = |units: usize| _ = told.fetch_add(units as u64, Ordering::Relaxed);
        let never = AtomicBool::new(false);
        let control = Control { cancelled: &never, progress: &progress };
        let allowed = Cell::new(Vec::new());
        for seconds in [2.0, 3.0, 1.0] {
            let run = |budget: Budget, control: Control<'_>| {
                (0..PROGRESS_UNITS).for_each(|_| (control.progress)(1));
                allowed.set([allowed.take(), vec![budget.seconds.unwrap()]].concat());
                Ok::<_, ()>((seconds, ()))
            };
            shares.next(control, run).unwrap();
        }
        // A quarter, two thirds of what was left, and all that was.
        assert_eq!(allowed.take(), [2.0, 4.0, 3.0]);
        assert_eq!(told.into_inner(), PROGRESS_UNITS);
    }
}
