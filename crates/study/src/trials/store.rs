//! Trials kept until the study is done, so that an interrupted one goes on.

use super::Trial;
use crate::{
    Answer, Case, Contender, Effort, Fingerprint, StudyError, StudyOptions, fingerprint_of_case, kept::Kept,
    meter::Meter,
};
use serde_json::{Value, json};
use std::{fs, path::PathBuf};

const KIND: &str = "trial";

/// The trials of one case on disk.
pub(crate) struct Store {
    folder: PathBuf,
    case: Fingerprint,
    /// What else changes an answer: the shared settings.
    settings: String,
    points: usize,
}

impl Store {
    /// A store in the study's work folder, which is made.
    pub(crate) fn new(case: &Case, options: &StudyOptions) -> Result<Self, StudyError> {
        let folder = options.work_folder.clone();
        fs::create_dir_all(&folder)
            .map_err(|e| StudyError::Output { path: folder.clone(), reason: e.to_string() })?;
        Ok(Self {
            folder,
            case: fingerprint_of_case(case)?,
            settings: json!(case.settings).to_string(),
            points: case.points().len(),
        })
    }

    /// Of what a trial is the answer: case, method, effort, and the settings that the method chose for itself.
    fn fingerprint(&self, contender: &dyn Contender, effort: &Effort) -> Fingerprint {
        Fingerprint::of(|feed| {
            feed.fingerprint(self.case);
            feed.text(env!("CARGO_PKG_VERSION"));
            feed.text(&self.settings);
            feed.text(contender.name());
            feed.u32(effort.value);
            feed.text(&Value::Object(contender.chosen(effort.value)).to_string());
        })
    }

    fn path(&self, fingerprint: Fingerprint) -> PathBuf {
        self.folder.join(format!("trial-{fingerprint}.kept"))
    }

    /// What was kept of a trial. A damaged file is told of and done again: it is a part of unfinished work.
    pub(crate) fn load(
        &self,
        index: usize,
        contender: &dyn Contender,
        effort: &Effort,
        meter: &Meter<'_>,
    ) -> Option<Trial> {
        let fingerprint = self.fingerprint(contender, effort);
        match Kept::read(&self.path(fingerprint), KIND, fingerprint) {
            Ok(kept) => self.trial(index, effort, kept?),
            Err(error) => {
                meter.warn(&format!("{error}; the trial is done again"));
                None
            }
        }
    }

    fn trial(&self, contender: usize, effort: &Effort, mut kept: Kept) -> Option<Trial> {
        let number = |name: &str| kept.header.get(name)?.as_u64();
        let (rays, cones) = (number("rays")?, number("cones")?);
        let seconds = kept.header.get("seconds")?.as_array()?.iter().filter_map(Value::as_f64).collect();
        let visibility = kept.arrays.remove("visibility").filter(|v| v.len() == self.points)?;
        let expected_error = kept.arrays.remove("expected_error");
        let answer = Answer { visibility, expected_error, rays, cones };
        Some(Trial { contender, effort: effort.clone(), answer, seconds })
    }

    /// Keeps a trial as it is now.
    pub(crate) fn keep(&self, contender: &dyn Contender, trial: &Trial) -> Result<(), StudyError> {
        let fingerprint = self.fingerprint(contender, &trial.effort);
        let Answer { visibility, expected_error, rays, cones } = &trial.answer;
        let mut kept = Kept {
            header: json!({ "rays": rays, "cones": cones, "seconds": trial.seconds }),
            ..Kept::default()
        };
        kept.arrays.insert("visibility".into(), visibility.clone());
        if let Some(errors) = expected_error {
            kept.arrays.insert("expected_error".into(), errors.clone());
        }
        kept.write(&self.path(fingerprint), KIND, fingerprint)
    }
}
