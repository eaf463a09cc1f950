//! The table at the top: each method at about the time that rays take.

use crate::{
    Report,
    report::{CaseReport, TrialReport},
};
use serde::Serialize;

/// Rays per point whose time the methods are compared at.
const RAYS: f64 = 16.0;

/// A trial that takes this many times longer or shorter is shown, but not compared.
const ABOUT: f64 = 1.5;

/// The whole table.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    columns: Vec<Column>,
    rows: Vec<Row>,
}

/// One case: its time.
#[derive(Debug, Serialize)]
struct Column {
    id: String,
    scene: String,
    view: String,
    seconds: Option<f64>,
    /// Whose time it is: `16 rays`.
    label: String,
}

/// One method: a cell a case.
#[derive(Debug, Serialize)]
struct Row {
    method: String,
    cells: Vec<Option<Cell>>,
}

#[derive(Debug, Serialize)]
struct Cell {
    label: String,
    rmse: f64,
    seconds: f64,
    /// Time over that of the column.
    times: f64,
    /// The time is about that of the column.
    comparable: bool,
    /// The least RMSE of the comparable ones.
    best: bool,
}

pub(super) fn of(report: &Report) -> Summary {
    let references: Vec<Option<&TrialReport>> = report.cases.iter().map(reference).collect();
    let column = |(case, reference): (&CaseReport, &Option<&TrialReport>)| Column {
        id: case.id.clone(),
        scene: case.scene.clone(),
        view: case.view.name.clone(),
        seconds: reference.map(|t| t.timing.seconds),
        label: reference.map_or_else(String::new, |t| t.label.clone()),
    };
    let columns = report.cases.iter().zip(&references).map(column).collect();
    let mut rows: Vec<Row> = report
        .methods
        .iter()
        .map(|method| Row {
            method: method.name.clone(),
            cells: (report.cases.iter().zip(&references))
                .map(|(case, reference)| nearest(case, &method.name, reference.as_ref()?.timing.seconds))
                .collect(),
        })
        .collect();
    for index in 0..report.cases.len() {
        mark_best(&mut rows, index);
    }
    rows.retain(|row| row.cells.iter().any(Option::is_some));
    Summary { columns, rows }
}

/// The trial of `rays` that is nearest to the chosen number of rays.
fn reference(case: &CaseReport) -> Option<&TrialReport> {
    case.trials
        .iter()
        .filter(|t| t.method == "rays" && t.timing.seconds > 0.0)
        .min_by(|a, b| distance(a.rays, RAYS).total_cmp(&distance(b.rays, RAYS)))
}

fn nearest(case: &CaseReport, method: &str, seconds: f64) -> Option<Cell> {
    let trials = case.trials.iter().filter(|t| t.method == method && t.timing.seconds > 0.0);
    let trial = trials
        .min_by(|a, b| distance(a.timing.seconds, seconds).total_cmp(&distance(b.timing.seconds, seconds)))?;
    Some(Cell {
        label: trial.label.clone(),
        rmse: trial.quality.rmse,
        seconds: trial.timing.seconds,
        times: trial.timing.seconds / seconds,
        comparable: distance(trial.timing.seconds, seconds) <= ABOUT.ln(),
        best: false,
    })
}

fn mark_best(rows: &mut [Row], column: usize) {
    let comparable = |row: &Row| row.cells[column].as_ref().filter(|c| c.comparable).map(|c| c.rmse);
    let least = rows.iter().filter_map(comparable).fold(f64::INFINITY, f64::min);
    for cell in rows.iter_mut().filter_map(|row| row.cells[column].as_mut()) {
        cell.best = cell.comparable && cell.rmse <= least;
    }
}

/// How far apart two positive numbers are in ratio.
fn distance(a: f64, b: f64) -> f64 {
    (a / b).ln().abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn each_method_is_shown_at_the_time_nearest_to_that_of_16_rays() {
        let report = fixture::report();
        let summary = of(&report);
        let case = &report.cases[0];
        let time = case.trials.iter().find(|t| t.method == "rays" && t.effort == 16).unwrap().timing.seconds;
        assert_eq!((summary.columns[0].seconds, summary.columns[0].label.as_str()), (Some(time), "16 rays"));
        for row in &summary.rows {
            let cell = row.cells[0].as_ref().unwrap();
            for other in case.trials.iter().filter(|t| t.method == row.method) {
                assert!(
                    distance(cell.seconds, time) <= distance(other.timing.seconds, time),
                    "{}",
                    row.method
                );
            }
        }
    }

    #[test]
    fn the_best_has_about_the_same_time() {
        let mut report = fixture::report();
        let find = |summary: &Summary| {
            let best = |r: &&Row| r.cells[0].as_ref().is_some_and(|c| c.best);
            summary.rows.iter().filter(best).map(|r| r.method.clone()).collect::<Vec<_>>()
        };
        let before = find(&of(&report));
        assert_eq!(before.len(), 1, "{before:?}");
        // As slow as can be, however good.
        for trial in report.cases[0].trials.iter_mut().filter(|t| t.method == before[0]) {
            trial.timing.seconds *= 1e3;
        }
        assert_ne!(find(&of(&report)), before);
    }

    #[test]
    fn without_rays_there_is_nothing_to_compare_with() {
        let mut report = fixture::report();
        report.cases.iter_mut().for_each(|c| c.trials.retain(|t| t.method != "rays"));
        assert!(of(&report).rows.is_empty());
    }
}
