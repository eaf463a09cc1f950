//! Estimates of a target that get better for as long as one asks: what a viewer shows.

use crate::{
    Error, Session,
    passes::{Elsewhere, Passes},
};
use conray_core::{Estimate, SurfacePoint};
use conray_estimate::{AoPlan, Budget, Control, Ended, Hybrid, Meter};
use conray_target::Target;

/// The work on a target so far, by a session's plan; [`Session::go_on`] adds to it.
#[derive(Debug)]
pub struct Refinement {
    plan: AoPlan,
    work: Work,
}

#[derive(Debug)]
enum Work {
    /// Points that share what they find.
    Together(Box<Hybrid>),
    /// Each point by itself, in passes over all.
    OneByOne(Passes),
}

impl Refinement {
    /// The plan, as of its beginning.
    pub fn plan(&self) -> &AoPlan {
        &self.plan
    }

    /// The estimates so far, one a point: pending before the first rays or cones.
    pub fn estimates(&self) -> Vec<Estimate> {
        match &self.work {
            Work::Together(hybrid) => hybrid.estimates(),
            Work::OneByOne(passes) => passes.estimates.clone(),
        }
    }

    /// Expected RMSE of visibility over the points that can be estimated; infinite where one was not reached.
    pub fn expected_rmse(&self) -> f64 {
        match &self.work {
            Work::Together(hybrid) => hybrid.expected_rmse(),
            Work::OneByOne(passes) => passes.rmse(),
        }
    }

    /// Rays traced so far.
    pub fn rays(&self) -> u64 {
        match &self.work {
            Work::Together(hybrid) => hybrid.rays(),
            Work::OneByOne(passes) => passes.estimates.iter().map(|e| u64::from(e.rays)).sum(),
        }
    }
}

impl Session {
    /// The beginning of a refinement of a target by the session's plan, without a ray yet.
    pub fn refinement<T: Target>(&self, target: &T) -> Refinement {
        let plan = self.plan.clone();
        let work = match self.hybrid(&plan, target) {
            Some(mut hybrid) => {
                hybrid.weigh_later();
                Work::Together(Box::new(hybrid))
            }
            None => Work::OneByOne(Passes::of_whole_passes(target.points().len())),
        };
        Refinement { plan, work }
    }

    /// Adds work to a refinement until a budget is spent and says what ended it: rays of all calls together, seconds of this one. The
    /// points are those that it began with.
    ///
    /// When cancelled the estimates stay those before, and that is at once: method `hybrid` keeps what it found for the next call, in the end with the
    /// bits of unbroken work; the others lose the pass that was interrupted. A method without a budget does all its work at the first call.
    ///
    /// # Errors
    /// What the backend lacks for the plan, and a device that failed: the estimates before stay.
    pub fn go_on(
        &self,
        refinement: &mut Refinement,
        points: &[SurfacePoint],
        budget: Budget,
        control: Control<'_>,
    ) -> Result<Ended, Error> {
        let Refinement { plan, work } = refinement;
        match work {
            Work::Together(hybrid) => {
                let ended = self.refine(hybrid, plan, points, budget, control);
                hybrid.failure().map_or(Ok(ended), |failure| Err(failure.clone().into()))
            }
            Work::OneByOne(passes) => {
                pollster::block_on(self.add_passes(None, plan, passes, points, budget, control))
            }
        }
    }

    /// [`Session::go_on`] on a device that answers later: for a page, where nobody may wait for one. `device` holds what the session's plan needs of the
    /// session's scene. Points one by one: what is shared by method `hybrid` is added where the session works, at once.
    ///
    /// # Errors
    /// As [`Session::go_on`].
    #[cfg(feature = "gpu")]
    pub async fn go_on_later(
        &self,
        device: &conray_gpu::GpuBackend,
        refinement: &mut Refinement,
        points: &[SurfacePoint],
        budget: Budget,
        control: Control<'_>,
    ) -> Result<Ended, Error> {
        let Refinement { plan, work } = refinement;
        match work {
            Work::OneByOne(passes) => {
                self.add_passes(Some(device), plan, passes, points, budget, control).await
            }
            Work::Together(_) => self.go_on(refinement, points, budget, control),
        }
    }

    async fn add_passes(
        &self,
        elsewhere: Option<&Elsewhere>,
        plan: &AoPlan,
        passes: &mut Passes,
        points: &[SurfacePoint],
        budget: Budget,
        control: Control<'_>,
    ) -> Result<Ended, Error> {
        let budget = if plan.method.has_budget() { budget } else { Budget::rays(1) };
        let meter = Meter::new(control, budget.seconds);
        let ended = self.passes_until(elsewhere, plan, passes, budget, points, &meter).await;
        meter.finish();
        ended
    }
}
