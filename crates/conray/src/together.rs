//! Estimating the points of a target together, where the method lets neighbours share what they found.

use crate::{Error, Outcome, Session};
use conray_core::{Layout, SurfacePoint};
use conray_estimate::{AoPlan, Budget, Control, Ended, Hybrid, Method};
use conray_target::Target;
use std::time::Instant;

impl Session {
    /// Estimates every point of a target until the plan's budget is spent, telling of progress and stopping when asked to.
    ///
    /// Method `hybrid` shares between the pixels of an image; every other method, and every other layout, is
    /// [`Session::run`].
    ///
    /// # Errors
    /// What the backend lacks for the plan.
    pub fn run_target<T: Target>(&self, target: &T, control: Control<'_>) -> Result<Outcome, Error> {
        let start = Instant::now();
        match self.hybrid(&self.plan, target) {
            Some(mut hybrid) => Ok(self.run_hybrid(&mut hybrid, target.points(), start, control)),
            None => self.run(target.points(), control),
        }
    }

    /// Goes on with a refinement until the plan's budget is spent: rays of all work on it, seconds since `start`.
    pub fn run_hybrid(
        &self,
        hybrid: &mut Hybrid,
        points: &[SurfacePoint],
        start: Instant,
        control: Control<'_>,
    ) -> Outcome {
        let spent = start.elapsed().as_secs_f64();
        let seconds = self.plan.budget.seconds.map(|seconds| (seconds - spent).max(f64::MIN_POSITIVE));
        let budget = Budget { seconds, ..self.plan.budget };
        let ended = self.refine(hybrid, &self.plan, points, budget, control);
        let estimates = self.install(|| hybrid.estimates());
        Outcome {
            completed: ended != Ended::Cancelled,
            ended,
            expected_rmse: hybrid.expected_rmse(),
            seconds: start.elapsed().as_secs_f64(),
            rays: hybrid.rays(),
            cones: 0,
            explanation: Some(hybrid.explanation()),
            estimates,
        }
    }

    /// The beginning of a refinement of a target by method `hybrid`, without a ray yet; `None` for another method or a target
    /// whose points say nothing of their neighbours.
    pub fn hybrid<T: Target>(&self, plan: &AoPlan, target: &T) -> Option<Hybrid> {
        match target.layout() {
            Layout::Image { width, height } if plan.method == Method::Hybrid => {
                Some(Hybrid::of_image(plan, target.points(), width, height))
            }
            _ => None,
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
        self.install(|| hybrid.refine(plan, &self.bvh, points, budget, control))
    }
}
