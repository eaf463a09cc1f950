//! Who runs the engine: a thread beside the window, or a worker beside the page.

#[cfg(not(target_arch = "wasm32"))]
mod thread;
#[cfg(target_arch = "wasm32")]
mod worker;

#[cfg(not(target_arch = "wasm32"))]
pub use thread::ThreadHost;
#[cfg(target_arch = "wasm32")]
pub use worker::{WorkerEngine, WorkerHost};

use crate::engine::{Order, Report};

/// The engine as the window sees it: never waits.
pub trait Host {
    /// Passes an order on; work on what is older ends soon.
    fn order(&self, order: Order);

    /// What came in since the last call, oldest first.
    fn reports(&self) -> Vec<Report>;
}
