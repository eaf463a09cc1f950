//! The product's own method.

use super::rays::ray_efforts;
use crate::{Answer, Case, Contender, Effort, Needs, StudyError};
use conray::{AoSettings, Control, Method, target::Target};

/// `hybrid`: so many rays a point on average, as a user gets them.
pub(crate) struct Hybrid;

impl Contender for Hybrid {
    fn name(&self) -> &'static str {
        "hybrid"
    }

    fn about(&self) -> String {
        "conray's own: rays where they help most, pooled with what like neighbours found, each weighed by its expected squared \
         error, which the image's own rays tell. Nothing is searched for with the truth at hand."
            .into()
    }

    fn needs(&self) -> Needs {
        Needs { bvh: true, octree: false }
    }

    fn efforts(&self, budgets: &[u32]) -> Vec<Effort> {
        ray_efforts(budgets)
    }

    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError> {
        let settings = AoSettings { method: Method::Hybrid, rays: Some(effort), ..case.settings.clone() };
        let plan = case.session.plan_for(&settings)?;
        let missing =
            || StudyError::Rival { name: self.name().into(), problem: "the target is no image".into() };
        let mut hybrid = case.session.hybrid(&plan, &case.target).ok_or_else(missing)?;
        case.session.refine(&mut hybrid, &plan, case.target.points(), plan.budget, control);
        let estimates = case.session.install(|| hybrid.estimates());
        Ok(Answer::of(&estimates, hybrid.rays(), 0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{contenders::rays::trace, quality::rmse, testing::test_case};
    use conray::Sampling;

    #[test]
    fn it_errs_less_than_rays_and_says_by_how_much() {
        let case = test_case(96);
        let truth = trace(&case, 4096, Sampling::Stratified, Control::none()).unwrap().visibility;
        for (rays, at_most) in [(16, 0.6), (64, 0.7), (256, 0.9)] {
            let found = Hybrid.run(&case, rays, Control::none()).unwrap();
            let plain = trace(&case, rays, Sampling::Sobol, Control::none()).unwrap();
            let (error, without) = (rmse(&found.visibility, &truth), rmse(&plain.visibility, &truth));
            assert!(error < at_most * without, "{rays} rays: {error} of {without}");
            let spent = found.rays as f64 / case.points().len() as f64;
            assert!(spent <= 1.05 * f64::from(rays), "{spent} rays of {rays}");
            assert_eq!(found, Hybrid.run(&case, rays, Control::none()).unwrap(), "the same again");
        }
    }
}
