//! Rays alone, in each sampling.

use crate::{Answer, Case, Contender, Effort, Needs, StudyError};
use conray::{AoSettings, Control, Method, Sampling};

/// As many rays a point as the budget.
pub(crate) struct Rays {
    sampling: Sampling,
}

impl Rays {
    pub(crate) fn new(sampling: Sampling) -> Self {
        Self { sampling }
    }
}

impl Contender for Rays {
    fn name(&self) -> &'static str {
        match self.sampling {
            Sampling::Sobol => "rays",
            Sampling::Stratified => "rays-stratified",
            Sampling::Random => "rays-random",
        }
    }

    fn about(&self) -> String {
        match self.sampling {
            Sampling::Sobol => {
                "Rays in Owen-scrambled Sobol order, a sequence of its own for each point. Burley, Practical Hash-based \
                 Owen Scrambling, 2020."
            }
            Sampling::Stratified => {
                "Jittered rays: one in each cell of a grid over the hemisphere. Cook, Stochastic Sampling in Computer \
                 Graphics, 1986."
            }
            Sampling::Random => "Independent random rays, as many publications compare with.",
        }
        .into()
    }

    fn needs(&self) -> Needs {
        Needs { bvh: true, octree: false }
    }

    fn efforts(&self, budgets: &[u32]) -> Vec<Effort> {
        ray_efforts(budgets)
    }

    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError> {
        trace(case, effort, self.sampling, control)
    }
}

/// One effort for each budget: that many rays.
pub(super) fn ray_efforts(budgets: &[u32]) -> Vec<Effort> {
    let label = |rays| if rays == 1 { "1 ray".into() } else { format!("{rays} rays") };
    budgets.iter().map(|&rays| Effort { value: rays, label: label(rays) }).collect()
}

/// That many rays at each point of the case.
pub(super) fn trace(
    case: &Case,
    rays: u32,
    sampling: Sampling,
    control: Control<'_>,
) -> Result<Answer, StudyError> {
    let settings = AoSettings { method: Method::Rays, rays: Some(rays), sampling, ..case.settings.clone() };
    case.answer(&settings, 0..rays, control)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{quality::rmse, testing::test_case};

    #[test]
    fn each_answers_with_its_rays_and_comes_nearer_with_more() {
        let case = test_case(32);
        let truth = trace(&case, 1024, Sampling::Sobol, Control::none()).unwrap().visibility;
        for sampling in Sampling::ALL {
            let contender = Rays::new(sampling);
            let error = |effort| {
                let answer = contender.run(&case, effort, Control::none()).unwrap();
                assert_eq!(answer.rays, u64::from(effort) * case.points().len() as u64);
                assert_eq!(answer.cones, 0);
                rmse(&answer.visibility, &truth)
            };
            let (few, many) = (error(4), error(64));
            // Independent rays gain the root of 16, the others more; 1024 points tell a few per cent.
            assert!(many < few / 3.5, "{}: {few} {many}", contender.name());
        }
    }

    #[test]
    fn samplings_differ_and_sobol_is_the_product_as_it_is() {
        let case = test_case(16);
        let run = |sampling| Rays::new(sampling).run(&case, 8, Control::none()).unwrap().visibility;
        let [sobol, stratified, random] = Sampling::ALL.map(run);
        assert!(sobol != stratified && sobol != random && stratified != random);
        let settings = AoSettings { method: Method::Rays, rays: Some(8), ..case.settings.clone() };
        assert_eq!(case.answer(&settings, 0..8, Control::none()).unwrap().visibility, sobol);
    }

    #[test]
    fn labels_are_for_people() {
        let labels: Vec<String> = ray_efforts(&[1, 16]).into_iter().map(|e| e.label).collect();
        assert_eq!(labels, ["1 ray", "16 rays"]);
    }
}
