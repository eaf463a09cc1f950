//! The parts of the methods that need no scene.

use super::{paper, point_rays::Tally};
use crate::{AoPlan, AoSettings, Epsilon, Method, merge};
use conray_core::{Bounds, Estimate, Vec3};
use conray_voxel::ConeResult;

fn plan(beta: f32, gamma: f32) -> AoPlan {
    let settings = AoSettings { beta, gamma, ..AoSettings::default() };
    AoPlan::new(&settings, Bounds { min: Vec3::ZERO, max: Vec3::ONE }).unwrap()
}

#[test]
fn the_share_of_a_cone_follows_equation_1_and_stays_within_its_range() {
    let plan = plan(10.0, 0.02);
    let share = |error, plan: &AoPlan| paper::cone_share(&ConeResult { visibility: 0.5, error }, plan);
    assert_eq!(share(0.0, &plan), 1.0);
    assert_eq!(share(0.02, &plan), 1.0);
    assert!((share(0.12, &plan) - (-1.0f32).exp()).abs() < 1e-6);
    assert_eq!(share(f32::INFINITY, &plan), 0.0, "an unusable cone is left to rays");
    let shares: Vec<f32> = (0..100).map(|i| share(i as f32 / 50.0, &plan)).collect();
    assert!(shares.windows(2).all(|w| w[1] <= w[0]));
    // Half open: the error of marching is one half.
    let marching = AoPlan { epsilon: Epsilon::Marching, ..plan };
    assert!((share(0.0, &marching) - (-4.8f32).exp()).abs() < 1e-6);
}

#[test]
fn rays_follow_equation_2_rounded() {
    let counts = |alpha| paper::ray_count(alpha, 8);
    assert_eq!([counts(1.0), counts(0.95), counts(0.9), counts(0.5), counts(0.0)], [0, 0, 1, 4, 8]);
}

#[test]
fn a_tally_knows_its_mean_and_never_claims_certainty() {
    let mut tally = Tally::default();
    assert_eq!(tally.mean(), 0.0);
    for i in 0..100 {
        tally.add(if i < 30 { 1.0 } else { 0.0 }, Vec3::Z);
    }
    assert!((tally.mean() - 0.3).abs() < 1e-6);
    assert!((tally.open - Vec3::Z * 30.0).length() < 1e-4);
    // Near the binomial p (1 - p) / n.
    assert!((tally.variance_of_mean() / (0.3 * 0.7 / 100.0) - 1.0).abs() < 0.05);
    let mut agreed = Tally::default();
    (0..4).for_each(|_| agreed.add(1.0, Vec3::Z));
    assert!(agreed.variance_of_mean() > 0.0);
}

#[test]
fn merging_weighs_by_samples_and_errors_add_as_independent() {
    let estimate = |visibility, error, rays| Estimate { visibility, error, rays, bent: Vec3::Z, cone: None };
    let merged = merge(&estimate(1.0, 0.2, 1), 1, &estimate(0.0, 0.1, 3), 3);
    assert_eq!((merged.visibility, merged.rays), (0.25, 4));
    assert!((merged.error - (0.05f32 * 0.05 + 0.075 * 0.075).sqrt()).abs() < 1e-6);
    let pending = Estimate::PENDING;
    assert_eq!(merge(&pending, 0, &estimate(0.5, 0.1, 2), 2).visibility, 0.5);
    assert_eq!(merge(&estimate(0.5, 0.1, 2), 2, &pending, 2).visibility, 0.5);
}

#[test]
fn a_plan_is_in_world_units() {
    let bounds = Bounds { min: Vec3::ZERO, max: Vec3::new(30.0, 40.0, 0.0) };
    let plan = AoPlan::new(&AoSettings::default(), bounds).unwrap();
    assert_eq!(plan.distance, 5.0);
    assert!(AoPlan::new(&AoSettings::default(), Bounds::EMPTY).is_err(), "no size, no automatic distance");
    assert_eq!(plan.samples(), plan.budget.rays);
}

#[test]
fn settings_survive_json() {
    let settings =
        AoSettings { distance: 2.5.into(), cones: 9, method: Method::Paper, ..AoSettings::default() };
    let json = serde_json::to_string(&settings).unwrap();
    assert_eq!(serde_json::from_str::<AoSettings>(&json).unwrap(), settings);
    assert!(json.contains("\"max-rays\""), "names are those of the program's options: {json}");
    assert!(serde_json::from_str::<AoSettings>(r#"{"rays": 8, "distance": "inf"}"#).is_ok());
    assert!(serde_json::from_str::<AoSettings>(r#"{"ray": 8}"#).is_err(), "unknown settings are refused");
}
