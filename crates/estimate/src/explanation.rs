//! Why the work was done as it was: costs, choices and what each round reached.

use serde::Serialize;

/// What a round of rays came to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Round {
    /// Rays a point on average, all rounds so far together.
    pub rays_per_point: f64,
    /// Expected RMSE of visibility after it.
    pub expected_rmse: f64,
    /// Wall-clock seconds since the work began; 0 for rounds of an earlier run that was resumed.
    pub seconds: f64,
}

/// How rays are shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Choice {
    /// Where they help most, pooled with like neighbours.
    Hybrid,
    /// Evenly, each point by its own.
    Evenly,
}

/// The plan that was made and carried out, with what it was made from. Seconds are wall-clock, all threads at work.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// Points that can be estimated.
    pub points: u64,
    /// How rays were shared out.
    pub choice: Choice,
    /// Rays in a bundle.
    pub bundle_rays: u32,
    /// Rays a point that the plan reckons with: of the budget, for its time or until its error, as last foreseen.
    pub foreseen_rays: f64,
    /// Cost of a ray; `None` before any.
    pub ray_seconds: Option<f64>,
    /// Cost of weighing all points once; `None` before any.
    pub weighing_seconds: Option<f64>,
    /// RMSE foreseen for pooled and for even rays, where both were considered.
    pub foreseen_rmse: Option<[f64; 2]>,
    /// What was done, round by round.
    pub rounds: Vec<Round>,
}
