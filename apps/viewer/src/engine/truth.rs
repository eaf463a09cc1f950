//! Truths: many rays of another seed, found pass by pass.

use super::{Engine, Report, Stop, Trouble, answers, scenes, side};
use conray::{Budget, Control, Refinement, Session, SessionOptions, target::Target};

/// Rays of a truth between two looks at what is newer.
const TRUTH_PASS: u32 = 64;

/// A truth that is being found.
pub(super) struct TruthWork {
    key: String,
    rays: u32,
    done: u32,
    session: Session,
    refinement: Refinement,
}

impl Engine {
    pub(super) fn begin_truth(&mut self, key: String, rays: u32) -> Result<(), Trouble> {
        let (Some(held), Some(job)) = (&self.held, &self.job) else { return Ok(()) };
        let (Some(target), Some(session)) = (job.target(), held.sessions.first()) else {
            return Err(answers::request("there is no whole picture yet; try again in a moment"));
        };
        let settings = answers::truth_settings(&job.wish.sides[0], rays);
        let session = session
            .with(&settings, &SessionOptions::default(), &|_| {})
            .map_err(|e| scenes::trouble_of(&e))?;
        let refinement = session.refinement(target);
        self.truth = Some(TruthWork { key, rays, done: 0, session, refinement });
        Ok(())
    }

    /// Some more rays of the truth.
    pub(super) async fn truth_pass(
        &mut self,
        stop: &Stop<'_>,
        report: &(dyn Fn(Report) + Sync),
    ) -> Result<(), Trouble> {
        let (Some(work), Some(job)) = (&mut self.truth, &self.job) else { return Ok(()) };
        let Some(target) = job.target() else { return Ok(()) };
        let next = (work.done + TRUTH_PASS).min(work.rays);
        let progress = |_| {
            stop.is_set();
        };
        let control = Control { cancelled: stop.flag, progress: &progress };
        let on = self.pictures.as_ref().filter(|p| p.serve(&work.session)).map(|p| p.backend());
        let budget = Budget::rays(next);
        let (session, refinement) = (&work.session, &mut work.refinement);
        if let Err(e) = side::more(on, session, refinement, target.points(), budget, control).await {
            // A pass that failed left no trace.
            let (device, truth) = (job.wish.device, self.truth.take());
            self.take_over(device, scenes::trouble_of(&e), report)?;
            self.truth = truth;
            return Ok(());
        }
        if stop.is_set() {
            return Ok(());
        }
        work.done = next;
        report(Report::Busy("finding the truth".into(), Some(next as f32 / work.rays as f32)));
        // Shown when it has doubled, and at the end.
        if next == work.rays || (next / TRUTH_PASS).is_power_of_two() {
            let estimates = work.refinement.estimates();
            let rmse = work.refinement.expected_rmse();
            let truth = answers::truth_so_far(&work.key, target, &estimates, [next, work.rays], rmse);
            report(Report::Truth(truth));
        }
        if next == work.rays {
            self.truth = None;
        }
        Ok(())
    }
}
