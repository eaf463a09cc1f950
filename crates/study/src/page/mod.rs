//! The page: one HTML file that holds everything it shows, a view of the report and nothing more.

mod filters;
mod png_size;
mod summary;
mod trials;

use crate::{
    Report, StudyError,
    plots::{self, sample},
    report::{CaseReport, Content, EstimateCalibration, Panel},
};
use base64::{Engine, prelude::BASE64_STANDARD};
use minijinja::{
    AutoEscape, Environment, UndefinedBehavior, Value, context, syntax::SyntaxConfig, value::Serde,
};
use serde::Serialize;
use std::collections::BTreeMap;

/// The name that errors carry.
const NAME: &str = "report.html";

/// Below this width in pixels a picture is shown with its pixels as squares: it is enlarged, and smoothing would invent.
const SMALL: u32 = 300;

/// The page of a report; `pictures` holds the PNG of each file that its panels name.
///
/// # Errors
/// [`StudyError::Output`] where a panel's picture is missing.
pub(crate) fn page(report: &Report, pictures: &BTreeMap<String, Vec<u8>>) -> Result<String, StudyError> {
    let cases = report.cases.iter().map(|case| case_view(case, pictures)).collect::<Result<Vec<_>, _>>()?;
    let shown = context! {
        report => serialised(report),
        cases,
        samples => samples(report.methods.iter().map(|m| m.name.as_str())),
        summary => serialised(summary::of(report)),
        style => safe(include_str!("style.css").into()),
        script => safe(include_str!("script.js").into()),
    };
    render(shown).map_err(|error| broken(NAME, &error.to_string()))
}

fn render(shown: Value) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    filters::add(&mut environment);
    environment.add_template(NAME, include_str!("report.html"))?;
    environment.get_template(NAME)?.render(shown)
}

/// What the template needs of a case beyond its report.
fn case_view(case: &CaseReport, pictures: &BTreeMap<String, Vec<u8>>) -> Result<Value, StudyError> {
    let mut figures = Vec::new();
    for figure in &case.figures {
        let (panels, plot) = match &figure.content {
            Content::Pictures(panels) => (panel_views(panels, pictures)?, None),
            Content::Plot(kind) => (Vec::new(), Some(safe(plots::draw(*kind, case)))),
        };
        figures.push(context! { panels, plot, figure => serialised(figure) });
    }
    let mut failures = Vec::new();
    for failure in &case.failures {
        let panels = panel_views(&failure.panels, pictures)?;
        failures.push(context! { panels, failure => serialised(failure) });
    }
    Ok(context! {
        case => serialised(case),
        figures,
        failures,
        samples => samples(case.trials.iter().map(|t| t.method.as_str())),
        trials => serialised(trials::rows(case)),
        calibration => calibration(&case.calibration),
    })
}

fn panel_views(panels: &[Panel], pictures: &BTreeMap<String, Vec<u8>>) -> Result<Vec<Value>, StudyError> {
    let view = |panel: &Panel| {
        let bytes = pictures
            .get(&panel.file)
            .ok_or_else(|| broken(&panel.file, "the report shows this picture, but it was not made"))?;
        let (width, height) = png_size::of(bytes).unwrap_or((0, 0));
        // Letters, digits, `+`, `/` and `=` need no escaping, and escaping would make the page longer.
        let source = safe(format!("data:image/png;base64,{}", BASE64_STANDARD.encode(bytes)));
        Ok(context! { label => panel.label.as_str(), source, width, height, small => width < SMALL })
    };
    panels.iter().map(view).collect()
}

/// One row a method, its efforts in order.
fn calibration(all: &[EstimateCalibration]) -> Vec<Value> {
    let mut rows: Vec<(&str, Vec<&EstimateCalibration>)> = Vec::new();
    for one in all {
        match rows.iter_mut().find(|r| r.0 == one.method) {
            Some(row) => row.1.push(one),
            None => rows.push((&one.method, vec![one])),
        }
    }
    rows.into_iter().map(|(method, efforts)| context! { method, efforts => serialised(efforts) }).collect()
}

/// Line and marker of each method, as in the plots.
fn samples<'a>(names: impl Iterator<Item = &'a str> + Clone) -> BTreeMap<String, Value> {
    names.clone().map(|name| (name.to_owned(), safe(sample(name, names.clone())))).collect()
}

fn serialised(value: impl Serialize) -> Value {
    Value::from(Serde(&value))
}

fn safe(text: String) -> Value {
    Value::from_safe_string(text)
}

fn broken(path: &str, reason: &str) -> StudyError {
    StudyError::Output { path: path.into(), reason: reason.into() }
}

#[cfg(test)]
mod tests;
