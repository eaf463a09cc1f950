//! Mean and variance that can be merged.

/// Count, mean and summed squared deviation of a set of numbers.
///
/// Chan, Golub, LeVeque, "Updating Formulae and a Pairwise Algorithm for Computing Sample Variances", 1979.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// How many numbers.
    pub count: f64,
    /// Their mean.
    pub mean: f64,
    /// Sum of squared deviations from the mean.
    pub m2: f64,
}

impl Moments {
    /// Adds one number.
    pub fn push(&mut self, x: f64) {
        *self = self.merge(Self { count: 1.0, mean: x, m2: 0.0 });
    }

    /// Moments of both sets together.
    pub fn merge(self, other: Self) -> Self {
        let count = self.count + other.count;
        if count == 0.0 {
            return self;
        }
        let delta = other.mean - self.mean;
        Self {
            count,
            mean: self.mean + delta * other.count / count,
            m2: self.m2 + other.m2 + delta * delta * self.count * other.count / count,
        }
    }

    /// Variance of the set itself (divided by the count); 0 when empty.
    pub fn population_variance(&self) -> f64 {
        if self.count > 0.0 { self.m2 / self.count } else { 0.0 }
    }

    /// Unbiased variance of what the set was drawn from; infinite below two numbers.
    pub fn sample_variance(&self) -> f64 {
        if self.count > 1.0 { self.m2 / (self.count - 1.0) } else { f64::INFINITY }
    }

    /// Standard error of the mean, for independent draws.
    pub fn standard_error(&self) -> f64 {
        (self.sample_variance() / self.count).sqrt()
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<T: IntoIterator<Item = f64>>(numbers: T) -> Self {
        let mut m = Self::default();
        numbers.into_iter().for_each(|x| m.push(x));
        m
    }
}

#[cfg(test)]
mod tests {
    use super::Moments;
    use proptest::prelude::*;

    #[test]
    fn one_to_five() {
        let m: Moments = (1..=5).map(f64::from).collect();
        assert_eq!((m.count, m.mean, m.m2), (5.0, 3.0, 10.0));
        assert_eq!(m.sample_variance(), 2.5);
    }

    proptest! {
        #[test]
        fn merging_equals_one_pass(numbers in prop::collection::vec(-1e3f64..1e3, 1..50), cut in 0usize..50) {
            let cut = cut.min(numbers.len());
            let whole: Moments = numbers.iter().copied().collect();
            let left: Moments = numbers[..cut].iter().copied().collect();
            let merged = left.merge(numbers[cut..].iter().copied().collect());
            prop_assert!((whole.mean - merged.mean).abs() < 1e-9);
            prop_assert!((whole.m2 - merged.m2).abs() < 1e-6 * (1.0 + whole.m2));
        }
    }
}
