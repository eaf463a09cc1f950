//! Ranges are kept, and names are those of the program.

use super::*;

#[test]
fn defaults_are_valid() {
    AoSettings::default().validate().unwrap();
}

#[test]
fn each_setting_out_of_range_is_named_with_its_range() {
    let ok = AoSettings::default;
    let cases = [
        (AoSettings { distance: Distance::World(-1.0), ..ok() }, "distance"),
        (AoSettings { distance: Distance::World(f32::NAN), ..ok() }, "distance"),
        (AoSettings { distance: Distance::Infinite, falloff: Falloff::Linear, ..ok() }, "falloff"),
        (AoSettings { rays: Some(0), ..ok() }, "rays"),
        (AoSettings { rays: Some(u32::MAX), ..ok() }, "rays"),
        (AoSettings { time: Some(0.0), ..ok() }, "time"),
        (AoSettings { time: Some(-1.0), ..ok() }, "time"),
        (AoSettings { time: Some(f64::NAN), ..ok() }, "time"),
        (AoSettings { time: Some(f64::INFINITY), ..ok() }, "time"),
        (AoSettings { time: Some(1.0), method: Method::Cones, ..ok() }, "time"),
        (AoSettings { error: Some(0.0), ..ok() }, "error"),
        (AoSettings { error: Some(-0.02), ..ok() }, "error"),
        (AoSettings { error: Some(f32::NAN), ..ok() }, "error"),
        (AoSettings { error: Some(0.6), ..ok() }, "error"),
        (AoSettings { error: Some(0.02), method: Method::Paper, ..ok() }, "error"),
        (AoSettings { spread: 0.0, ..ok() }, "spread"),
        (AoSettings { spread: 180.5, ..ok() }, "spread"),
        (AoSettings { spread: 90.0, method: Method::Cones, ..ok() }, "spread"),
        (AoSettings { bias_angle: -1.0, ..ok() }, "bias-angle"),
        (AoSettings { bias_angle: f32::NAN, ..ok() }, "bias-angle"),
        (AoSettings { bias_angle: 5.0, method: Method::Paper, ..ok() }, "bias-angle"),
        (AoSettings { sampling: Sampling::Stratified, ..ok() }, "sampling"),
        (AoSettings { sampling: Sampling::Stratified, rays: Some(4), time: Some(1.0), ..ok() }, "sampling"),
        (AoSettings { voxels: 500, ..ok() }, "voxels"),
        (AoSettings { voxels: 4096, ..ok() }, "voxels"),
        (AoSettings { cones: 7, ..ok() }, "cones"),
        (AoSettings { beta: -0.1, ..ok() }, "beta"),
        (AoSettings { beta: f32::NAN, ..ok() }, "beta"),
        (AoSettings { gamma: 1.5, ..ok() }, "gamma"),
        (AoSettings { max_rays: 0, ..ok() }, "max-rays"),
    ];
    for (settings, option) in cases {
        let error = settings.validate().unwrap_err();
        assert_eq!(error.option, option);
        assert!(error.to_string().starts_with(&format!("--{option} ")), "{error}");
        assert!(!error.expected.is_empty());
    }
}

#[test]
fn names_of_methods_are_read_back() {
    for method in Method::ALL {
        assert_eq!(method.to_string().parse(), Ok(method));
    }
    assert!("cone".parse::<Method>().is_err());
}

#[test]
fn names_of_samplings_are_read_back_and_are_those_of_files() {
    for sampling in Sampling::ALL {
        let name = sampling.to_string();
        assert_eq!(name.parse(), Ok(sampling));
        assert_eq!(serde_json::to_value(sampling).unwrap(), serde_json::Value::String(name));
    }
    assert!("halton".parse::<Sampling>().is_err());
}

#[test]
fn without_a_budget_the_error_that_is_hardly_seen_is_the_goal() {
    use crate::Budget;
    let all = *limits::RAYS.end();
    let ok = AoSettings::default;
    let cases = [
        (ok(), Budget { rays: all, seconds: None, error: Some(0.02) }),
        (AoSettings { rays: Some(7), ..ok() }, Budget::rays(7)),
        (AoSettings { time: Some(2.0), ..ok() }, Budget { rays: all, seconds: Some(2.0), error: None }),
        (AoSettings { error: Some(0.1), ..ok() }, Budget { rays: all, seconds: None, error: Some(0.1) }),
        (
            AoSettings { rays: Some(7), time: Some(2.0), error: Some(0.1), ..ok() },
            Budget { rays: 7, seconds: Some(2.0), error: Some(0.1) },
        ),
    ];
    for (settings, budget) in cases {
        settings.validate().unwrap();
        assert_eq!(Budget::of(&settings), budget);
    }
}
