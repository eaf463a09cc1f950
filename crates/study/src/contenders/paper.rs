//! The published blend with its settings as given, frame by frame.

use crate::{Answer, Case, Contender, Effort, Needs, StudyError};
use conray::{AoSettings, Control, Method};

/// `paper`, as many frames as a budget allows, with beta, gamma and N_max of the study's settings.
pub(crate) struct Paper;

impl Contender for Paper {
    fn name(&self) -> &'static str {
        "paper"
    }

    fn about(&self) -> String {
        "The published blend: cones where epsilon is small, rays inside the cone where it is not. Cones are marched \
         once, each frame adds rays. Podee, Dobashi, Yamamoto, Combining Cone and Ray Tracing for Ambient Occlusion \
         Computation."
            .into()
    }

    fn needs(&self) -> Needs {
        Needs { bvh: true, octree: true }
    }

    /// Frames 1, 2, 4 and so on, as many as a sixteenth of the largest budget: each frame traces some tens of rays.
    fn efforts(&self, budgets: &[u32]) -> Vec<Effort> {
        let most = budgets.last().map_or(1, |&b| (b / 16).max(1));
        std::iter::successors(Some(1), |f| Some(2 * f))
            .take_while(|&frames| frames <= most)
            .map(|frames| Effort {
                value: frames,
                label: if frames == 1 { "1 frame".into() } else { format!("{frames} frames") },
            })
            .collect()
    }

    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError> {
        case.answer(&AoSettings { method: Method::Paper, ..case.settings.clone() }, 0..effort, control)
    }
}
