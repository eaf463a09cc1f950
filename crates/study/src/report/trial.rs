//! One method with one amount of work, and how trials compare.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// A method that was asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MethodReport {
    /// Its name, as in `--methods`.
    pub name: String,
    /// What it does and after whom.
    pub about: String,
    /// It starts from a BVH.
    pub needs_bvh: bool,
    /// It starts from an octree.
    pub needs_octree: bool,
    /// Why it did not take part, if it did not.
    pub unavailable: Option<String>,
}

/// One method with one amount of work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrialReport {
    /// Name of the method.
    pub method: String,
    /// Amount of work, in what the method counts.
    pub effort: u32,
    /// The same for people: `16 rays`.
    pub label: String,
    /// Rays per surface point.
    pub rays: f64,
    /// Cones per surface point.
    pub cones: f64,
    /// Settings that the method chose for itself here.
    pub chosen: Map<String, Value>,
    /// How far it is from the truth.
    pub quality: Quality,
    /// RMSE that the method itself expects: root of the mean square of its expected errors.
    pub expected_rmse: Option<f64>,
    /// How long it took.
    pub timing: TrialTiming,
}

/// Errors over all surface points of a case, against its truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quality {
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean signed error, above 0 where too open.
    pub bias: f64,
    /// The bias divided by the mean true visibility.
    pub relative_bias: f64,
    /// 95th percentile of the absolute error.
    pub p95: f64,
    /// Mean FLIP over the pixels that see a surface: 0 is equal, 1 the largest difference. Andersson, Nilsson,
    /// Akenine-Moller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference Evaluator for Alternating Images", 2020; visibility
    /// shown as stored, 67 pixels a degree.
    pub flip: f64,
}

/// Wall-clock seconds of one trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrialTiming {
    /// Median of the timed runs.
    pub seconds: f64,
    /// Fastest run.
    pub min_seconds: f64,
    /// Slowest run.
    pub max_seconds: f64,
    /// How many runs were timed.
    pub runs: u32,
    /// The median with the builds that the method needs.
    pub seconds_with_builds: f64,
}

/// One row of the paper's Table 1, ours beside theirs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TableRow {
    /// Name of the method here.
    pub method: String,
    /// What the row is, such as `rays, as many as the blend traces`.
    pub label: String,
    /// Rays per surface point.
    pub rays: f64,
    /// Our RMSE; `None` in rows that depend on time (see `timing`).
    pub rmse: Option<f64>,
    /// The blend's RMSE divided by this row's, where it does not depend on time.
    pub blend_ratio: Option<f64>,
    /// The paper's RMSE for its scene of this kind, if it has one.
    pub paper_rmse: Option<f64>,
    /// The paper's milliseconds.
    pub paper_ms: Option<f64>,
    /// The paper's blend RMSE divided by its RMSE in this row.
    pub paper_blend_ratio: Option<f64>,
    /// Which are of this machine.
    pub timing: TableTiming,
}

/// The part of a row of Table 1 that depends on the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TableTiming {
    /// Seconds of the estimation.
    pub seconds: f64,
    /// RMSE of a row at equal time, read off the curve.
    pub rmse: Option<f64>,
    /// The blend's RMSE divided by it.
    pub blend_ratio: Option<f64>,
}

/// A method against `rays` and `hybrid` at equal time, at one of its efforts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EqualTime {
    /// Name of the method.
    pub method: String,
    /// Its effort.
    pub effort: u32,
    /// All of it depends on the clock.
    pub timing: EqualTimeTiming,
}

/// What interpolation in log time says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EqualTimeTiming {
    /// The method's RMSE divided by that of `rays` in the same estimation time; below 1 the method wins. `None` where the
    /// time is outside the curve of `rays`.
    pub rmse_ratio: Option<f64>,
    /// The same with the builds that each needs.
    pub rmse_ratio_with_builds: Option<f64>,
    /// The RMSE of `hybrid` in the same estimation time divided by the method's; below 1 `hybrid` wins. `None` where the time is
    /// outside the curve of `hybrid`.
    pub hybrid_rmse_ratio: Option<f64>,
}

/// How well a method's expected errors fit its true ones, at one effort.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EstimateCalibration {
    /// Name of the method.
    pub method: String,
    /// Its effort.
    pub effort: u32,
    /// The same for people.
    pub label: String,
    /// Expected RMSE over the image divided by the true one; 1 is right, below 1 it promises too much.
    pub ratio: f64,
    /// Deciles of expected error, ascending.
    pub bins: Vec<ErrorBin>,
}

/// Points of about the same expected error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorBin {
    /// How many points.
    pub count: usize,
    /// Root mean square of their expected errors.
    pub expected: f64,
    /// Root mean square of their true errors.
    pub actual: f64,
}
