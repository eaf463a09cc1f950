use super::*;
use crate::fixture;
use proptest::prelude::*;
use roxmltree::Document;

const KINDS: [PlotKind; 8] = [
    PlotKind::RmseByFrames,
    PlotKind::RmseByTime,
    PlotKind::RmseByTimeWithBuilds,
    PlotKind::RmseByRays,
    PlotKind::FlipByTime,
    PlotKind::BiasByTime,
    PlotKind::ConeCalibration,
    PlotKind::EstimateCalibration,
];

fn case() -> CaseReport {
    fixture::report().cases.remove(0)
}

fn count(document: &Document<'_>, class: &str) -> usize {
    document.descendants().filter(|n| n.attribute("class") == Some(class)).count()
}

/// Every coordinate is a number inside the drawing.
fn check(kind: PlotKind, text: &str) {
    let document = Document::parse(text).unwrap_or_else(|e| panic!("{kind:?}: {e}: {text}"));
    let root = document.root_element();
    if root.has_tag_name("p") {
        assert!(root.text().is_some_and(|t| t.ends_with('.')), "{kind:?}");
        return;
    }
    let size: Vec<f64> = root.attribute("viewBox").unwrap().split(' ').map(|v| v.parse().unwrap()).collect();
    let (mut points, mut outside) = (0, Vec::new());
    for node in document.descendants() {
        let number = |name: &str| node.attribute(name).map(|v| v.parse::<f64>().unwrap());
        let mut places: Vec<(f64, f64)> = [("x", "y"), ("x1", "y1"), ("x2", "y2"), ("cx", "cy")]
            .into_iter()
            .filter_map(|(x, y)| Some((number(x)?, number(y)?)))
            .collect();
        for pair in node.attribute("points").unwrap_or("").split_whitespace() {
            let (x, y) = pair.split_once(',').unwrap();
            places.push((x.parse().unwrap(), y.parse().unwrap()));
        }
        points += places.len();
        outside.extend(
            places
                .into_iter()
                .filter(|p| !(-1.0..=size[2] + 1.0).contains(&p.0) || !(-1.0..=size[3] + 1.0).contains(&p.1)),
        );
    }
    assert!(points > 8, "{kind:?}: nothing is drawn");
    assert!(outside.is_empty(), "{kind:?}: {outside:?} outside {size:?}");
}

#[test]
fn every_plot_of_the_fixture_is_drawn() {
    for kind in KINDS {
        let text = draw(kind, &case());
        assert!(text.starts_with("<svg"), "{kind:?}: {text}");
        check(kind, &text);
    }
}

#[test]
fn the_check_of_places_catches_one_outside() {
    let text = draw(PlotKind::RmseByTime, &case()).replacen("x1=\"", "x1=\"9", 1);
    assert!(std::panic::catch_unwind(|| check(PlotKind::RmseByTime, &text)).is_err());
}

#[test]
fn every_trial_is_a_mark_with_its_numbers() {
    let case = case();
    let text = draw(PlotKind::RmseByTime, &case);
    let document = Document::parse(&text).unwrap();
    let titles: Vec<&str> =
        document.descendants().filter(|n| n.has_tag_name("title")).filter_map(|n| n.text()).collect();
    assert_eq!(titles.len(), case.trials.len());
    for trial in &case.trials {
        let start = format!("{}, {}: RMSE {}", trial.method, trial.label, figures(trial.quality.rmse));
        assert_eq!(titles.iter().filter(|t| t.starts_with(&start)).count(), 1, "{start}");
    }
    // Every spread is a bar; the legend names every method once.
    assert_eq!(count(&document, "spread"), case.trials.len());
    let methods = case.trials.iter().map(|t| &t.method).collect::<std::collections::BTreeSet<_>>();
    assert_eq!(count(&document, "legend"), methods.len());
}

#[test]
fn a_lower_error_is_drawn_lower() {
    let mut case = case();
    case.trials.retain(|t| t.method == "rays");
    let height = |text: &str| {
        let document = Document::parse(text).unwrap();
        let curve = document.descendants().find(|n| n.attribute("class") == Some("curve")).unwrap();
        let last = curve.attribute("points").unwrap().split(' ').next_back().unwrap().to_owned();
        last.split_once(',').unwrap().1.parse::<f64>().unwrap()
    };
    let before = height(&draw(PlotKind::RmseByTime, &case));
    let last = case.trials.len() - 1;
    case.trials[last].quality.rmse = case.trials[0].quality.rmse;
    assert!(height(&draw(PlotKind::RmseByTime, &case)) < before);
}

#[test]
fn zero_is_marked_at_the_edge() {
    let mut case = case();
    let edges = |case: &CaseReport| {
        let text = draw(PlotKind::BiasByTime, case);
        count(&Document::parse(&text).unwrap(), "mark clamped")
    };
    for trial in &mut case.trials {
        trial.quality.relative_bias = 0.01;
    }
    assert_eq!(edges(&case), 0);
    case.trials[3].quality.relative_bias = 0.0;
    assert_eq!(edges(&case), 1);
}

#[test]
fn nothing_to_draw_is_said_in_a_sentence() {
    let mut case = case();
    case.trials.clear();
    case.calibration.clear();
    case.cones = crate::report::ConeReport::default();
    for kind in KINDS {
        let text = draw(kind, &case);
        assert!(text.starts_with("<p class=\"empty\">"), "{kind:?}: {text}");
        check(kind, &text);
    }
}

#[test]
fn numbers_have_three_digits() {
    let shown = [0.012_345, 4.2, 123.4, 1234.6, 0.999_6, 9.996, -0.5, 1.234e-7, 0.0, f64::NAN].map(figures);
    let wanted = ["0.0123", "4.20", "123", "1235", "1.00", "10.0", "-0.500", "1.23e-7", "0", "–"];
    assert_eq!(shown, wanted);
}

/// Numbers as a broken study might have them.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(f64::NAN), Just(f64::INFINITY), any::<f64>(), 1e-6..1e3f64]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn any_numbers_and_names_are_drawn_or_said(
        numbers in prop::collection::vec([any_number(), any_number(), any_number(), any_number()], 1..8),
        methods in prop::collection::vec(prop_oneof!["rays", "cones", "paper", ".*"], 1..4),
        effort in 0u32..5,
    ) {
        let mut case = case();
        case.trials.truncate(numbers.len());
        case.calibration.truncate(numbers.len());
        case.cones.epsilon.truncate(numbers.len());
        for (i, [a, b, c, d]) in numbers.into_iter().enumerate() {
            if let Some(trial) = case.trials.get_mut(i) {
                trial.method = methods[i % methods.len()].clone();
                trial.label = trial.method.clone();
                trial.effort = effort + i as u32;
                (trial.rays, trial.cones) = (a, b);
                (trial.quality.rmse, trial.quality.flip, trial.quality.relative_bias) = (b, c, d);
                (trial.timing.seconds, trial.timing.min_seconds) = (a, c);
                (trial.timing.max_seconds, trial.timing.seconds_with_builds) = (d, b);
            }
            if let Some(calibration) = case.calibration.get_mut(i) {
                calibration.method = methods[i % methods.len()].clone();
                calibration.bins.truncate(1 + i);
                for bin in &mut calibration.bins {
                    (bin.expected, bin.actual, bin.count) = (a, b, i);
                }
            }
            if let Some(bin) = case.cones.epsilon.get_mut(i) {
                (bin.epsilon, bin.mae, bin.rmse, bin.p95, bin.count) = (a, b, c, d, i);
            }
        }
        for kind in KINDS {
            check(kind, &draw(kind, &case));
        }
    }
}
