//! What may be spent on a target, what must be reached, and what ended the work.

use crate::{AoSettings, Method};
use serde::Serialize;
use std::fmt;

/// The error below which one is hardly seen: 2 %, Walter et al., "Lightcuts", 2005.
pub const HARDLY_SEEN: f32 = 0.02;

/// The work ends at whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Most rays a point: of method `rays` at each, of `hybrid` on average.
    pub rays: u32,
    /// Most wall-clock seconds, above 0. Results depend on the machine where this is what ends the work.
    pub seconds: Option<f64>,
    /// Expected RMSE of visibility over the points that is enough, above 0.
    pub error: Option<f32>,
}

impl Budget {
    /// So many rays a point, however long they take.
    pub fn rays(rays: u32) -> Self {
        Self { rays, seconds: None, error: None }
    }

    /// What valid settings say; where they say nothing, the error that is [hardly seen](HARDLY_SEEN).
    pub fn of(settings: &AoSettings) -> Self {
        let AoSettings { rays, time, error, .. } = *settings;
        let default = (rays.is_none() && time.is_none()).then_some(HARDLY_SEEN);
        Self { rays: rays.unwrap_or(*crate::limits::RAYS.end()), seconds: time, error: error.or(default) }
    }
}

/// What ended the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Ended {
    /// All rays of the budget were traced.
    Rays,
    /// The time was up.
    Time,
    /// The error was reached.
    Error,
    /// The caller stopped it.
    Cancelled,
    /// A device failed.
    Failed,
    /// All that the method does was done, or there was no point to estimate.
    Done,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rays => "all rays of the budget were traced",
            Self::Time => "the time was up",
            Self::Error => "the error was reached",
            Self::Cancelled => "it was interrupted",
            Self::Failed => "the device failed",
            Self::Done => "there was nothing more to do",
        })
    }
}

impl Method {
    /// True where the method works until a budget is spent; the others do one fixed amount of work.
    pub fn has_budget(self) -> bool {
        matches!(self, Self::Rays | Self::Hybrid)
    }
}
