//! Estimating the points of a target together, where the method lets neighbours share what they found.

use crate::{Error, Outcome, Session, Work};
use conray_core::{Layout, SurfacePoint};
use conray_estimate::{AoPlan, Budget, Control, Ended, Hybrid, Method};
use conray_target::Target;
use std::path::Path;
use web_time::Instant;

/// Scattered points that share: fewer make no surface,
const FEWEST_POINTS: usize = 256;
/// and with fewer rays a point than a unit has most points would have none of their own.
const FEWEST_RAYS: u32 = 16;

impl Session {
    /// Estimates every point of a target until the plan's budget is spent, telling of progress and stopping when asked to.
    ///
    /// Method `hybrid` shares between the pixels of an image, and between scattered points where they are many; all else is
    /// [`Session::run`]. Where a device fails, what was estimated by then is handed back with [`Work::failure`].
    ///
    /// # Errors
    /// What the backend lacks for the plan.
    pub fn run_target<T: Target>(&self, target: &T, control: Control<'_>) -> Result<Outcome, Error> {
        self.run_target_within(self.plan.budget, target, control)
    }

    /// The same for another budget than the plan's.
    ///
    /// # Errors
    /// What the backend lacks for the plan.
    pub fn run_target_within<T: Target>(
        &self,
        budget: Budget,
        target: &T,
        control: Control<'_>,
    ) -> Result<Outcome, Error> {
        let start = Instant::now();
        let plan = AoPlan { budget, ..self.plan.clone() };
        match self.hybrid(&plan, target) {
            Some(mut hybrid) => Ok(self.run_hybrid(&mut hybrid, budget, target.points(), start, control)),
            None => self.run_within(&plan, target.points(), control),
        }
    }

    /// The same by method `hybrid`, going on with the work that a file keeps, where there is one, and keeping it there at the end, when stopped and where a device fails: in the
    /// end the bits are those of unbroken work. What does not share is not kept.
    ///
    /// # Errors
    /// [`Error::StateFile`] and [`Error::State`] of a file that cannot be gone on with, [`Error::Target`] where it cannot be written.
    pub fn run_target_kept<T: Target>(
        &self,
        budget: Budget,
        target: &T,
        control: Control<'_>,
        path: &Path,
    ) -> Result<Outcome, Error> {
        let start = Instant::now();
        let (plan, points) = (AoPlan { budget, ..self.plan.clone() }, target.points());
        let Some(begun) = self.hybrid(&plan, target) else {
            return self.run_within(&plan, points, control);
        };
        let mut hybrid = self.load(begun, &plan, points, path)?;
        let outcome = self.run_hybrid(&mut hybrid, budget, points, start, control);
        self.save(&hybrid, &plan, points, path)?;
        Ok(outcome)
    }

    /// Goes on with a refinement until a budget is spent: rays of all work on it, seconds since `start`.
    pub fn run_hybrid(
        &self,
        hybrid: &mut Hybrid,
        budget: Budget,
        points: &[SurfacePoint],
        start: Instant,
        control: Control<'_>,
    ) -> Outcome {
        let spent = start.elapsed().as_secs_f64();
        let seconds = budget.seconds.map(|seconds| (seconds - spent).max(f64::MIN_POSITIVE));
        let budget = Budget { seconds, ..budget };
        let ended = self.refine(hybrid, &self.plan, points, budget, control);
        let estimates = self.install(|| hybrid.estimates());
        let work = Work {
            completed: !matches!(ended, Ended::Cancelled | Ended::Failed),
            ended,
            failure: hybrid.failure().map(ToString::to_string),
            expected_rmse: hybrid.expected_rmse(),
            seconds: start.elapsed().as_secs_f64(),
            points: points.len() as u64,
            rays: hybrid.rays(),
            cones: 0,
            explanation: Some(hybrid.explanation()),
        };
        Outcome { estimates, work }
    }

    /// The beginning of a refinement of a target by method `hybrid`, without a ray yet; `None` for another method, and for scattered
    /// points that are few or get few rays: there neighbours say little.
    pub fn hybrid<T: Target>(&self, plan: &AoPlan, target: &T) -> Option<Hybrid> {
        let points = target.points();
        match target.layout() {
            _ if plan.method != Method::Hybrid => None,
            Layout::Image { first, width, height } => {
                Some(self.install(|| Hybrid::of_image(plan, points, first, [width, height])))
            }
            Layout::Scattered if points.len() >= FEWEST_POINTS && plan.budget.rays >= FEWEST_RAYS => {
                Some(self.install(|| Hybrid::of_scattered(plan, points)))
            }
            Layout::Scattered => None,
        }
    }

    /// Adds work to a refinement until a budget is spent; see [`Hybrid::refine`].
    pub fn refine(
        &self,
        hybrid: &mut Hybrid,
        plan: &AoPlan,
        points: &[SurfacePoint],
        budget: Budget,
        control: Control<'_>,
    ) -> Ended {
        let device = self.backend.hybrid_device();
        self.install(|| hybrid.refine_on(device, plan, &self.bvh, points, budget, control))
    }
}
