//! Every number of a study. `report.json` is this, written down; the page is drawn from this and from nothing else.
//!
//! All that depends on the clock or the machine is under members named `timing`; two runs with one seed agree in the rest.
//! Errors are of linear visibility in [0, 1]; bias is estimate minus truth, above 0 where the estimate is too open.

mod case;
mod cones;
mod figure;
mod trial;

pub use case::{CaseReport, CaseTiming, TruthReport, ViewReport};
pub use cones::{CauseReport, ConeBin, ConeClass, ConeClassReport, ConeReport, TunedReport};
pub use figure::{Content, Failure, Figure, Panel, PlotKind};
pub use trial::{
    EqualTime, EqualTimeTiming, ErrorBin, EstimateCalibration, MethodReport, Quality, TableRow, TableTiming,
    TrialReport, TrialTiming,
};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// A whole study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Report {
    /// Version of the program that made it.
    pub version: String,
    /// Version of this schema; raised when a member changes its meaning.
    pub schema: u32,
    /// True for a study cut to about a minute (`--quick`): small images, few budgets; for a first look, not for citing.
    pub quick: bool,
    /// What was asked for.
    pub request: Request,
    /// Every method asked for, also those that could not take part.
    pub methods: Vec<MethodReport>,
    /// One per scene and view, in the order asked for.
    pub cases: Vec<CaseReport>,
    /// What the paper leaves unstated and how it was settled here, one sentence each.
    pub unstated: Vec<String>,
    /// The machine and the times of the whole study.
    pub timing: StudyTiming,
}

/// What was asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Request {
    /// Width and height of every image in pixels.
    pub size: [u32; 2],
    /// Budgets in rays per surface point.
    pub budgets: Vec<u32>,
    /// How often each trial was timed at most.
    pub repeats: u32,
    /// Error (RMSE) that the truth was to reach.
    pub truth_error: f64,
    /// AO settings by the names of the program's options; `method` and `rays` say nothing here.
    pub settings: Map<String, Value>,
}

/// The machine and the times of the whole study. All of it differs between machines and runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudyTiming {
    /// Name of the processor as the system tells it.
    pub processor: String,
    /// Operating system and architecture.
    pub system: String,
    /// Threads that every contender worked on.
    pub threads: usize,
    /// Cores that the system offers.
    pub cores: usize,
    /// Wall-clock seconds of the study, earlier interrupted runs not counted.
    pub seconds: f64,
    /// The machine's noise: one trial timed twice as if it were two contenders, the larger median over the smaller,
    /// less 1; over all cases the largest. `None` where trials were timed once.
    pub noise: Option<f64>,
}
