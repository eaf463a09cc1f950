//! The one stream of events that feeds progress bars, viewers and logs.

/// A piece of work that takes long enough to be told about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Building the BVH.
    Bvh,
    /// Building the octree.
    Octree,
    /// Estimating the points.
    Estimate,
}

impl Stage {
    /// Name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bvh => "bvh",
            Self::Octree => "octree",
            Self::Estimate => "estimate",
        }
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A stage begins.
    Started {
        /// Which.
        stage: Stage,
    },
    /// Part of a stage is done.
    Progress {
        /// Which stage.
        stage: Stage,
        /// Work done, in units of the stage.
        done: u64,
        /// Work in all.
        total: u64,
    },
    /// A stage is over.
    Finished {
        /// Which.
        stage: Stage,
        /// Wall-clock time.
        seconds: f64,
    },
    /// Something that the caller should know and that did not stop the work.
    Warning {
        /// In plain words.
        message: String,
    },
}

/// Receives events, from any thread.
pub type Observer<'a> = &'a (dyn Fn(Event) + Sync);
