//! Plots of a case as inline SVG: coloured by the page's style sheet, readable at 360 pixels, with the numbers on each mark.

mod axis;
mod calibration;
mod chart;
mod curves;
mod frames;
mod legend;
mod style;

use crate::{
    report::{CaseReport, PlotKind},
    svg::{Svg, escape},
};
use curves::Curve;
use style::Style;

/// The plot, or a sentence where there is nothing to draw. Fit to be put into a page as it is.
pub(crate) fn draw(kind: PlotKind, case: &CaseReport) -> String {
    match kind {
        PlotKind::RmseByFrames => frames::draw(case),
        PlotKind::RmseByTime => Curve::rmse_by_time().draw(case),
        PlotKind::RmseByTimeWithBuilds => Curve::rmse_by_time_with_builds().draw(case),
        PlotKind::RmseByRays => Curve::rmse_by_rays().draw(case),
        PlotKind::FlipByTime => Curve::flip_by_time().draw(case),
        PlotKind::BiasByTime => Curve::bias_by_time().draw(case),
        PlotKind::ConeCalibration => calibration::cones(case),
        PlotKind::EstimateCalibration => calibration::estimates(case),
    }
}

/// Line and marker of a method as in the plots, for tables; `all` are the methods beside it.
pub(crate) fn sample<'a>(method: &str, all: impl IntoIterator<Item = &'a str>) -> String {
    let style = Style::of(method, all);
    let mut svg = Svg::new();
    svg.group(&style.class(), None);
    svg.polyline("curve", &[[1.0, 8.0], [29.0, 8.0]], style.dash());
    style.mark(&mut svg, [15.0, 8.0], chart::Mark::SIZE);
    svg.finish_as("sample", 30.0, 16.0, method)
}

fn empty(why: &str) -> String {
    format!(r#"<p class="empty">{}</p>"#, escape(why))
}

/// A number to three digits: `0.0123`, `4.2`, `1.2e-7`. What is no number is a dash.
pub(crate) fn figures(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let size = value.abs();
    if !(1e-4..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    // Rounding may carry into one more digit, as of 0.9996; the number of decimals then follows the rounded value.
    let digits = |v: f64| (2 - v.log10().floor() as i32).max(0);
    let scale = 10f64.powi(digits(size));
    let decimals = digits((size * scale).round() / scale);
    format!("{value:.*}", usize::try_from(decimals).unwrap_or(0))
}

#[cfg(test)]
mod tests;
