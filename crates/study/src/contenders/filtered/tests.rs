//! The filter as a contender, and its search.

use super::*;
use crate::{Pilot, testing::test_case};

/// Prepared for the budgets, with the truth.
fn prepared(case: &Case, budgets: &[u32]) -> (Filtered, Vec<f32>) {
    let truth = trace(case, 1024, Sampling::Stratified, Control::none()).unwrap().visibility;
    let mut contender = Filtered::default();
    let pilot = Pilot { points: Vec::new() };
    let (settings, control) = (&case.settings, Control::none());
    contender
        .prepare(&Preparation { case, truth: &truth, pilot: &pilot, budgets, settings, control })
        .unwrap();
    (contender, truth)
}

#[test]
fn the_filter_gains_and_is_never_worse_than_its_rays() {
    let case = test_case(48);
    let budgets = [1, 4, 64];
    let (contender, truth) = prepared(&case, &budgets);
    for rays in budgets {
        let filtered = contender.run(&case, rays, Control::none()).unwrap();
        let plain = trace(&case, rays, Sampling::Sobol, Control::none()).unwrap();
        let (after, before) = (rmse(&filtered.visibility, &truth), rmse(&plain.visibility, &truth));
        assert!(after <= before, "{rays}: {after} {before}");
        assert!(rays > 4 || after < 0.6 * before, "{rays}: {after} {before}");
        assert_eq!((filtered.rays, filtered.expected_error), (plain.rays, None));
        assert!(contender.chosen(rays).contains_key("levels"));
    }
}

#[test]
fn without_settings_it_says_so() {
    let error = Filtered::default().run(&test_case(8), 4, Control::none()).unwrap_err();
    assert_eq!(error.to_string(), "rays-filtered: no settings were found for 4 rays");
}

#[test]
fn the_search_finds_the_bottom_of_a_bowl_and_obeys_its_limit() {
    let aim = [5usize, 1, 4, 0];
    let bowl = |choice: Choice| {
        let far: usize = choice.at.iter().zip(aim).map(|(a, b)| a.abs_diff(b)).sum();
        (far as f64, 2)
    };
    let found = search(Choice::START, 100, &mut { bowl });
    assert_eq!(found, Choice { levels: 2, at: aim });
    let mut asked = 0;
    let short = search(Choice::START, 5, &mut |choice| {
        asked += 1;
        bowl(choice)
    });
    assert_eq!(asked, 5);
    assert_ne!(short.at, aim, "the limit must matter");
}
