//! How far the study is.

use crate::study::{Observer, Progress};
use std::sync::Mutex;

/// Units of work of one case: a third for its truth, the rest for its trials, judging included.
const CASE_UNITS: u64 = 3_000_000;
const TRUTH_UNITS: u64 = CASE_UNITS / 3;

/// Turns what is done into one ascending number.
pub(crate) struct Meter<'a> {
    observer: &'a dyn Observer,
    total: u64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    what: String,
    /// Units of the cases that are over.
    before: u64,
    /// Units of the present case, never descending.
    here: u64,
}

impl<'a> Meter<'a> {
    pub(crate) fn new(observer: &'a dyn Observer, cases: usize) -> Self {
        Self { observer, total: cases as u64 * CASE_UNITS, state: Mutex::default() }
    }

    /// What is done from now on.
    pub(crate) fn say(&self, what: String) {
        self.update(|state| state.what = what);
    }

    /// Share of the truth that is done, in [0, 1].
    pub(crate) fn truth(&self, share: f64) {
        self.reach((share.clamp(0.0, 1.0) * TRUTH_UNITS as f64) as u64);
    }

    /// Share of the trials that is done, in [0, 1].
    pub(crate) fn trials(&self, share: f64) {
        self.reach(TRUTH_UNITS + (share.clamp(0.0, 1.0) * (CASE_UNITS - TRUTH_UNITS) as f64) as u64);
    }

    /// The present case is over.
    pub(crate) fn case_done(&self) {
        self.update(|state| {
            state.before += CASE_UNITS;
            state.here = 0;
        });
    }

    /// Passes a warning on.
    pub(crate) fn warn(&self, message: &str) {
        self.observer.warn(message);
    }

    fn reach(&self, units: u64) {
        self.update(|state| state.here = state.here.max(units));
    }

    fn update(&self, change: impl FnOnce(&mut State)) {
        // A poisoned lock means that another thread panicked; its last state will do for a progress bar.
        let mut state = self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        change(&mut state);
        let progress =
            Progress { what: state.what.clone(), done: state.before + state.here, total: self.total };
        drop(state);
        self.observer.progress(&progress);
    }
}
