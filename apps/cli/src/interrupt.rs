//! Ctrl-C: the first asks the work to stop and write what is there, the second ends the program.

use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Takes Ctrl-C over and gives the flag that it sets.
pub(crate) fn watch() -> &'static AtomicBool {
    // A second handler cannot be installed; then Ctrl-C keeps its usual meaning.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    });
    &INTERRUPTED
}
