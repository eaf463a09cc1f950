//! The threads that a session works on.

use crate::Error;

/// A pool of threads; where the system has none, as in a web page, the caller's own.
#[derive(Clone, Debug)]
pub(crate) struct Threads {
    #[cfg(not(target_arch = "wasm32"))]
    pool: std::sync::Arc<rayon::ThreadPool>,
}

#[cfg(not(target_arch = "wasm32"))]
impl Threads {
    /// So many threads; 0 is one per core.
    pub(crate) fn start(threads: usize) -> Result<Self, Error> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| Error::Threads { threads, reason: e.to_string() })?;
        Ok(Self { pool: std::sync::Arc::new(pool) })
    }

    /// Runs work whose parallel iterators use these threads.
    pub(crate) fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.pool.current_num_threads()
    }
}

#[cfg(target_arch = "wasm32")]
impl Threads {
    /// The caller's own, whatever is asked for: rayon falls back to it where no thread can be started.
    pub(crate) fn start(_: usize) -> Result<Self, Error> {
        Ok(Self {})
    }

    /// Runs work here.
    pub(crate) fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        work()
    }

    /// One.
    pub(crate) fn count(&self) -> usize {
        1
    }
}
