//! What a study is asked to do.

use crate::{StudyError, contenders};
use conray::{AoSettings, View, limits, scene::Scene};
use std::path::PathBuf;

/// A scene and the views it is judged from.
#[derive(Clone, Debug)]
pub struct StudyScene {
    /// The scene.
    pub scene: Scene,
    /// The views, at least one.
    pub views: Vec<View>,
    /// How long it took to load or make.
    pub load_seconds: f64,
}

/// What a study is asked to do; every member changes the report.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyOptions {
    /// Width and height of every image in pixels.
    pub size: (u32, u32),
    /// Budgets in rays per surface point, ascending.
    pub budgets: Vec<u32>,
    /// Names of the contenders, in the order of the report.
    pub methods: Vec<String>,
    /// How often a trial is timed at most.
    pub repeats: u32,
    /// A trial that has taken this long in all is not repeated.
    pub repeat_seconds: f64,
    /// Error (RMSE) that the truth is to reach at least; it goes on where it judges smaller errors than four times its own.
    pub truth_error: f64,
    /// Rays per point that the truth may take.
    pub truth_rays: u32,
    /// Points whose cones are looked at one by one.
    pub pilot_points: usize,
    /// AO settings that all contenders share.
    pub settings: AoSettings,
    /// Marks the report as a first look.
    pub quick: bool,
    /// Threads; 0 is one per core.
    pub threads: usize,
    /// Where truths are kept between studies; `None` keeps none.
    pub truth_folder: Option<PathBuf>,
    /// Where trials are kept until the study is done.
    pub work_folder: PathBuf,
}

impl StudyOptions {
    /// A study to cite: 512 x 512 pixels, 1 to 256 rays per point.
    pub fn full(work_folder: PathBuf) -> Self {
        Self {
            size: (512, 512),
            budgets: (0..=8).map(|k| 1 << k).collect(),
            methods: contenders::default_names(),
            repeats: 3,
            repeat_seconds: 6.0,
            truth_error: 0.002,
            truth_rays: 16384,
            pilot_points: 2048,
            settings: AoSettings::default(),
            quick: false,
            threads: 0,
            truth_folder: None,
            work_folder,
        }
    }

    /// A first look within about a minute on two cores.
    pub fn quick(work_folder: PathBuf) -> Self {
        Self {
            size: (128, 128),
            budgets: (0..=6).map(|k| 1 << k).collect(),
            repeat_seconds: 0.3,
            truth_error: 0.003,
            truth_rays: 2048,
            pilot_points: 512,
            quick: true,
            ..Self::full(work_folder)
        }
    }

    /// Checks every member, before any work.
    ///
    /// # Errors
    /// [`StudyError::Request`] names the first that is wrong.
    pub fn validate(&self) -> Result<(), StudyError> {
        let wrong = |text: String| Err(StudyError::Request(text));
        self.settings.validate().map_err(conray::Error::from)?;
        let Some(most) = self.budgets.last() else { return wrong("--budgets: name at least one".into()) };
        if let Some(bad) = self.budgets.iter().find(|b| !limits::RAYS.contains(b)) {
            return wrong(format!("--budgets {bad}: each must be from 1 to {}", limits::RAYS.end()));
        }
        if self.budgets.windows(2).any(|w| w[0] >= w[1]) {
            return wrong("--budgets: must ascend".into());
        }
        if !(1..=1000).contains(&self.repeats) {
            return wrong(format!("--repeats {}: must be from 1 to 1000", self.repeats));
        }
        if !(self.truth_error > 0.0 && self.truth_error.is_finite()) {
            return wrong(format!("--truth-error {}: must be above 0", self.truth_error));
        }
        if self.truth_rays < most.saturating_mul(4) || self.truth_rays > 2 * limits::RAYS.end() {
            return wrong(format!(
                "--truth-rays {}: must be from {} (four times the largest budget) to {}",
                self.truth_rays,
                most.saturating_mul(4),
                2 * limits::RAYS.end()
            ));
        }
        contenders::check_names(&self.methods)
    }
}
