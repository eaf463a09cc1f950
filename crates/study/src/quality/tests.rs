//! Metrics against second formulas, the authors' FLIP and results that are wrong on purpose.

use super::*;
use crate::testing::test_case;
use conray_core::hash_u32;
use proptest::prelude::*;

/// Values in steps of 1/256, so that differences and their squares are exact.
fn values(numerators: &[i64]) -> Vec<f32> {
    numerators.iter().map(|&n| n as f32 / 256.0).collect()
}

/// Numerators between 64 and 192, other ones for every seed.
fn numerators(count: usize, seed: u32) -> Vec<i64> {
    (0..count as u32).map(|i| i64::from(64 + hash_u32(hash_u32(seed) ^ i) % 128)).collect()
}

/// RMSE, mean absolute error, bias and 95th percentile in whole numbers: sums of differences n / 256.
fn by_whole_numbers(a: &[i64], b: &[i64]) -> [f64; 4] {
    let mut differences: Vec<i64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let count = differences.len() as i64;
    let share = |sum: i64, scale: f64| sum as f64 / (count as f64 * scale);
    let rmse = share(differences.iter().map(|d| d * d).sum(), 65536.0).sqrt();
    let bias = share(differences.iter().sum(), 256.0);
    differences.iter_mut().for_each(|d| *d = d.abs());
    differences.sort_unstable();
    // The first that 95 of 100 do not exceed.
    let p95 = *differences
        .iter()
        .find(|&&d| 100 * differences.iter().filter(|&&e| e <= d).count() as i64 >= 95 * count)
        .unwrap();
    [rmse, share(differences.iter().sum(), 256.0), bias, p95 as f64 / 256.0]
}

#[test]
fn metrics_agree_with_whole_numbers() {
    let case = test_case(8);
    let count = case.points().len();
    for seed in 0..20 {
        let (a, b) = (numerators(count, seed), numerators(count, seed + 100));
        let quality = judge(&case, &values(&a), &values(&b)).unwrap();
        let [rmse, mae, bias, p95] = by_whole_numbers(&a, &b);
        let relative = bias * 256.0 * count as f64 / b.iter().sum::<i64>() as f64;
        let found = [quality.rmse, quality.mae, quality.bias, quality.p95, quality.relative_bias];
        for (found, expected) in found.into_iter().zip([rmse, mae, bias, p95, relative]) {
            assert!((found - expected).abs() < 1e-12, "seed {seed}: {found} for {expected}");
        }
        assert!((super::rmse(&values(&a), &values(&b)) - rmse).abs() < 1e-12);
        // The other way round is wrong, and told apart.
        assert!((by_whole_numbers(&b, &a)[2] - quality.bias).abs() > 1e-12);
    }
}

/// A picture that varies smoothly over the points, and so is changed by a blur at its edges only little: with stripes.
fn striped(count: usize) -> Vec<f32> {
    (0..count).map(|i| if i / 3 % 2 == 0 { 0.25 } else { 0.75 }).collect()
}

#[test]
fn what_is_wrong_is_caught_by_every_metric_that_can_see_it() {
    let case = test_case(24);
    let truth = striped(case.points().len());
    let count = truth.len();
    let equal = judge(&case, &truth, &truth).unwrap();
    assert_eq!(equal, Quality::default());

    let shifted: Vec<f32> = truth.iter().map(|v| v + 0.1).collect();
    let shift = judge(&case, &shifted, &truth).unwrap();
    for error in [shift.rmse, shift.mae, shift.bias, shift.p95] {
        assert!((error - 0.1).abs() < 1e-7, "{shift:?}");
    }
    let mean = truth.iter().map(|&v| f64::from(v)).sum::<f64>() / count as f64;
    assert!((shift.relative_bias - 0.1 / mean).abs() < 1e-6);
    assert!(shift.flip > 0.05, "{shift:?}");

    // One point off by 3/4: the mean square is (3/4)^2 / n; a percentile does not see it.
    let mut spotted = truth.clone();
    spotted[count / 2] = truth[count / 2] + 0.75;
    let firefly = judge(&case, &spotted, &truth).unwrap();
    assert!((firefly.rmse - 0.75 / (count as f64).sqrt()).abs() < 1e-9);
    assert!((firefly.mae - 0.75 / count as f64).abs() < 1e-9 && firefly.bias == firefly.mae);
    assert!(firefly.p95 == 0.0 && firefly.flip > 1e-4, "{firefly:?}");

    // Stripes of three, blurred over three: two of three points are off by a third of the step of 1/2.
    let blurred: Vec<f32> = (0..count)
        .map(|i| [i.max(1) - 1, i, (i + 1).min(count - 1)].map(|k| truth[k]).iter().sum::<f32>() / 3.0)
        .collect();
    let blur = judge(&case, &blurred, &truth).unwrap();
    assert!((blur.mae - 2.0 / 3.0 / 6.0).abs() < 1e-3 && (blur.p95 - 1.0 / 6.0).abs() < 1e-6, "{blur:?}");
    assert!((blur.rmse - (2.0f64 / 3.0).sqrt() / 6.0).abs() < 1e-3, "{blur:?}");
    assert!(blur.bias.abs() < 1e-3 && blur.flip > 0.02, "a blur has no bias: {blur:?}");
}

#[test]
fn what_cannot_be_judged_is_named() {
    let case = test_case(4);
    let good = vec![0.5; case.points().len()];
    for bad in [f32::NAN, f32::INFINITY] {
        let mut wrong = good.clone();
        wrong[2] = bad;
        let error = judge(&case, &wrong, &good).unwrap_err().to_string();
        assert!(error.contains("visibilities: that of point 2"), "{error}");
        let error = judge(&case, &good, &wrong).unwrap_err().to_string();
        assert!(error.contains("true visibilities: that of point 2"), "{error}");
    }
    assert!(judge(&case, &good[1..], &good).unwrap_err().to_string().contains("points"));
    assert!(judge(&case, &good, &good[1..]).is_err());
}

#[test]
fn the_background_does_not_dilute_flip() {
    // The same error everywhere: a larger share of background must not make it small.
    let case = test_case(24);
    let background = case.mask().iter().filter(|surface| !**surface).count();
    assert!(background > 0, "the view has background, or this test says nothing");
    let count = case.points().len();
    let flip = judge(&case, &vec![0.5; count], &vec![0.4; count]).unwrap().flip;
    let plain = flip_map(&[0.4; 576], &[0.5; 576], (24, 24));
    let plain = plain.iter().sum::<f32>() / 576.0;
    assert!((flip / f64::from(plain) - 1.0).abs() < 0.3, "{flip} {plain}");
    // Values beyond the range look as white and black do.
    let beyond = judge(&case, &vec![1.5; count], &vec![1.0; count]).unwrap();
    assert!(beyond.flip == 0.0 && beyond.rmse == 0.5, "{beyond:?}");
}

const WIDTH: u32 = 48;
const HEIGHT: u32 = 40;

/// A picture by a formula of column and row, in 255ths.
fn picture(shade_at: impl Fn(i32, i32) -> i32) -> Vec<f32> {
    let pixels = (0..HEIGHT as i32).flat_map(|y| (0..WIDTH as i32).map(move |x| (x, y)));
    pixels.map(|(x, y)| shade_at(x, y).clamp(0, 255) as f32 / 255.0).collect()
}

/// A chequer whose light and dark fields are gradients.
fn chequer(x: i32, y: i32) -> i32 {
    if (x / 8 + y / 8) % 2 == 0 { 40 + 3 * x } else { 200 - 2 * y }
}

/// Shade of a column and row.
type ShadeAt = fn(i32, i32) -> i32;

/// Pictures beside the chequer and the mean FLIP that the authors' Python package gives for each pair.
///
/// Found with flip-evaluator 1.7 and NumPy, `x` and `y` from `np.mgrid`, each picture as single precision over 255 in three
/// equal channels: `flip_evaluator.evaluate(chequer, other, "LDR", inputsRGB=True, applyMagma=False,
/// computeMeanError=True)[1]`.
const BY_THE_AUTHORS: [(&str, ShadeAt, f64); 3] = [
    ("noise", |x, y| chequer(x, y) + (7 * x + 13 * y) % 41 - 20, 0.047_570_15),
    ("hole", hole, 0.040_398_10),
    ("shift", |x, y| chequer(x, y) + 26, 0.346_570_67),
];

fn hole(x: i32, y: i32) -> i32 {
    let inside = (10..20).contains(&x) && (12..22).contains(&y);
    if inside { 255 - chequer(x, y) } else { chequer(x, y) }
}

/// Absolute, of the mean. Both programs round sums in another order; FLIP takes differences to the powers 1/2 and 0.7, so
/// that 1e-7 at a pixel of small difference comes out as up to 3e-4.
const FLIP_TOLERANCE: f64 = 1e-4;

#[test]
fn flip_is_that_of_its_authors() {
    let mean = |reference: &[f32], test: &[f32]| {
        let map = flip_map(reference, test, (WIDTH, HEIGHT));
        map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
    };
    let near = |found: f64, expected: f64| (found - expected).abs() < FLIP_TOLERANCE;
    for (name, shade_at, expected) in BY_THE_AUTHORS {
        let found = mean(&picture(chequer), &picture(shade_at));
        assert!(near(found, expected), "{name}: {found} for {expected}");
        // One shade more everywhere is seen.
        let off = mean(&picture(chequer), &picture(|x, y| shade_at(x, y) + 1));
        assert!(!near(off, expected), "{name} could not fail: {off}");
        // FLIP has no direction, so the order of its arguments cannot be wrong.
        assert!(near(mean(&picture(shade_at), &picture(chequer)), expected), "{name}, the other way round");
    }
}

proptest! {
    #[test]
    fn shades_are_those_of_the_png(value in -0.5f32..1.5) {
        let mut png = Vec::new();
        conray::target::encode_png(&mut png, 1, 1, &[value], conray::target::PngDepth::Eight).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut pixel = [0];
        reader.next_frame(&mut pixel).unwrap();
        prop_assert_eq!(pixel[0], shade(value));
    }
}
