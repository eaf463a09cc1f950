//! The exponent of a power law.

/// Slope of the straight line through logarithms that has the least squares: b where y is about a x^b.
///
/// `None` for fewer than two different x, or where a number is not above 0.
pub fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    if points.iter().flatten().any(|v| !(*v > 0.0 && v.is_finite())) {
        return None;
    }
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|p| p[axis].ln()).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(0), mean(1));
    let (mut both, mut squares) = (0.0, 0.0);
    for [x, y] in points {
        let dx = x.ln() - mean_x;
        both += dx * (y.ln() - mean_y);
        squares += dx * dx;
    }
    (squares > 0.0).then(|| both / squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_gives_its_power() {
        let points = [1.0f64, 3.0, 10.0, 200.0].map(|x| [x, 7.0 * x.powf(-0.6)]);
        assert!((exponent(&points).unwrap() + 0.6).abs() < 1e-12);
    }

    #[test]
    fn noise_that_is_even_about_the_law_cancels() {
        // 2, 1/2, 1/2, 2 times x^2 at equal steps of the logarithm: no slope of its own.
        let points = [[1.0, 2.0], [10.0, 50.0], [100.0, 5000.0], [1000.0, 2e6]];
        assert!((exponent(&points).unwrap() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_exponent_has_none() {
        assert_eq!(exponent(&[[1.0, 2.0]]), None);
        assert_eq!(exponent(&[[1.0, 2.0], [1.0, 3.0]]), None);
        assert_eq!(exponent(&[[1.0, 2.0], [2.0, 0.0]]), None);
        assert_eq!(exponent(&[]), None);
    }
}
