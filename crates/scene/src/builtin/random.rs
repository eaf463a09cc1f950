//! Numbers that look random and are always the same.

use conray_core::{Vec2, Vec3, hash_u32};
use std::f32::consts::TAU;

/// A stream of numbers that depends on its seed alone, so that built-in scenes never change between calls.
#[derive(Clone, Debug)]
pub(crate) struct Random {
    key: u32,
    count: u32,
}

impl Random {
    /// The stream of that seed; streams of different seeds are unrelated.
    pub(crate) fn new(seed: u32) -> Self {
        Self { key: hash_u32(seed ^ 0x5bd1_e995), count: 0 }
    }

    /// The next 32 bits.
    pub(crate) fn bits(&mut self) -> u32 {
        self.count = self.count.wrapping_add(1);
        // Two rounds: a counter has too little entropy in its upper bits for one.
        hash_u32(self.key ^ hash_u32(self.count))
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1u32 << 24) as f32
    }

    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in [-size, size).
    pub(crate) fn about_zero(&mut self, size: f32) -> f32 {
        self.between(-size, size)
    }

    /// An index below `count`, which must not be 0.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f32) as usize).min(count - 1)
    }

    /// A unit vector, uniform over the sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let (y, azimuth) = (self.about_zero(1.0), TAU * self.unit());
        let radius = (1.0 - y * y).max(0.0).sqrt();
        Vec3::new(radius * azimuth.cos(), y, radius * azimuth.sin())
    }
}

/// Smooth noise in [-1, 1] over the plane, one feature per unit length.
///
/// Value noise: hashed values at integer points, blended by the quintic of Perlin, "Improving Noise", 2002, so that its
/// slope and curvature have no steps.
pub(crate) fn value_noise(p: Vec2, seed: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let blend = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let value = |dx: i32, dy: i32| {
        let (x, y) = ((cell.x as i32).wrapping_add(dx) as u32, (cell.y as i32).wrapping_add(dy) as u32);
        let bits = hash_u32(hash_u32(hash_u32(seed) ^ x).wrapping_add(y));
        (bits >> 8) as f32 / (1u32 << 23) as f32 - 1.0
    };
    let low = value(0, 0) + blend.x * (value(1, 0) - value(0, 0));
    let high = value(0, 1) + blend.x * (value(1, 1) - value(0, 1));
    low + blend.y * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_repeat_and_differ_by_seed() {
        let take = |seed: u32| -> Vec<u32> {
            let mut random = Random::new(seed);
            (0..64).map(|_| random.bits()).collect()
        };
        assert_eq!(take(7), take(7));
        assert!(take(7).iter().zip(take(8)).all(|(a, b)| *a != b));
    }

    #[test]
    fn directions_are_unit_and_without_a_mean() {
        let mut random = Random::new(3);
        let n = 10_000;
        let mut sum = Vec3::ZERO;
        for _ in 0..n {
            let d = random.direction();
            assert!((d.length() - 1.0).abs() < 1e-5);
            sum += d;
        }
        // Each component has variance 1/3: five standard errors of the mean.
        assert!((sum / n as f32).abs().max_element() < 5.0 / (3.0 * n as f32).sqrt());
    }

    #[test]
    fn numbers_are_uniform() {
        let mut random = Random::new(1);
        let mut tally = [0u32; 16];
        (0..16_000).for_each(|_| tally[random.index(16)] += 1);
        let chi_squared: f32 = tally.iter().map(|&t| (t as f32 - 1000.0).powi(2) / 1000.0).sum();
        assert!(
            chi_squared < 44.3,
            "chi squared {chi_squared}; 15 degrees of freedom pass 44.3 once in 10,000"
        );
    }

    #[test]
    fn noise_is_bounded_and_continuous_across_cells() {
        let mut random = Random::new(2);
        for _ in 0..1000 {
            let p = Vec2::new(random.about_zero(50.0), random.about_zero(50.0));
            assert!(value_noise(p, 9).abs() <= 1.0);
            let edge = Vec2::new(p.x.round(), p.y);
            let step =
                value_noise(edge - Vec2::new(1e-3, 0.0), 9) - value_noise(edge + Vec2::new(1e-3, 0.0), 9);
            assert!(step.abs() < 1e-2, "a step of {step} at {edge}");
        }
    }
}
