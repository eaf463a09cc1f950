//! The filter against closed forms.

use super::*;
use proptest::prelude::*;

const OFF: AtrousSettings = AtrousSettings {
    levels: 1,
    normal_deg: f32::INFINITY,
    plane_footprints: f32::INFINITY,
    distance: f32::INFINITY,
    deviations: f32::INFINITY,
};

/// A plane z = 0 seen from above, one unit a pixel.
fn plane(width: usize, height: usize) -> Guides {
    let pixels = width * height;
    let constant = |c: f32| vec![c; pixels];
    let x = (0..pixels).map(|i| (i % width) as f32).collect();
    let y = (0..pixels).map(|i| (i / width) as f32).collect();
    Guides {
        width,
        channels: [x, y, constant(0.0), constant(0.0), constant(0.0), constant(1.0)],
        inverse_footprint2: constant(1.0),
        covered: constant(1.0),
    }
}

/// Uniform noise about 1/2 of variance 1/12, keyed by place.
fn noise(pixels: usize) -> Noisy {
    let points = conray_core::RandomPoints::new(1);
    let value = (0..pixels as u32).map(|i| points.point(i).x).collect();
    Noisy { value, variance: vec![1.0 / 12.0; pixels] }
}

fn filtered(guides: &Guides, image: &Noisy, settings: &AtrousSettings) -> Noisy {
    let mut image = image.clone();
    guides.filter(&mut image, settings, |_, _| ());
    image
}

/// Squared weights summed, of the composite of that many levels far from borders.
fn noise_gain(levels: u32) -> f64 {
    let mut kernel = vec![1.0f64];
    for level in 0..levels {
        let step = 1usize << level;
        let mut next = vec![0.0; kernel.len() + 4 * step];
        for (i, k) in kernel.iter().enumerate() {
            for (tap, h) in [1.0, 4.0, 6.0, 4.0, 1.0].into_iter().enumerate() {
                next[i + tap * step] += k * h / 16.0;
            }
        }
        kernel = next;
    }
    // The kernel is a product of one in x and one in y.
    kernel.iter().map(|k| k * k).sum::<f64>().powi(2)
}

#[test]
fn noise_falls_by_the_sum_of_squared_weights() {
    let (width, height) = (320, 320);
    let (guides, image) = (plane(width, height), noise(width * height));
    for levels in 1..=3 {
        let out = filtered(&guides, &image, &AtrousSettings { levels, ..OFF });
        // Within 32 pixels of the border the kernel is cut off.
        let inner =
            |i: &usize| (32..width - 32).contains(&(i % width)) && (32..height - 32).contains(&(i / width));
        let m: conray::Moments = (0..width * height).filter(inner).map(|i| f64::from(out.value[i])).collect();
        let gain = m.population_variance() * 12.0;
        // The composite is near a Gaussian of variance s^2 = (4^levels - 1) / 3, so pixels d apart correlate by
        // exp(-d^2 / 4 s^2); squares of correlations sum to 2 pi s^2, and the variance found errs by that factor more
        // than the 2 / n of independent pixels. Four standard errors.
        let s2 = f64::from((1u32 << (2 * levels)) - 1) / 3.0;
        let allowed = 4.0 * (2.0 * std::f64::consts::TAU * s2).sqrt() / 256.0;
        assert!((gain / noise_gain(levels) - 1.0).abs() < allowed, "{levels}: {gain} {}", noise_gain(levels));
        assert!((gain / noise_gain(levels - 1) - 1.0).abs() > allowed, "the oracle must be able to fail");
    }
    // The tracked variance of the first level is that of independent pixels.
    let out = filtered(&guides, &image, &OFF);
    let tracked = f64::from(out.variance[160 * width + 160]) * 12.0;
    assert!((tracked / noise_gain(1) - 1.0).abs() < 1e-5, "{tracked}");
}

#[test]
fn at_the_border_the_weights_still_sum_to_one() {
    // A ramp is kept inside, where the kernel is symmetric, and pulled inwards at the border, by a known amount: the
    // taps at 0, 1, 2 weigh 6, 4, 1 of 11.
    let guides = plane(32, 32);
    let image = Noisy { value: (0..1024).map(|i| (i % 32) as f32).collect(), variance: vec![1.0; 1024] };
    let out = filtered(&guides, &image, &OFF);
    assert!((out.value[16 * 32 + 16] - 16.0).abs() < 1e-5);
    assert!((out.value[16 * 32] - 6.0 / 11.0).abs() < 1e-6, "{}", out.value[16 * 32]);
    assert!((out.value[16 * 32 + 31] - (31.0 - 6.0 / 11.0)).abs() < 1e-5);
    assert!((out.value[0] - 6.0 / 11.0).abs() < 1e-6, "corners too");
}

/// Two halves with values 0 and 1 that differ in one guide.
fn halves(change: impl Fn(&mut Guides, usize)) -> (Guides, Noisy) {
    let mut guides = plane(64, 16);
    let right = (0..64 * 16).filter(|i| i % 64 >= 32);
    let mut value = vec![0.0; 64 * 16];
    for i in right {
        value[i] = 1.0;
        change(&mut guides, i);
    }
    (guides, Noisy { value, variance: vec![0.01; 64 * 16] })
}

#[test]
fn edges_in_each_guide_are_kept_exactly() {
    let turned = halves(|g, i| (g.channels[3][i], g.channels[5][i]) = (1.0, 0.0));
    let raised = halves(|g, i| g.channels[2][i] = 50.0);
    let apart = halves(|g, i| g.channels[0][i] += 1000.0);
    let plain = halves(|_, _| ());
    let all = AtrousSettings { levels: 5, ..OFF };
    let cases = [
        ("normal", turned, AtrousSettings { normal_deg: 20.0, ..all }),
        ("plane", raised, AtrousSettings { plane_footprints: 2.0, ..all }),
        ("distance", apart, AtrousSettings { distance: 40.0, ..all }),
        ("value", plain, AtrousSettings { deviations: 2.0, ..all }),
    ];
    for (name, (guides, image), settings) in cases {
        assert_eq!(filtered(&guides, &image, &settings).value, image.value, "{name}");
        // Negative control: without the guides the edge blurs.
        let blurred = filtered(&guides, &image, &all).value;
        assert!((blurred[8 * 64 + 31] - 0.5).abs() < 0.2, "{name}: {}", blurred[8 * 64 + 31]);
    }
}

#[test]
fn the_background_lends_nothing_and_stays() {
    let (mut guides, mut image) = (plane(64, 16), noise(64 * 16));
    for i in (0..64 * 16).filter(|i| i % 64 >= 32) {
        guides.covered[i] = 0.0;
        image.value[i] = 100.0;
    }
    let settings = AtrousSettings { levels: 4, deviations: 3.0, normal_deg: 20.0, ..OFF };
    let out = filtered(&guides, &image, &settings);
    for (i, (&after, &before)) in out.value.iter().zip(&image.value).enumerate() {
        assert!(if i % 64 >= 32 { after == before } else { after <= 1.0 }, "{i}: {after}");
    }
    // Negative control: the same values on a surface do spread.
    let spread = filtered(&plane(64, 16), &image, &AtrousSettings { levels: 1, ..OFF });
    assert!(spread.value[8 * 64 + 31] > 1.0);
}

#[test]
fn threads_change_no_bit() {
    let (guides, image) = (plane(300, 40), noise(12_000));
    let settings = AtrousSettings {
        levels: 6,
        normal_deg: 20.0,
        plane_footprints: 1.0,
        distance: 90.0,
        deviations: 3.0,
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| filtered(&guides, &image, &settings))
    };
    let one = on(1);
    assert_eq!(one, on(3));
    assert_ne!(one, filtered(&guides, &image, &AtrousSettings { deviations: 2.9, ..settings }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn constant_images_stay_constant_exactly(
        value in 0.0f32..1.0, width in 1usize..200, height in 1usize..30, levels in 0u32..=MAX_LEVELS,
        sigma in 0.1f32..100.0,
    ) {
        let image = Noisy { value: vec![value; width * height], variance: vec![0.1; width * height] };
        let settings = AtrousSettings {
            levels, normal_deg: sigma, plane_footprints: sigma, distance: sigma, deviations: sigma,
        };
        let out = filtered(&plane(width, height), &image, &settings);
        prop_assert_eq!(&out.value, &image.value);
        prop_assert!(out.variance.iter().all(|&v| v > 0.0 && v <= 0.1 * 1.000_1));
    }

    #[test]
    fn values_stay_within_those_of_the_image(width in 1usize..150, height in 1usize..20, deviations in 0.5f32..9.0) {
        let image = noise(width * height);
        let settings = AtrousSettings { levels: 4, deviations, distance: 20.0, ..OFF };
        let out = filtered(&plane(width, height), &image, &settings);
        prop_assert!(out.value.iter().all(|&v| (-1e-5..=1.000_01).contains(&v)));
    }
}
