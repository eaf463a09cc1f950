//! A report as files: `pictures/`, `curves.csv`, `report.json` and `report.html`.

use crate::{Report, StudyError, csv::curves, page::page};
use conray::target::{check_writable, write_atomically};
use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path, PathBuf},
};

/// Writes a report into a folder, which is created where there is none.
///
/// Everything is made in memory and every place is tried before the first byte is written, so that a report that cannot be
/// written harms no earlier one. Each file appears whole or not at all; `report.html` comes last. `pictures` holds the PNG
/// of each file that the report's panels name.
///
/// # Errors
/// [`StudyError::Output`] names the first file or folder that cannot be written, or the picture that is missing.
pub fn write_report(
    folder: &Path,
    report: &Report,
    pictures: &BTreeMap<String, Vec<u8>>,
) -> Result<(), StudyError> {
    let html = page(report, pictures)?;
    let json = serde_json::to_vec_pretty(report).map_err(|e| output(&folder.join("report.json"), &e))?;
    let csv = curves(report);
    let mut files: Vec<(PathBuf, &[u8])> = Vec::new();
    for (name, bytes) in pictures {
        files.push((folder.join(inside(name)?), bytes));
    }
    files.push((folder.join("curves.csv"), csv.as_bytes()));
    files.push((folder.join("report.json"), &json));
    files.push((folder.join("report.html"), html.as_bytes()));

    create(folder)?;
    for (path, _) in &files {
        path.parent().map_or(Ok(()), create)?;
        check_writable(path).map_err(|e| refused(path, e))?;
    }
    for (path, bytes) in &files {
        write_atomically(path, |w| w.write_all(bytes)).map_err(|e| refused(path, e))?;
    }
    Ok(())
}

/// Asks before long work whether a report can be written into a folder, which is created where there is none.
///
/// # Errors
/// [`StudyError::Output`] names what is in the way.
pub fn check_folder(folder: &Path) -> Result<(), StudyError> {
    create(folder)?;
    create(&folder.join("pictures"))?;
    ["curves.csv", "report.json", "report.html", "pictures/trial.png"]
        .map(|name| folder.join(name))
        .iter()
        .try_for_each(|path| check_writable(path).map_err(|e| refused(path, e)))
}

/// The schema of `report.json`, as in `docs/report.schema.json`.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Report).to_value()
}

fn create(folder: &Path) -> Result<(), StudyError> {
    fs::create_dir_all(folder).map_err(|e| output(folder, &e))
}

/// A name that stays in the folder; a scene's name must not lead out of it.
fn inside(name: &str) -> Result<&Path, StudyError> {
    let path = Path::new(name);
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_));
    if name.is_empty() || !path.components().all(plain) {
        return Err(output(path, &"it does not name a file in the folder of the report"));
    }
    Ok(path)
}

fn output(path: &Path, reason: &dyn std::fmt::Display) -> StudyError {
    StudyError::Output { path: path.into(), reason: reason.to_string() }
}

/// The reason without the path, which the error names itself.
fn refused(path: &Path, error: conray::target::TargetError) -> StudyError {
    match error {
        conray::target::TargetError::Output { source, .. } => output(path, &source),
        other => output(path, &other),
    }
}

#[cfg(test)]
mod tests;
