//! The table of all trials: which value is the best of its column, and how each does against rays.

use crate::report::{CaseReport, EqualTimeTiming, TrialReport, TrialTiming};
use serde::Serialize;

/// One trial as a row.
#[derive(Debug, Serialize)]
pub(super) struct Row<'a> {
    trial: &'a TrialReport,
    /// Against rays in the same time, where that is known.
    equal_time: EqualTimeTiming,
    /// Fastest and slowest run beside the median, in per cent: `−3, +11`.
    spread: String,
    /// First row of its method.
    first: bool,
    best: Best,
}

/// Which values of a row are the best of their columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct Best {
    rmse: bool,
    mae: bool,
    bias: bool,
    p95: bool,
    flip: bool,
    ratio: bool,
    ratio_with_builds: bool,
}

/// A number of a row, where less is better, and the mark that its least value gets.
type Column = (fn(&Row<'_>) -> f64, fn(&mut Best));

pub(super) fn rows(case: &CaseReport) -> Vec<Row<'_>> {
    let mut rows: Vec<Row<'_>> = Vec::new();
    for trial in &case.trials {
        let found = case.equal_time.iter().find(|e| e.method == trial.method && e.effort == trial.effort);
        let equal_time = found.map_or_else(EqualTimeTiming::default, |e| e.timing);
        let first = rows.last().is_none_or(|row| row.trial.method != trial.method);
        rows.push(Row { trial, equal_time, spread: spread(&trial.timing), first, best: Best::default() });
    }
    let columns: [Column; 7] = [
        (|r| r.trial.quality.rmse, |b| b.rmse = true),
        (|r| r.trial.quality.mae, |b| b.mae = true),
        (|r| r.trial.quality.bias.abs(), |b| b.bias = true),
        (|r| r.trial.quality.p95, |b| b.p95 = true),
        (|r| r.trial.quality.flip, |b| b.flip = true),
        (|r| r.equal_time.rmse_ratio.unwrap_or(f64::INFINITY), |b| b.ratio = true),
        (|r| r.equal_time.rmse_ratio_with_builds.unwrap_or(f64::INFINITY), |b| b.ratio_with_builds = true),
    ];
    for (value, mark) in columns {
        // NaN is never the least.
        let least = rows.iter().map(value).fold(f64::INFINITY, f64::min);
        for row in rows.iter_mut().filter(|row| least.is_finite() && value(row) == least) {
            mark(&mut row.best);
        }
    }
    rows
}

fn spread(timing: &TrialTiming) -> String {
    let percent = |seconds: f64| 100.0 * (seconds / timing.seconds - 1.0);
    let (least, most) = (percent(timing.min_seconds), percent(timing.max_seconds));
    if !least.is_finite() || !most.is_finite() {
        return "–".into();
    }
    format!("{least:+.0}, {most:+.0}").replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn the_least_of_each_column_is_the_best() {
        let case = fixture::report().cases.remove(0);
        let rows = rows(&case);
        let least = case.trials.iter().map(|t| t.quality.rmse).fold(f64::INFINITY, f64::min);
        for row in &rows {
            assert_eq!(row.best.rmse, row.trial.quality.rmse == least);
        }
        let best = |pick: fn(&Best) -> bool| rows.iter().filter(|r| pick(&r.best)).count();
        assert!(best(|b| b.rmse) > 0 && best(|b| b.flip) > 0 && best(|b| b.ratio) > 0);
        // The one bias of 0, not the most negative one.
        let unbiased: Vec<&str> =
            rows.iter().filter(|r| r.best.bias).map(|r| r.trial.method.as_str()).collect();
        assert_eq!(unbiased, ["rays"]);
    }

    #[test]
    fn missing_numbers_are_never_best() {
        let mut case = fixture::report().cases.remove(0);
        case.equal_time.clear();
        case.trials.iter_mut().for_each(|t| t.quality.flip = f64::NAN);
        case.trials[0].quality.rmse = f64::NAN;
        let rows = rows(&case);
        assert!(rows.iter().all(|r| !r.best.flip && !r.best.ratio && !r.best.ratio_with_builds));
        assert!(!rows[0].best.rmse && rows.iter().any(|r| r.best.rmse));
    }

    #[test]
    fn the_spread_is_beside_the_median() {
        let timing =
            |seconds| TrialTiming { seconds, min_seconds: 0.97, max_seconds: 1.11, ..Default::default() };
        assert_eq!((spread(&timing(1.0)).as_str(), spread(&timing(0.0)).as_str()), ("−3, +11", "–"));
    }
}
