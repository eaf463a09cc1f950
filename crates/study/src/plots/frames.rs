//! Figure 5 of the paper: error against frames of the blend, beside rays and cones.

use super::{
    axis::Axis,
    chart::{Chart, Mark, Series},
    empty, figures,
    style::Style,
};
use crate::{
    curve,
    report::{CaseReport, TrialReport},
};

/// Cones march once, so that their error is the same in every frame; `rays` trace as many a frame as the blend in its first.
pub(super) fn draw(case: &CaseReport) -> String {
    let of = |method: &'static str| {
        let complete = move |t: &&TrialReport| t.method == method && t.quality.rmse.is_finite();
        case.trials.iter().filter(complete)
    };
    let blend: Vec<&TrialReport> = of("paper").collect();
    let Some(first) = blend.iter().min_by_key(|t| t.effort) else {
        return empty("The blend did not take part, so that there are no frames to show.");
    };
    let series = |name: &str, method: &str, marks| Series {
        name: name.into(),
        style: Style::of(method, std::iter::empty()),
        marks,
    };
    let frames: Vec<f64> = blend.iter().map(|t| f64::from(t.effort)).collect();
    let mark = |frames: f64, rmse: f64, what: &str| {
        let title = format!("{what}, {frames} frames: RMSE {}", figures(rmse));
        Mark { x: frames, y: rmse, spread: None, size: Mark::SIZE, title }
    };
    let mut all = vec![series(
        "paper",
        "paper",
        blend.iter().map(|t| mark(f64::from(t.effort), t.quality.rmse, "paper")).collect(),
    )];
    // As many cones as the blend marches, if they were tried.
    let same = |t: &&TrialReport| (t.cones - first.cones).abs() < 0.5;
    if let Some(cones) = of("cones").find(same).or_else(|| of("cones").find(|t| t.effort == 16)) {
        let name = format!("cones, {}", cones.label);
        let marks = frames.iter().map(|f| mark(*f, cones.quality.rmse, &name)).collect();
        all.push(series(&name, "cones", marks));
    }
    let known: Vec<(f64, f64)> = of("rays").map(|t| (t.rays, t.quality.rmse)).collect();
    let name = format!("rays, {} a frame", figures(first.rays));
    let marks: Vec<Mark> =
        frames.iter().filter_map(|f| Some(mark(*f, curve::at(&known, f * first.rays)?, &name))).collect();
    if !marks.is_empty() {
        all.push(series(&name, "rays", marks));
    }

    let x = Axis::logarithmic("frames", frames);
    let y = Axis::logarithmic("RMSE of visibility", all.iter().flat_map(|s| &s.marks).map(|m| m.y));
    match (x, y) {
        (Some(x), Some(y)) => {
            let label = "RMSE against frames of the blend";
            Chart { label, x, y, series: all, diagonal: false, band: None }.draw()
        }
        _ => empty("No frame has an error above 0 to show here."),
    }
}
