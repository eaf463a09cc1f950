//! Slices cover every ray once, means are means, and a file holds every bit.

use super::*;
use conray_core::hash_u32;
use proptest::prelude::*;

/// A visibility by a formula of half, point and first ray.
fn visibility(half: usize, point: usize, ray: u32) -> f32 {
    let hash = hash_u32(ray ^ hash_u32(point as u32 ^ hash_u32(half as u32)));
    (hash >> 8) as f32 / (1 << 24) as f32
}

/// Carries out that many slices; the second part of what comes back is each slice.
fn advance(state: &mut State, points: usize, most: u32, slices: usize) -> Vec<(usize, Range<u32>)> {
    let step = |state: &mut State| {
        let (half, range) = state.next_slice(most);
        let rays = range.end - range.start;
        state.add(half, rays, (0..points).map(|point| visibility(half, point, range.start)));
        (half, range)
    };
    (0..slices).map(|_| step(state)).collect()
}

fn fingerprint() -> Fingerprint {
    Fingerprint::of(|feed| feed.text("state"))
}

proptest! {
    #[test]
    fn slices_cover_each_half_once_and_make_its_mean(slice_log in 0u32..8, slices in 1usize..60) {
        let points = 3;
        let mut state = State::new(points);
        let done = advance(&mut state, points, 1 << slice_log, slices);
        for half in 0..2 {
            let ranges: Vec<_> = done.iter().filter(|(h, _)| *h == half).map(|(_, range)| range.clone()).collect();
            let mut end = 0;
            for range in &ranges {
                prop_assert_eq!(range.start, end);
                prop_assert!(range.end > range.start && range.end - range.start <= 1 << slice_log);
                end = range.end;
            }
            prop_assert_eq!(state.halves[half].rays, end);
            for point in 0..points {
                let sum: f64 = ranges
                    .iter()
                    .map(|r| f64::from(visibility(half, point, r.start)) * f64::from(r.end - r.start))
                    .sum();
                let mean = sum / f64::from(end.max(1));
                prop_assert!((state.halves[half].means[point] - mean).abs() < 1e-12);
            }
        }
        let [a, b] = [state.halves[0].rays, state.halves[1].rays];
        prop_assert!(a >= b && a - b <= 1 << slice_log);
        prop_assert!(state.is_sound(points) && !state.is_sound(points + 1));
    }

    #[test]
    fn a_file_holds_every_bit_after_any_slice(slice_log in 0u32..8, slices in 0usize..60) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state.kept");
        let mut state = State::new(5);
        advance(&mut state, 5, 1 << slice_log, slices);
        state.write(&path, fingerprint()).unwrap();
        let mut read = State::read(&path, fingerprint(), 5).unwrap().unwrap();
        prop_assert_eq!(&read, &state);
        let more = [&mut read, &mut state].map(|state| advance(state, 5, 1 << slice_log, 9));
        prop_assert_eq!(&more[0], &more[1]);
        prop_assert_eq!(read, state);
    }

    #[test]
    fn forecasts_lie_between_the_next_rung_and_the_last(
        slices in 0usize..20,
        error in prop_oneof![Just(0.0), 1e-12f64..10.0],
        most_log in 5u32..22,
    ) {
        let mut state = State::new(4);
        advance(&mut state, 4, 4096, slices);
        let foreseen = state.foreseen_rays(error, 1 << most_log);
        prop_assert!(foreseen <= 1 << most_log);
        prop_assert!(foreseen >= (2 * state.rung_rays()).min(1 << most_log));
    }
}

#[test]
fn the_error_of_known_halves_is_known() {
    // Differences of 0.5 and 0.25 beside two of none: half of the root of their mean square.
    let mut state = State::new(4);
    state.add(0, 16, [1.0, 0.5, 0.25, 0.0].into_iter());
    assert_eq!(state.answer(1.0, 32, 32), None, "one half alone says nothing");
    state.add(1, 16, [0.5, 0.75, 0.25, 0.0].into_iter());
    let truth = state.answer(1.0, 32, 32).unwrap();
    let expected = 0.5 * ((0.25f64 + 0.0625) / 4.0).sqrt();
    assert!((truth.error - expected).abs() < 1e-7, "{}", truth.error);
    assert_eq!((truth.visibility, truth.rays), (vec![0.75, 0.625, 0.25, 0.0], 32));
    assert_eq!(state.answer(0.9 * expected, 32, 64), None, "not good enough, and more rays are allowed");
    assert!(state.answer(0.9 * expected, 32, 32).is_some(), "no more rays are allowed");
    assert_eq!(state.answer(1.0, 64, 64), None, "too few rays");
}

/// Damage whose checksum fits.
type Change = fn(&mut Kept);

#[test]
fn numbers_that_do_not_belong_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.kept");
    let mut state = State::new(2);
    advance(&mut state, 2, 16, 4);
    assert_eq!(state.rungs.len(), 2);
    let changes: [(&str, Change); 8] = [
        ("nothing", |_| {}),
        ("no mean", |kept| drop(kept.arrays.remove("half-a"))),
        ("a short mean", |kept| kept.arrays.get_mut("half-b-rest").unwrap().truncate(1)),
        ("no rung", |kept| drop(kept.arrays.remove("visibility-64"))),
        ("a short rung", |kept| kept.arrays.get_mut("visibility-32").unwrap().truncate(1)),
        ("too many rungs", |kept| {
            let errors = vec![0.0; 40];
            (0..40).for_each(|k| drop(kept.arrays.insert(rung_name(k), vec![0.0; 2])));
            kept.arrays.insert("errors".into(), errors);
        }),
        ("too few rays", |kept| kept.header = json!({ "rays": [16, 16] })),
        ("no rays", |kept| kept.header = json!({ "rays": [32, "many"] })),
    ];
    for (name, change) in changes {
        state.write(&path, fingerprint()).unwrap();
        let mut kept = Kept::read(&path, KIND, fingerprint()).unwrap().unwrap();
        change(&mut kept);
        kept.write(&path, KIND, fingerprint()).unwrap();
        let read = State::read(&path, fingerprint(), 2);
        match read {
            Ok(found) => assert!(name == "nothing" && found.as_ref() == Some(&state), "{name}"),
            Err(error) => assert!(error.to_string().contains("do not belong together"), "{name}: {error}"),
        }
    }
}
