//! How the engine learns, in the middle of its work, that something newer is asked for.

use std::sync::atomic::{AtomicBool, Ordering};

/// Asked while work goes on.
pub struct Stop<'a> {
    /// Set where something newer waits; looked at by every thread of the work.
    pub flag: &'a AtomicBool,
    /// Asked now and then for whether to set it: for engines whose messages wait outside while they work.
    pub poll: &'a (dyn Fn() -> bool + Sync),
}

impl Stop<'_> {
    /// True once something newer waits.
    pub fn is_set(&self) -> bool {
        if !self.flag.load(Ordering::Relaxed) && (self.poll)() {
            self.flag.store(true, Ordering::Relaxed);
        }
        self.flag.load(Ordering::Relaxed)
    }
}

impl Stop<'static> {
    /// Never.
    pub fn never() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { flag: &NEVER, poll: &|| false }
    }
}
