//! The published blend with beta, gamma and N_max found for each scene and budget.

use crate::{Answer, Case, Contender, Effort, Needs, Preparation, StudyError, assemble::decimal, search};
use conray::{AoSettings, Control, Method};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// One frame of the blend with the best constants that a budget of rays allows.
#[derive(Default)]
pub(crate) struct PaperTuned {
    found: BTreeMap<u32, search::Tuned>,
}

impl Contender for PaperTuned {
    fn name(&self) -> &'static str {
        "paper-tuned"
    }

    fn about(&self) -> String {
        "The published blend with beta, gamma, N_max and the kind of epsilon (with the error of marching or without) found by search \
         for this scene, view and budget of rays, the truth at hand: the best that its formula can do."
            .into()
    }

    fn needs(&self) -> Needs {
        Needs { bvh: true, octree: true }
    }

    fn efforts(&self, budgets: &[u32]) -> Vec<Effort> {
        budgets
            .iter()
            .map(|&rays| Effort {
                value: rays,
                label: format!("at most {rays} ray{}", if rays == 1 { "" } else { "s" }),
            })
            .collect()
    }

    fn prepare(&mut self, preparation: &Preparation<'_>) -> Result<(), StudyError> {
        let budgets = preparation.budgets;
        self.found = budgets.iter().copied().zip(search::tune(preparation.pilot, budgets)).collect();
        Ok(())
    }

    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError> {
        let Some(tuned) = self.found.get(&effort) else {
            let problem = format!("no settings were found for {effort} rays");
            return Err(StudyError::Rival { name: self.name().into(), problem });
        };
        let search::Constants { epsilon, beta, gamma, max_rays } = tuned.constants;
        let method = Method::Paper;
        let settings = AoSettings { method, epsilon, beta, gamma, max_rays, ..case.settings.clone() };
        case.answer(&settings, 0..1, control)
    }

    fn chosen(&self, effort: u32) -> Map<String, Value> {
        let mut members = Map::new();
        if let Some(tuned) = self.found.get(&effort) {
            members.insert("epsilon".into(), json!(tuned.constants.epsilon));
            members.insert("beta".into(), json!(decimal(tuned.constants.beta)));
            members.insert("gamma".into(), json!(decimal(tuned.constants.gamma)));
            members.insert("max-rays".into(), json!(tuned.constants.max_rays));
        }
        members
    }
}
