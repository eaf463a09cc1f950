//! Estimating the points of a target together, where the method lets neighbours share what they found.

use crate::{Error, Outcome, Session};
use conray_core::{Layout, SurfacePoint};
use conray_estimate::{AoPlan, Control, Hybrid, Method};
use conray_target::Target;
use std::time::Instant;

impl Session {
    /// Estimates every point of a target, telling of progress and stopping when asked to.
    ///
    /// Method `hybrid` shares between the pixels of an image; every other method, and every other layout, is
    /// [`Session::run`].
    ///
    /// # Errors
    /// What the backend lacks for the plan.
    pub fn run_target<T: Target>(&self, target: &T, control: Control<'_>) -> Result<Outcome, Error> {
        let Some(mut hybrid) = self.hybrid(&self.plan, target) else {
            return self.run(target.points(), control);
        };
        let start = Instant::now();
        self.refine(&mut hybrid, &self.plan, target.points(), f64::from(self.plan.rays), control);
        Ok(Outcome {
            completed: !control.is_cancelled(),
            seconds: start.elapsed().as_secs_f64(),
            rays: hybrid.rays(),
            cones: 0,
            estimates: self.install(|| hybrid.estimates()),
        })
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

    /// Adds work to a refinement until there are so many rays a point on average; see [`Hybrid::refine`].
    pub fn refine(
        &self,
        hybrid: &mut Hybrid,
        plan: &AoPlan,
        points: &[SurfacePoint],
        rays_per_point: f64,
        control: Control<'_>,
    ) {
        self.install(|| hybrid.refine(plan, &self.bvh, points, rays_per_point, control));
    }
}
