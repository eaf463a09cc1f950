//! What was promised against what is true: epsilon of cones, expected errors of estimates.

use super::{
    axis::Axis,
    chart::{Chart, Mark, Series},
    empty, figures,
    style::Style,
};
use crate::report::{CaseReport, ConeBin, EstimateCalibration};

/// Half the width of the largest and of the smallest marker; its area goes with the count.
const LARGEST: f64 = 9.0;
const SMALLEST: f64 = 2.5;

/// Epsilon against the true error of cones, linear axes: most cones are at 0.
pub(super) fn cones(case: &CaseReport) -> String {
    let numbers = |b: &&ConeBin| [b.epsilon, b.mae, b.rmse, b.p95].iter().all(|v| v.is_finite());
    let bins: Vec<&ConeBin> = case.cones.epsilon.iter().filter(numbers).collect();
    if bins.is_empty() {
        return empty("No cones were looked at one by one.");
    }
    let most = bins.iter().map(|b| b.count).max().unwrap_or(1);
    let mark = |bin: &ConeBin, y: f64, size: f64| Mark {
        x: bin.epsilon,
        y,
        spread: None,
        size,
        title: format!(
            "{} cones of epsilon {}: mean absolute error {}, RMSE {}, 95 % below {}",
            bin.count,
            figures(bin.epsilon),
            figures(bin.mae),
            figures(bin.rmse),
            figures(bin.p95)
        ),
    };
    let series = |name: &str, method: &str, marks| Series {
        name: name.into(),
        style: Style::of(method, std::iter::empty()),
        marks,
    };
    let mean = bins.iter().map(|b| mark(b, b.mae, size(b.count, most))).collect();
    let rmse = bins.iter().map(|b| mark(b, b.rmse, SMALLEST)).collect();
    let mut band: Vec<[f64; 2]> = bins.iter().map(|b| [b.epsilon, b.p95]).collect();
    band.extend(bins.iter().rev().map(|b| [b.epsilon, 0.0]));
    Chart {
        label: "true error of cones against epsilon",
        x: Axis::from_zero("epsilon of the cone", bins.iter().map(|b| b.epsilon)),
        y: Axis::from_zero(
            "true absolute error of the cone",
            bins.iter().map(|b| b.p95.max(b.rmse).max(b.mae)),
        ),
        series: vec![series("mean absolute error", "rays", mean), series("RMSE", "rays-random", rmse)],
        diagonal: true,
        band: Some((band, "95 % are below")),
    }
    .draw()
}

/// Expected against true error, one curve a method at the middle one of its efforts.
pub(super) fn estimates(case: &CaseReport) -> String {
    let names = || case.trials.iter().map(|t| t.method.as_str());
    let series: Vec<Series> = middle_efforts(&case.calibration)
        .into_iter()
        .map(|calibration| Series {
            name: format!("{}, {}", calibration.method, calibration.label),
            style: Style::of(&calibration.method, names()),
            marks: marks(calibration),
        })
        .collect();
    let both = || series.iter().flat_map(|s| &s.marks).flat_map(|m| [m.x, m.y]);
    match Axis::logarithmic("expected error (RMS of the bin)", both()) {
        Some(x) => {
            let y = x.titled("true error (RMS of the bin)");
            let label = "true error against expected error of estimates";
            Chart { label, x, y, series, diagonal: true, band: None }.draw()
        }
        None => empty("No method here says what error it expects."),
    }
}

fn marks(calibration: &EstimateCalibration) -> Vec<Mark> {
    let most = calibration.bins.iter().map(|b| b.count).max().unwrap_or(1);
    calibration
        .bins
        .iter()
        .map(|bin| Mark {
            x: bin.expected,
            y: bin.actual,
            spread: None,
            size: size(bin.count, most).min(1.4 * Mark::SIZE),
            title: format!(
                "{}, {}: {} points expect {} and have {}",
                calibration.method,
                calibration.label,
                bin.count,
                figures(bin.expected),
                figures(bin.actual)
            ),
        })
        .collect()
}

/// For each method, in order, the middle one of its efforts.
fn middle_efforts(all: &[EstimateCalibration]) -> Vec<&EstimateCalibration> {
    let mut methods: Vec<(&str, Vec<&EstimateCalibration>)> = Vec::new();
    for calibration in all {
        match methods.iter_mut().find(|m| m.0 == calibration.method) {
            Some(method) => method.1.push(calibration),
            None => methods.push((&calibration.method, vec![calibration])),
        }
    }
    methods.into_iter().map(|(_, efforts)| efforts[efforts.len() / 2]).collect()
}

fn size(count: usize, most: usize) -> f64 {
    (LARGEST * (count as f64 / most.max(1) as f64).sqrt()).max(SMALLEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_go_with_counts() {
        assert_eq!(size(100, 100), LARGEST);
        assert!((size(25, 100) - LARGEST / 2.0).abs() < 1e-12);
        assert_eq!((size(0, 100), size(0, 0)), (SMALLEST, SMALLEST));
    }
}
