//! Point sets of the unit square that rays are compared with: independent points, and jittered ones.
//!
//! Both answer any index at once and know their place by `(seed, index)` alone, as [`crate::owen_sobol_2d`] does.

use crate::{Vec2, hash_u32};

/// Independent uniform points: point `index` of the sequence `seed`, in [0, 1)^2 with 24 bits a coordinate.
#[derive(Clone, Copy, Debug)]
pub struct RandomPoints {
    keys: [u32; 3],
}

impl RandomPoints {
    /// The sequence of that seed.
    pub const fn new(seed: u32) -> Self {
        // Three keys, two hashes deep: one hash of `index ^ seed` alone would give seeds that differ in few bits the
        // same points in another order.
        let first = hash_u32(seed ^ 0x2545_f491);
        Self { keys: [first, hash_u32(first ^ seed), hash_u32(first.wrapping_add(0x9e37_79b9))] }
    }

    /// One of its points.
    #[inline]
    pub fn point(&self, index: u32) -> Vec2 {
        let place = hash_u32(index.wrapping_add(self.keys[0]));
        let unit = |key: u32| (hash_u32(place ^ key) >> 8) as f32 * (1.0 / 16_777_216.0);
        Vec2::new(unit(self.keys[1]), unit(self.keys[2]))
    }
}

/// Jittered points: the square is cut into a grid of cells and each cell holds one random point.
///
/// Cook, "Stochastic Sampling in Computer Graphics", 1986. The cells are visited in a hashed order, so that a part of
/// the indices is spread over the square.
#[derive(Clone, Copy, Debug)]
pub struct JitteredPoints {
    /// Where in its cell a point is; and the points that no cell is left for.
    random: RandomPoints,
    order: Shuffle,
    columns: u32,
    rows: u32,
}

impl JitteredPoints {
    /// `count` points of the sequence `seed`, at least one.
    ///
    /// The grid has `count` cells, as near to a square as the divisors of `count` allow. Where it would be thinner
    /// than one to four, as for primes, it is the largest square grid below, and the rest of the points is random.
    pub fn new(count: u32, seed: u32) -> Self {
        let side = count.max(1).isqrt();
        let divisor = (1..=side).rev().find(|d| count.is_multiple_of(*d)).unwrap_or(1);
        let (rows, columns) =
            if count / divisor <= 4 * divisor { (divisor, (count / divisor).max(1)) } else { (side, side) };
        let random = RandomPoints::new(seed);
        Self { random, order: Shuffle::new(rows * columns, random.keys[2]), columns, rows }
    }

    /// Columns and rows of the grid.
    pub fn grid(&self) -> (u32, u32) {
        (self.columns, self.rows)
    }

    /// One of its points; beyond the cells they are random.
    #[inline]
    pub fn point(&self, index: u32) -> Vec2 {
        let within = self.random.point(index);
        if index >= self.columns * self.rows {
            return within;
        }
        let cell = self.order.at(index);
        let corner = Vec2::new((cell % self.columns) as f32, (cell / self.columns) as f32);
        let point = (corner + within) / Vec2::new(self.columns as f32, self.rows as f32);
        // Rounding may reach the far edge.
        point.min(Vec2::splat(1.0f32.next_down()))
    }
}

/// A hashed order of the numbers below a length.
///
/// A keyed bijection of the next power of two, repeated until it falls below the length: cycle walking, after Black,
/// Rogaway, "Ciphers with Arbitrary Finite Domains", 2002; for sampling first by Kensler, "Correlated
/// Multi-Jittered Sampling", 2013.
#[derive(Clone, Copy, Debug)]
struct Shuffle {
    length: u32,
    mask: u32,
    /// How far the upper half of the bits is from the lower.
    shift: u32,
    keys: [u32; 4],
}

impl Shuffle {
    fn new(length: u32, seed: u32) -> Self {
        let mask = length.next_power_of_two() - 1;
        let keys = std::array::from_fn(|i| hash_u32(seed ^ (i as u32).wrapping_mul(0x68e3_1da4)));
        Self { length, mask, shift: mask.count_ones().div_ceil(2), keys }
    }

    /// The number at a place, both below the length.
    #[inline]
    fn at(&self, place: u32) -> u32 {
        let mut x = place;
        loop {
            // Each step can be undone within the mask: adding a key, an odd factor, an exclusive or with upper bits.
            for key in self.keys {
                x = (x.wrapping_add(key) & self.mask).wrapping_mul((key >> 7) | 1) & self.mask;
                x ^= x >> self.shift;
            }
            if x < self.length {
                return x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Moments;
    use proptest::prelude::*;

    /// Chi-squared of points over 8 x 8 cells of the square: 63 degrees of freedom.
    fn chi_squared(points: impl Iterator<Item = Vec2>) -> f64 {
        let (mut counts, mut all) = ([0u32; 64], 0u32);
        for p in points {
            assert!(p.min_element() >= 0.0 && p.max_element() < 1.0, "{p}");
            counts[(p.y * 8.0) as usize * 8 + (p.x * 8.0) as usize] += 1;
            all += 1;
        }
        let expected = f64::from(all) / 64.0;
        counts.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum()
    }

    /// The 99.99 % quantile of 63 degrees of freedom, and the 0.01 % one.
    const QUANTILES: std::ops::Range<f64> = 27.0..115.0;

    /// Correlation of x and y over pairs of numbers, in standard errors of no correlation.
    fn correlation(pairs: impl Iterator<Item = (f32, f32)>) -> f64 {
        let products: Moments = pairs.map(|(a, b)| 12.0 * f64::from(a - 0.5) * f64::from(b - 0.5)).collect();
        products.mean / products.standard_error()
    }

    #[test]
    fn random_points_are_uniform_along_a_sequence_and_across_seeds() {
        let within = chi_squared((0..20_000).map(|i| RandomPoints::new(5).point(i)));
        let across = chi_squared((0..20_000).map(|seed| RandomPoints::new(seed).point(5)));
        assert!(QUANTILES.contains(&within) && QUANTILES.contains(&across), "{within} {across}");
        // Negative controls: points that lean to a side, and points too even to be random.
        let leaning = chi_squared((0..20_000).map(|i| RandomPoints::new(5).point(i).powf(1.05)));
        let even = chi_squared((0..20_000).map(|i| JitteredPoints::new(20_000, 5).point(i)));
        assert!(!QUANTILES.contains(&leaning) && !QUANTILES.contains(&even), "{leaning} {even}");
    }

    #[test]
    fn coordinates_neighbours_and_seeds_are_independent() {
        let p = |seed: u32, index: u32| RandomPoints::new(seed).point(index);
        let pairs = 0..50_000u32;
        let tests = [
            correlation(pairs.clone().map(|i| (p(1, i).x, p(1, i).y))),
            correlation(pairs.clone().map(|i| (p(1, i).x, p(1, i + 1).x))),
            correlation(pairs.clone().map(|i| (p(1, i).x, p(2, i).x))),
            correlation(pairs.clone().map(|seed| (p(seed, 0).x, p(seed + 1, 0).x))),
            correlation(pairs.clone().map(|seed| (p(seed, 0).y, p(seed, 1).y))),
        ];
        assert!(tests.iter().all(|t| t.abs() < 4.0), "{tests:?}");
        assert!(correlation(pairs.map(|i| (p(1, i).x, p(1, i).x * 0.1 + p(1, i).y * 0.9))).abs() > 4.0);
    }

    #[test]
    fn no_two_seeds_share_their_points() {
        // Birthday bound: of 2^20 points of 48 bits, 0.002 pairs are expected to meet.
        let mut points: Vec<[u32; 2]> = (0..1 << 16)
            .flat_map(|seed| {
                (0..16).map(move |i| RandomPoints::new(seed).point(i).to_array().map(f32::to_bits))
            })
            .collect();
        points.sort_unstable();
        assert!(points.windows(2).filter(|w| w[0] == w[1]).count() <= 1);
    }

    #[test]
    fn grids_are_near_square_and_fall_back_for_primes() {
        let grid = |n| JitteredPoints::new(n, 0).grid();
        let found = [1, 2, 4, 5, 8, 16, 32, 34, 61, 64].map(grid);
        let expected = [(1, 1), (2, 1), (2, 2), (2, 2), (4, 2), (4, 4), (8, 4), (5, 5), (7, 7), (8, 8)];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_part_of_the_indices_is_spread() {
        // The first quarter of 64 jittered points has its mean where random ones without replacement have it.
        let means: Moments = (0..2000)
            .map(|seed| {
                let points = JitteredPoints::new(64, seed);
                (0..16).map(|i| f64::from(points.point(i).x)).sum::<f64>() / 16.0
            })
            .collect();
        assert!((means.mean - 0.5).abs() < 4.0 * means.standard_error(), "{means:?}");
        // Variance of a mean of 16 of 64: sigma^2 / 16 * (64 - 16) / 63, sigma^2 = 1/12; the jitter adds little.
        let predicted = 48.0 / 63.0 / (12.0 * 16.0);
        assert!((means.sample_variance() / predicted - 1.0).abs() < 0.15, "{means:?} {predicted}");
        // Negative control: row by row, the first quarter sees a quarter of the square.
        let by_rows: Moments = (0..16).map(|cell| f64::from(cell / 8) / 8.0 + 0.5 / 8.0).collect();
        assert!((by_rows.mean - 0.5).abs() > 0.3);
    }

    #[test]
    fn each_cell_is_first_equally_often() {
        // 16 cells, 15 degrees of freedom: the 99.99 % quantile is 44.3.
        let chi_squared = |first: &dyn Fn(u32) -> u32| {
            let mut counts = [0u32; 16];
            (0..16_000).for_each(|seed| counts[first(seed) as usize] += 1);
            counts.iter().map(|&c| (f64::from(c) - 1000.0).powi(2) / 1000.0).sum::<f64>()
        };
        let found = chi_squared(&|seed| Shuffle::new(16, seed).at(0));
        assert!(found < 44.3, "{found}");
        assert!(chi_squared(&|seed| Shuffle::new(16, seed).at(0).min(14)) > 44.3);
    }

    proptest! {
        #[test]
        fn every_cell_holds_one_point(count in 1u32..700, seed: u32) {
            let points = JitteredPoints::new(count, seed);
            let (columns, rows) = points.grid();
            prop_assert!(columns * rows <= count && columns <= 4 * rows);
            let mut seen = vec![0u32; (columns * rows) as usize];
            for index in 0..columns * rows {
                let p = points.point(index);
                prop_assert!(p.min_element() >= 0.0 && p.max_element() < 1.0);
                // A point that rounding puts on the edge of its cell may be counted in the next.
                let cell = |u: f32, n: u32| ((u * n as f32) as u32).min(n - 1);
                seen[(cell(p.y, rows) * columns + cell(p.x, columns)) as usize] += 1;
            }
            let wrong = seen.iter().filter(|&&n| n != 1).count();
            prop_assert!(wrong <= 2, "{wrong} of {} cells", seen.len());
        }

        #[test]
        fn random_points_leave_cells_empty(seed: u32) {
            // The oracle above must be able to fail: 64 random points hit all of 64 cells with a chance of 1e-27.
            let mut seen = [0u32; 64];
            for index in 0..64 {
                let p = RandomPoints::new(seed).point(index);
                seen[(p.y * 8.0) as usize * 8 + (p.x * 8.0) as usize] += 1;
            }
            prop_assert!(seen.iter().filter(|&&n| n != 1).count() > 2);
        }

        #[test]
        fn a_shuffle_is_an_order(length in 1u32..3000, seed: u32) {
            let order = Shuffle::new(length, seed);
            let mut seen = vec![false; length as usize];
            (0..length).for_each(|place| seen[order.at(place) as usize] = true);
            prop_assert!(seen.iter().all(|&s| s));
        }
    }
}
