//! How far two images are apart.

use crate::TargetError;

/// Errors of a result against a reference, over the pixels that count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// How many pixels were compared.
    pub count: usize,
    /// How many pixels of the mask were left out because one side is not finite (pending).
    pub not_finite: usize,
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean signed error, result minus reference: above 0 where the result is too open.
    pub bias: f64,
    /// 95th percentile of the absolute error, by nearest rank.
    pub p95: f64,
    /// Peak signal to noise ratio in dB for a peak of 1: -20 log10(rmse); infinite for equal images.
    pub psnr_db: f64,
}

/// Compares a result with a reference, value by value, where `mask` is true.
///
/// All sums run in double precision and in order. Fails ([`TargetError::Incomparable`]) if the lengths differ or nothing
/// is left to compare.
pub fn compare(result: &[f32], reference: &[f32], mask: &[bool]) -> Result<Metrics, TargetError> {
    if result.len() != reference.len() || result.len() != mask.len() {
        let (a, b, c) = (result.len(), reference.len(), mask.len());
        return Err(TargetError::Incomparable(format!("{a} values against {b}, with a mask of {c}")));
    }
    let masked = mask.iter().filter(|&&m| m).count();
    let errors: Vec<f64> = (result.iter().zip(reference).zip(mask))
        .filter(|((a, b), m)| **m && a.is_finite() && b.is_finite())
        .map(|((a, b), _)| f64::from(*a) - f64::from(*b))
        .collect();
    if errors.is_empty() {
        return Err(TargetError::Incomparable(format!(
            "none of {masked} masked values is finite on both sides"
        )));
    }
    let mean = |f: fn(f64) -> f64| errors.iter().map(|&e| f(e)).sum::<f64>() / errors.len() as f64;
    let rmse = mean(|e| e * e).sqrt();
    Ok(Metrics {
        count: errors.len(),
        not_finite: masked - errors.len(),
        rmse,
        mae: mean(f64::abs),
        bias: mean(|e| e),
        p95: percentile(errors.iter().map(|e| e.abs()).collect(), 0.95),
        psnr_db: -20.0 * rmse.log10(),
    })
}

/// The smallest value that at least `share` of the values do not exceed (nearest rank); `values` is not empty.
fn percentile(mut values: Vec<f64>, share: f64) -> f64 {
    let rank = (share * values.len() as f64).ceil() as usize;
    let index = rank.clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(n: usize) -> Vec<bool> {
        vec![true; n]
    }

    #[test]
    fn equal_images_have_no_error() {
        let a = [0.0, 0.25, 1.0];
        let m = compare(&a, &a, &all(3)).unwrap();
        assert_eq!((m.rmse, m.mae, m.bias, m.p95, m.psnr_db), (0.0, 0.0, 0.0, 0.0, f64::INFINITY));
        let wrong = compare(&[0.0, 0.25, 0.0], &a, &all(3)).unwrap();
        assert!(wrong.rmse > 0.5 && wrong.bias < -0.3, "the oracle must be able to fail: {wrong:?}");
    }

    #[test]
    fn a_constant_shift_is_all_bias() {
        let reference: Vec<f32> = (0..100).map(|i| i as f32 / 256.0).collect();
        let result: Vec<f32> = reference.iter().map(|v| v + 0.125).collect();
        let m = compare(&result, &reference, &all(100)).unwrap();
        assert_eq!((m.rmse, m.mae, m.bias, m.p95), (0.125, 0.125, 0.125, 0.125));
        assert!((m.psnr_db - 60.0 * 2f64.log10()).abs() < 1e-12);
    }

    #[test]
    fn a_ramp_has_known_moments() {
        // Errors -n..=n over 2n+1 values: no bias, mean n(n+1)/(2n+1), mean square n(n+1)/3.
        let n = 50;
        let result: Vec<f32> = (-n..=n).map(|i| i as f32).collect();
        let m = compare(&result, &vec![0.0; result.len()], &all(result.len())).unwrap();
        let (n, count) = (f64::from(n), result.len() as f64);
        assert_eq!(m.bias, 0.0);
        assert!((m.mae - n * (n + 1.0) / count).abs() < 1e-12);
        assert!((m.rmse - (n * (n + 1.0) / 3.0).sqrt()).abs() < 1e-12);
        // 101 absolute errors 0, 1, 1, 2, 2, ...: rank ceil(95.95) = 96 is 48.
        assert_eq!(m.p95, 48.0);
    }

    #[test]
    fn masked_and_pending_values_do_not_count() {
        let result = [0.5, f32::NAN, 9.0, 0.25];
        let reference = [0.0, 0.5, 0.0, 0.25];
        let m = compare(&result, &reference, &[true, true, false, true]).unwrap();
        assert_eq!((m.count, m.not_finite, m.mae), (2, 1, 0.25));
    }

    #[test]
    fn nothing_to_compare_is_an_error() {
        assert!(compare(&[], &[], &[]).is_err());
        assert!(compare(&[1.0], &[1.0], &[false]).is_err());
        assert!(compare(&[f32::NAN], &[1.0], &[true]).is_err());
        assert!(compare(&[1.0], &[1.0, 2.0], &all(2)).is_err());
        assert!(compare(&[1.0], &[1.0], &all(2)).is_err());
    }

    proptest! {
        #[test]
        fn metrics_order_themselves(pairs in prop::collection::vec((0f32..1.0, 0f32..1.0), 1..200)) {
            let (a, b): (Vec<f32>, Vec<f32>) = pairs.into_iter().unzip();
            let m = compare(&a, &b, &all(a.len())).unwrap();
            prop_assert!(m.bias.abs() <= m.mae + 1e-12 && m.mae <= m.rmse + 1e-12);
            let within = a.iter().zip(&b).filter(|(a, b)| f64::from(**a - **b).abs() <= m.p95 + 1e-6).count();
            prop_assert!(within as f64 >= 0.95 * a.len() as f64);
        }
    }
}
