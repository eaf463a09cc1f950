//! Rays followed by an edge-avoiding filter, its settings found with the truth at hand.

#[cfg(test)]
mod tests;

use super::rays::{ray_efforts, trace};
use crate::{
    Answer, Case, Contender, Effort, Needs, Preparation, StudyError,
    atrous::{AtrousSettings, Guides, MAX_LEVELS, Noisy},
    quality::rmse,
};
use conray::{Control, Distance, Sampling};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Images of more pixels are searched with fewer settings.
const SMALL_IMAGE: usize = 160 * 160;

/// Values tried for each setting; infinite is off.
const DEVIATIONS: [f32; 7] = [0.75, 1.0, 1.5, 2.0, 3.0, 5.0, f32::INFINITY];
const DISTANCE_SHARES: [f32; 6] = [0.03, 0.06, 0.12, 0.25, 0.5, f32::INFINITY];
const NORMAL_DEG: [f32; 5] = [5.0, 10.0, 20.0, 40.0, f32::INFINITY];
const PLANE_FOOTPRINTS: [f32; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// Sobol rays, filtered.
#[derive(Default)]
pub(crate) struct Filtered {
    guides: Option<Guides>,
    found: BTreeMap<u32, Choice>,
    /// The AO distance of the case, or its size where that is infinite.
    unit: f32,
}

/// Settings of one effort: indices into the lists above, so that the search can step through them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Choice {
    levels: u32,
    /// Deviations, distance, normal, plane.
    at: [usize; 4],
}

const LENGTHS: [usize; 4] =
    [DEVIATIONS.len(), DISTANCE_SHARES.len(), NORMAL_DEG.len(), PLANE_FOOTPRINTS.len()];

impl Choice {
    const START: Self = Self { levels: MAX_LEVELS, at: [3, 3, 2, 2] };

    fn settings(&self, unit: f32) -> AtrousSettings {
        AtrousSettings {
            levels: self.levels,
            deviations: DEVIATIONS[self.at[0]],
            distance: unit * DISTANCE_SHARES[self.at[1]],
            normal_deg: NORMAL_DEG[self.at[2]],
            plane_footprints: PLANE_FOOTPRINTS[self.at[3]],
        }
    }
}

impl Contender for Filtered {
    fn name(&self) -> &'static str {
        "rays-filtered"
    }

    fn about(&self) -> String {
        "Sobol rays and an a-trous wavelet filter guided by normals, positions and variance, its settings those of \
         least error found with the truth at hand. Dammertz, Sewtz, Hanika, Lensch, Edge-Avoiding A-Trous Wavelet \
         Transform for fast Global Illumination Filtering, 2010; Schied and others, Spatiotemporal Variance-Guided \
         Filtering, 2017."
            .into()
    }

    fn needs(&self) -> Needs {
        Needs { bvh: true, octree: false }
    }

    fn efforts(&self, budgets: &[u32]) -> Vec<Effort> {
        ray_efforts(budgets)
    }

    /// Packs the guides, known from the camera's own rays as the points are, and searches for each effort.
    ///
    /// Coordinate descent from the settings of the effort before: each setting in turn takes its best value until none
    /// improves. A run of the filter with all levels tells the error after each of them, so levels cost nothing more.
    fn prepare(&mut self, preparation: &Preparation<'_>) -> Result<(), StudyError> {
        let case = preparation.case;
        let guides = Guides::new(case);
        self.unit = unit(case);
        let evaluations = if case.points().len() > SMALL_IMAGE { 25 } else { 75 };
        let mut start = Choice::START;
        for &rays in preparation.budgets {
            if preparation.control.is_cancelled() {
                return Ok(());
            }
            let answer = trace(case, rays, Sampling::Sobol, preparation.control)?;
            let noisy = noisy(case, &answer);
            let mut judge = |choice: Choice| self.judge(case, &guides, &noisy, choice, preparation.truth);
            let best = search(start, evaluations, &mut judge);
            self.found.insert(rays, best);
            start = best;
        }
        self.guides = Some(guides);
        Ok(())
    }

    fn run(&self, case: &Case, effort: u32, control: Control<'_>) -> Result<Answer, StudyError> {
        let (Some(guides), Some(choice)) = (&self.guides, self.found.get(&effort)) else {
            let problem = format!("no settings were found for {effort} rays");
            return Err(StudyError::Rival { name: self.name().into(), problem });
        };
        let answer = trace(case, effort, Sampling::Sobol, control)?;
        if choice.levels == 0 {
            return Ok(Answer { expected_error: None, ..answer });
        }
        let mut image = noisy(case, &answer);
        case.session.install(|| guides.filter(&mut image, &choice.settings(self.unit), |_, _| ()));
        Ok(Answer { visibility: gather(case, &image.value), expected_error: None, ..answer })
    }

    fn chosen(&self, effort: u32) -> Map<String, Value> {
        let mut members = Map::new();
        if let Some(choice) = self.found.get(&effort) {
            let settings = choice.settings(self.unit);
            members.insert("levels".into(), json!(settings.levels));
            if settings.levels > 0 {
                // Infinite is `null` in JSON: the setting is off.
                members.insert("value-deviations".into(), json!(settings.deviations));
                members.insert("distance".into(), json!(settings.distance));
                members.insert("normal-degrees".into(), json!(settings.normal_deg));
                members.insert("plane-footprints".into(), json!(settings.plane_footprints));
            }
        }
        members
    }
}

impl Filtered {
    /// The least error over the levels of a choice, with that level.
    fn judge(
        &self,
        case: &Case,
        guides: &Guides,
        noisy: &Noisy,
        choice: Choice,
        truth: &[f32],
    ) -> (f64, u32) {
        let mut best = (rmse(&gather(case, &noisy.value), truth), 0);
        let settings = AtrousSettings { levels: MAX_LEVELS, ..choice.settings(self.unit) };
        let mut image = noisy.clone();
        case.session.install(|| {
            guides.filter(&mut image, &settings, |level, values| {
                let error = rmse(&gather(case, values), truth);
                if error < best.0 {
                    best = (error, level);
                }
            });
        });
        best
    }
}

/// Coordinate descent with at most that many evaluations; `judge` gives the error of a choice and its best level.
fn search(start: Choice, evaluations: usize, judge: &mut dyn FnMut(Choice) -> (f64, u32)) -> Choice {
    let (mut error, mut levels) = judge(start);
    let (mut best, mut left) = (start, evaluations.saturating_sub(1));
    // Coordinates that have been gone through since the last improvement.
    let mut settled = 0;
    for coordinate in (0..LENGTHS.len()).cycle() {
        if settled == LENGTHS.len() || left == 0 {
            break;
        }
        settled += 1;
        let before = best;
        for value in (0..LENGTHS[coordinate]).filter(|&v| v != before.at[coordinate]).take(left) {
            let mut choice = before;
            choice.at[coordinate] = value;
            left -= 1;
            let (found, level) = judge(choice);
            if found < error {
                (error, levels, best, settled) = (found, level, choice, 1);
            }
        }
    }
    Choice { levels, ..best }
}

/// The estimates as an image; the background is open and certain.
fn noisy(case: &Case, answer: &Answer) -> Noisy {
    let errors = answer.expected_error.as_deref().unwrap_or_default();
    // A number within [0, 1] varies by 1/4 at most; points that cannot be asked about claim more.
    let variance: Vec<f32> = errors.iter().map(|e| (e * e).min(0.25)).collect();
    Noisy { value: case.pixels(&answer.visibility, 1.0), variance: case.pixels(&variance, 0.0) }
}

/// The values at the case's points.
pub(super) fn gather(case: &Case, pixels: &[f32]) -> Vec<f32> {
    case.points().iter().map(|p| pixels[p.id as usize]).collect()
}

fn unit(case: &Case) -> f32 {
    match case.settings.distance {
        Distance::Infinite => case.session.bounds().diagonal(),
        distance => distance.in_world(case.session.bounds().diagonal()),
    }
}
