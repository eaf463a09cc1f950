//! Reading between the points of a curve on log axes.

/// The value at `x` of a curve through points with positive coordinates, linear in logarithms; `None` outside of it.
///
/// Points need not be sorted; of equal `x` the smaller `y` counts.
pub(crate) fn at(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let mut known: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0 > 0.0 && p.1 > 0.0).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    known.dedup_by_key(|p| p.0);
    if let Some(&(_, y)) = known.iter().find(|p| p.0 == x) {
        return Some(y);
    }
    let pair = known.windows(2).find(|w| w[0].0 < x && x < w[1].0)?;
    let share = (x / pair[0].0).ln() / (pair[1].0 / pair[0].0).ln();
    Some(pair[0].1 * (pair[1].1 / pair[0].1).powf(share))
}

/// Where a falling curve reaches `y`; `None` outside of it.
pub(crate) fn where_it_reaches(points: &[(f64, f64)], y: f64) -> Option<f64> {
    let turned: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (y, x)).collect();
    at(&turned, y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_read_exactly() {
        let law = |x: f64| 3.0 * x.powf(-0.7);
        let points: Vec<(f64, f64)> = [8.0, 1.0, 64.0].map(|x| (x, law(x))).into();
        for x in [1.0, 2.5, 8.0, 40.0, 64.0] {
            let y = at(&points, x).unwrap();
            assert!((y / law(x) - 1.0).abs() < 1e-12);
            assert!((where_it_reaches(&points, y).unwrap() / x - 1.0).abs() < 1e-12);
        }
        assert_eq!(at(&points, 0.5), None);
        assert_eq!(at(&points, 65.0), None);
        assert_eq!(at(&[], 1.0), None);
        assert_eq!(at(&[(1.0, 0.0)], 1.0), None, "zero has no logarithm");
    }
}
