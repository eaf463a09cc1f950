//! Figures beyond the paper.

use super::{Album, captions, gallery, plot};
use crate::report::{Figure, PlotKind};

pub(super) fn figures(album: &mut Album<'_>) -> Vec<Figure> {
    let report = album.report;
    let mut figures = vec![
        plot(
            "by-time",
            "Error by time",
            PlotKind::RmseByTime,
            "RMSE against the time of the estimation alone, builds left out. A filter's time counts with its rays'.".into(),
            captions::by_time(report),
        ),
        plot(
            "by-time-built",
            "Error by time, builds counted",
            PlotKind::RmseByTimeWithBuilds,
            "The same with the BVH and the octree that each method needs, as for a single picture of a new scene.".into(),
            captions::builds(report),
        ),
        plot(
            "by-rays",
            "Error by rays",
            PlotKind::RmseByRays,
            "RMSE against rays per point: what a method makes of its rays, whatever the rest of it costs. Cones trace none and are left out.".into(),
            String::new(),
        ),
        plot(
            "flip",
            "Seen error by time",
            PlotKind::FlipByTime,
            "Mean FLIP, which weighs errors as eyes do: blotches and fireflies stand out where RMSE hides them.".into(),
            String::new(),
        ),
        plot("bias", "Bias by time", PlotKind::BiasByTime, captions::bias(report), String::new()),
        plot(
            "cone-calibration",
            "Does epsilon tell the error of a cone?",
            PlotKind::ConeCalibration,
            captions::cone_calibration(report),
            String::new(),
        ),
        plot(
            "estimate-calibration",
            "Do methods know their error?",
            PlotKind::EstimateCalibration,
            captions::estimate_calibration(report),
            String::new(),
        ),
    ];
    figures.extend(error_maps(album));
    figures
}

/// Expected and true error of rays, the hybrid and the blend side by side.
fn error_maps(album: &mut Album<'_>) -> Option<Figure> {
    let evidence = album.evidence;
    let middle = |method| evidence.trials_of(method).nth(evidence.trials_of(method).count() / 2);
    let blend = evidence.trial("paper", 1);
    let mut panels = Vec::new();
    for (stem, trial) in [("rays", middle("rays")), ("hybrid", middle("hybrid")), ("paper", blend)] {
        let Some(trial) = trial else { continue };
        let Some(expected) = &trial.answer.expected_error else { continue };
        let actual: Vec<f32> = trial
            .answer
            .visibility
            .iter()
            .zip(&evidence.truth.visibility)
            .map(|(v, t)| (v - t).abs())
            .collect();
        let most = scale(expected).max(scale(&actual));
        let label = format!("{stem}, {}, 0 to {most}", trial.effort.label);
        panels.push(album.heat(
            &format!("{stem}-expected"),
            format!("{label}: expected error"),
            expected,
            most,
        ));
        panels.push(album.heat(&format!("{stem}-actual"), format!("{label}: true error"), &actual, most));
    }
    let caption = "Expected and true absolute error, dark is none. The expected error is a standard deviation, \
                   so the true one scatters about it; where it stays dark and the truth is bright, the method does not know that it is wrong.";
    (!panels.is_empty()).then(|| gallery("error-maps", "Error maps", panels, caption.into()))
}

/// The 95th percentile, rounded up to a hundredth, or where it is small to a thousandth: what is brighter is white.
fn scale(values: &[f32]) -> f32 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    let high = sorted.get(sorted.len() * 95 / 100).copied().unwrap_or(0.0);
    let steps = if high > 0.02 { 100.0 } else { 1000.0 };
    ((steps * high).ceil() / steps).clamp(0.001, 1.0)
}
