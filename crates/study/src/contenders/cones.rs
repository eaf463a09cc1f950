//! Cones alone.

use crate::{Answer, Case, Contender, Effort, Needs, StudyError};
use conray::{AoSettings, Control, Method};

/// Sets of cones, whatever the budget.
const CONES: [u32; 4] = [6, 9, 16, 25];

/// Cones marched through the octree.
pub(crate) struct Cones;

impl Contender for Cones {
    fn name(&self) -> &'static str {
        "cones"
    }

    fn about(&self) -> String {
        "Cones marched through the octree: without noise, biased. After Crassin, Neyret, Sainz, Green, Eisemann, \
         Interactive Indirect Illumination Using Voxel Cone Tracing, 2011."
            .into()
    }

    fn needs(&self) -> Needs {
        // The BVH is there for the primary hits in any case; cones themselves do not ask it.
        Needs { bvh: false, octree: true }
    }

    fn efforts(&self, _budgets: &[u32]) -> Vec<Effort> {
        CONES.iter().map(|&cones| Effort { value: cones, label: format!("{cones} cones") }).collect()
    }

    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError> {
        case.answer(
            &AoSettings { method: Method::Cones, cones: effort, ..case.settings.clone() },
            0..1,
            control,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::test_case;

    #[test]
    fn every_effort_answers_with_its_cones_and_no_ray() {
        let case = test_case(16);
        let mut answers: Vec<Vec<f32>> = Vec::new();
        for effort in Cones.efforts(&[1, 2]) {
            let answer = Cones.run(&case, effort.value, Control::none()).unwrap();
            assert_eq!(answer.rays, 0);
            assert_eq!(answer.cones, u64::from(effort.value) * case.points().len() as u64);
            // The weights sum to 1 up to rounding.
            assert!(answer.visibility.iter().all(|v| (0.0..=1.00001).contains(v)));
            assert!(!answers.contains(&answer.visibility), "{}", effort.label);
            answers.push(answer.visibility);
        }
        assert_eq!(answers.len(), 4);
        let error = Cones.run(&case, 7, Control::none()).unwrap_err().to_string();
        assert!(error.contains("--cones 7"), "{error}");
    }
}
