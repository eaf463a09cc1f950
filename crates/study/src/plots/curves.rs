//! Error of each method against what it took.

use super::{
    axis::Axis,
    chart::{Chart, Mark, Series},
    empty, figures,
    style::Style,
};
use crate::report::{CaseReport, TrialReport};

/// What a curve shows of a trial.
pub(super) struct Curve {
    pub(super) label: &'static str,
    pub(super) x_title: &'static str,
    pub(super) y_title: &'static str,
    pub(super) x: fn(&TrialReport) -> f64,
    pub(super) y: fn(&TrialReport) -> f64,
    /// Fastest and slowest run, on a time axis.
    pub(super) spread: fn(&TrialReport) -> Option<(f64, f64)>,
}

const TIME: &str = "time of the estimation, seconds";
const RMSE: &str = "RMSE of visibility";

impl Curve {
    pub(super) fn rmse_by_time() -> Self {
        Self {
            label: "RMSE against time of the estimation",
            x_title: TIME,
            y_title: RMSE,
            x: |t| t.timing.seconds,
            y: |t| t.quality.rmse,
            spread: |t| Some((t.timing.min_seconds, t.timing.max_seconds)),
        }
    }

    pub(super) fn rmse_by_time_with_builds() -> Self {
        Self {
            label: "RMSE against time of builds and estimation",
            x_title: "time with builds, seconds",
            x: |t| t.timing.seconds_with_builds,
            spread: |t| {
                let builds = t.timing.seconds_with_builds - t.timing.seconds;
                Some((t.timing.min_seconds + builds, t.timing.max_seconds + builds))
            },
            ..Self::rmse_by_time()
        }
    }

    pub(super) fn rmse_by_rays() -> Self {
        Self {
            label: "RMSE against rays per point",
            x_title: "rays per point",
            // A method without rays has no place here, not even at the edge.
            x: |t| if t.rays > 0.0 { t.rays } else { f64::NAN },
            spread: |_| None,
            ..Self::rmse_by_time()
        }
    }

    pub(super) fn flip_by_time() -> Self {
        Self {
            label: "FLIP against time of the estimation",
            y_title: "mean FLIP, 0 to 1",
            y: |t| t.quality.flip,
            ..Self::rmse_by_time()
        }
    }

    pub(super) fn bias_by_time() -> Self {
        Self {
            label: "absolute relative bias against time of the estimation",
            y_title: "absolute relative bias",
            y: |t| t.quality.relative_bias.abs(),
            ..Self::rmse_by_time()
        }
    }

    pub(super) fn draw(&self, case: &CaseReport) -> String {
        let series = self.series(case);
        let marks = || series.iter().flat_map(|s| &s.marks);
        let widths = marks().flat_map(|m| m.spread.map_or([m.x; 3], |(a, b)| [m.x, a, b]));
        let x = Axis::logarithmic(self.x_title, widths);
        let y = Axis::logarithmic(self.y_title, marks().map(|m| m.y));
        match (x, y) {
            (Some(x), Some(y)) => {
                Chart { label: self.label, x, y, series, diagonal: false, band: None }.draw()
            }
            _ => empty("No trial has a value above 0 to show here."),
        }
    }

    fn series(&self, case: &CaseReport) -> Vec<Series> {
        let names = || case.trials.iter().map(|t| t.method.as_str());
        let mut series: Vec<Series> = Vec::new();
        for trial in &case.trials {
            let (x, y) = ((self.x)(trial), (self.y)(trial));
            if !x.is_finite() || !y.is_finite() {
                continue;
            }
            let mark = Mark { x, y, spread: (self.spread)(trial), size: Mark::SIZE, title: title(trial) };
            match series.iter_mut().find(|s| s.name == trial.method) {
                Some(s) => s.marks.push(mark),
                None => series.push(Series {
                    name: trial.method.clone(),
                    style: Style::of(&trial.method, names()),
                    marks: vec![mark],
                }),
            }
        }
        series
    }
}

/// The numbers behind a mark.
fn title(trial: &TrialReport) -> String {
    let (quality, timing) = (&trial.quality, &trial.timing);
    format!(
        "{}, {}: RMSE {}, bias {}, FLIP {}; {} rays a point; {} s ({} to {}), {} s with builds",
        trial.method,
        trial.label,
        figures(quality.rmse),
        figures(quality.bias),
        figures(quality.flip),
        figures(trial.rays),
        figures(timing.seconds),
        figures(timing.min_seconds),
        figures(timing.max_seconds),
        figures(timing.seconds_with_builds)
    )
}
