//! The cones one by one: what they claim, what is true, and what goes wrong.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The cones of a sample of points, each judged by many rays inside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConeReport {
    /// Points looked at, spread evenly over the image.
    pub points: usize,
    /// Cones per point.
    pub cones: u32,
    /// Rays inside each cone for its true visibility.
    pub rays: u32,
    /// Classes of cones, as the published blend treats them; shares sum to 1.
    pub classes: Vec<ConeClassReport>,
    /// Bins of epsilon, ascending; the first holds the cones of epsilon 0.
    pub epsilon: Vec<ConeBin>,
    /// Rank correlation (Spearman) of epsilon and the true absolute error of a cone, in [-1, 1].
    pub rank_correlation: f64,
    /// The same of epsilon with the error of marching itself.
    pub rank_correlation_marching: f64,
}

/// How the published blend treats a cone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ConeClass {
    /// The march met nothing, and the voxels that touch the cone beyond the surface's own are empty: open for certain.
    Certified,
    /// The march met nothing (visibility 1, epsilon 0), but the voxels cannot prove it.
    Open,
    /// Closed by full voxels (visibility 0, epsilon 0).
    Closed,
    /// In between, and epsilon is small enough that no ray is sent.
    Trusted,
    /// Rays are sent.
    Refined,
}

/// The cones of one class.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConeClassReport {
    /// Which.
    pub class: ConeClass,
    /// Share of all cones.
    pub share: f64,
    /// Root mean square of marched minus true visibility.
    pub rmse: f64,
    /// Mean of marched minus true visibility.
    pub bias: f64,
    /// Share of the class's cones whose rays agree with it within 0.05.
    pub right: f64,
}

/// Cones of about the same epsilon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConeBin {
    /// How many cones.
    pub count: usize,
    /// Mean epsilon.
    pub epsilon: f64,
    /// Mean absolute true error.
    pub mae: f64,
    /// Root mean square true error.
    pub rmse: f64,
    /// 95th percentile of the absolute true error.
    pub p95: f64,
}

/// The published blend's constants, found by search for one budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TunedReport {
    /// Rays per point at most.
    pub budget: u32,
    /// Which error of a cone counts: `published` or `marching`.
    pub epsilon: String,
    /// Transition parameter.
    pub beta: f64,
    /// Threshold.
    pub gamma: f64,
    /// Most rays per cone.
    pub max_rays: u32,
    /// Rays per point that the search expects.
    pub expected_rays: f64,
    /// RMSE that the search expects.
    pub expected_rmse: f64,
}

/// Where the squared error of a method comes from: shares over the sampled points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CauseReport {
    /// Name of the method.
    pub method: String,
    /// The cause, in words.
    pub cause: String,
    /// Share of the points.
    pub points: f64,
    /// Share of the method's squared error.
    pub squared_error: f64,
    /// Mean signed error of these points.
    pub bias: f64,
}
