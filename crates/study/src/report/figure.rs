//! Figures: pictures and plots with captions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A figure of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Figure {
    /// Unique in the case and fit for anchors: `figure-4`, `calibration`.
    pub id: String,
    /// Heading: `Figure 4 of the paper: the first frame`.
    pub title: String,
    /// What is shown.
    pub content: Content,
    /// What it shows, what agrees with the paper and what does not, with figures. A sentence that depends on the clock
    /// is in `timing_caption`.
    pub caption: String,
    /// Sentences that depend on the clock; may be empty.
    #[serde(rename = "timing", default)]
    pub timing_caption: String,
}

/// What a figure shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Content {
    /// Pictures side by side.
    Pictures(Vec<Panel>),
    /// A plot drawn from the case's numbers.
    Plot(PlotKind),
}

/// One picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Panel {
    /// File beside the report, such as `pictures/cornell-front-truth.png`.
    pub file: String,
    /// Short label: `truth, 4096 rays`.
    pub label: String,
}

/// A plot drawn from a case's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlotKind {
    /// RMSE against frames of the blend, rays and cones (Figure 5): rays at as many rays a frame as the blend traces.
    RmseByFrames,
    /// RMSE against estimation time, log axes.
    RmseByTime,
    /// RMSE against time with the builds that each method needs, log axes.
    RmseByTimeWithBuilds,
    /// RMSE against rays per point, log axes.
    RmseByRays,
    /// FLIP against estimation time, log axes.
    FlipByTime,
    /// Absolute relative bias against estimation time, log axes.
    BiasByTime,
    /// Epsilon against the true error of cones.
    ConeCalibration,
    /// Predicted against true error of estimates.
    EstimateCalibration,
}

/// A place where a method fails.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Failure {
    /// Name of the method.
    pub method: String,
    /// Its effort for people.
    pub label: String,
    /// Pixel in the middle of the crop: column, row.
    pub pixel: [u32; 2],
    /// Why, in words.
    pub cause: String,
    /// Result, truth and difference, enlarged.
    pub panels: Vec<Panel>,
}
