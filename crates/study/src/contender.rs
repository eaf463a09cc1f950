//! The seam at which methods join the study.

use crate::{Case, Pilot, StudyError};
use conray::{AoSettings, Control, Estimate};
use serde_json::{Map, Value};

/// An estimator that the study judges.
///
/// To add one: implement this trait in a file of `contenders/` and list it in `contenders::all`.
pub trait Contender: Send {
    /// Short and unique: lower case with hyphens, as in `--methods`.
    fn name(&self) -> &'static str;

    /// One sentence for the report: what it does and after whom.
    fn about(&self) -> String;

    /// What must be built before it can start; counted apart from its own time, and together.
    fn needs(&self) -> Needs;

    /// Why it cannot take part here, such as a library that was not found; the report says so.
    fn unavailable(&self) -> Option<String> {
        None
    }

    /// The points of its curve for budgets given in rays per surface point, in ascending order of work.
    fn efforts(&self, budgets: &[u32]) -> Vec<Effort>;

    /// Everything that happens once per case and is not part of an estimate: finding its best settings, opening a
    /// library. Not timed. May look at the truth, so that each rival is shown at its best.
    ///
    /// # Errors
    /// Whatever keeps it from taking part; the study stops.
    fn prepare(&mut self, preparation: &Preparation<'_>) -> Result<(), StudyError> {
        let _ = preparation;
        Ok(())
    }

    /// Estimates every point of the case with this much work, from nothing but the case's structures. Timed.
    ///
    /// The answer depends on the case, the effort and the case's seed alone. Where `control` is cancelled the answer
    /// may hold anything; it is thrown away.
    ///
    /// # Errors
    /// Whatever keeps it from answering; the study stops.
    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError>;

    /// Settings chosen in [`Contender::prepare`] for an effort, for the report.
    fn chosen(&self, effort: u32) -> Map<String, Value> {
        let _ = effort;
        Map::new()
    }
}

/// Structures that a contender starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// A BVH for rays.
    pub bvh: bool,
    /// An octree for cones.
    pub octree: bool,
}

/// One point of a contender's curve.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Effort {
    /// What is handed to [`Contender::run`]: rays per point, frames, cones, whatever the contender counts.
    pub value: u32,
    /// For people: `16 rays`, `2 frames`, `25 cones`.
    pub label: String,
}

/// What a contender may look at before it starts.
pub struct Preparation<'a> {
    /// The case.
    pub case: &'a Case,
    /// The true visibility of every point of the case.
    pub truth: &'a [f32],
    /// A sample of points whose cones have been looked at one by one.
    pub pilot: &'a Pilot,
    /// The budgets of the study, in rays per point.
    pub budgets: &'a [u32],
    /// Settings of the study: distance, voxels, cones, the paper's constants, seed.
    pub settings: &'a AoSettings,
    /// How the preparation is followed and stopped.
    pub control: Control<'a>,
}

/// What a contender says about a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Visibility of each point, in the case's order.
    pub visibility: Vec<f32>,
    /// Expected absolute error of each visibility, from a contender that tells.
    pub expected_error: Option<Vec<f32>>,
    /// Rays traced in all.
    pub rays: u64,
    /// Cones marched in all.
    pub cones: u64,
}

impl Answer {
    /// What the product's estimates say, one a point.
    pub(crate) fn of(estimates: &[Estimate], rays: u64, cones: u64) -> Self {
        Self {
            visibility: estimates.iter().map(|e| e.visibility).collect(),
            expected_error: Some(estimates.iter().map(|e| e.error).collect()),
            rays,
            cones,
        }
    }
}
