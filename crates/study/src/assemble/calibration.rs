//! Expected against true error of the estimates.

use super::Evidence;
use crate::report::{ErrorBin, EstimateCalibration};

const BINS: usize = 10;

/// One for each trial whose method says what error it expects.
pub(super) fn report(evidence: &Evidence<'_>) -> Vec<EstimateCalibration> {
    evidence
        .trials
        .list
        .iter()
        .filter_map(|trial| {
            let expected = trial.answer.expected_error.as_ref()?;
            let mut pairs: Vec<(f64, f64)> = expected
                .iter()
                .zip(&trial.answer.visibility)
                .zip(&evidence.truth.visibility)
                .filter(|((e, _), _)| e.is_finite())
                .map(|((&e, &v), &t)| (f64::from(e), f64::from(v) - f64::from(t)))
                .collect();
            // Equal expectations are ordered by error only to be in some fixed order.
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
            let all = bin_of(&pairs)?;
            let size = pairs.len().div_ceil(BINS);
            Some(EstimateCalibration {
                method: evidence.method(trial).into(),
                effort: trial.effort.value,
                label: trial.effort.label.clone(),
                ratio: if all.actual > 0.0 { all.expected / all.actual } else { 0.0 },
                bins: split_ties(&pairs, size).filter_map(bin_of).collect(),
            })
        })
        .collect()
}

/// Pieces of about `size` pairs; pairs of one expectation stay together, so that ties are not sorted into bins by error.
fn split_ties(pairs: &[(f64, f64)], size: usize) -> impl Iterator<Item = &[(f64, f64)]> {
    let mut rest = pairs;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let mut end = size.clamp(1, rest.len());
        while end < rest.len() && rest[end].0 == rest[end - 1].0 {
            end += 1;
        }
        let (bin, after) = rest.split_at(end);
        rest = after;
        Some(bin)
    })
}

fn bin_of(pairs: &[(f64, f64)]) -> Option<ErrorBin> {
    let n = pairs.len();
    let root_mean =
        |f: fn(&(f64, f64)) -> f64| (pairs.iter().map(|p| f(p).powi(2)).sum::<f64>() / n as f64).sqrt();
    (n > 0).then(|| ErrorBin { count: n, expected: root_mean(|p| p.0), actual: root_mean(|p| p.1) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_one_expectation_stay_together() {
        let pairs: Vec<(f64, f64)> =
            (0..30).map(|i| (if i < 20 { 0.1 } else { i as f64 }, i as f64)).collect();
        let sizes: Vec<usize> = split_ties(&pairs, 3).map(<[_]>::len).collect();
        assert_eq!(sizes, [20, 3, 3, 3, 1]);
        assert_eq!(split_ties(&[], 3).count(), 0);
    }

    #[test]
    fn a_bin_holds_root_mean_squares() {
        let bin = bin_of(&[(3.0, -1.0), (4.0, 1.0)]).unwrap();
        assert!((bin.expected - 12.5f64.sqrt()).abs() < 1e-12 && bin.actual == 1.0 && bin.count == 2);
        assert!(bin_of(&[]).is_none());
    }
}
