//! What the rays of each pixel found, and how far that can be trusted.

use conray_core::Vec3;

/// Rays of a unit, in which rays are given out: an aligned block of a point's sequence.
pub(super) const UNIT: u32 = 16;
/// Units that are traced together: a full bundle.
pub(super) const FULL: u32 = conray_bvh::BUNDLE_RAYS as u32 / UNIT;

/// Sums over the rays of one point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Units traced, of 16 rays each.
    pub units: u32,
    /// Sum over units of the mean visibility.
    pub sum: f32,
    /// Sum over units outside full bundles of the variance of the mean, as if their rays were independent within each of 2 x 2
    /// cells of the square of directions.
    pub in_units: f32,
    /// Sum over full bundles of the variance of the mean, as if their rays were independent within each of 4 x 4 cells.
    pub in_fulls: f32,
    /// Sum over units of the mean open direction.
    pub bent: Vec3,
}

impl Tally {
    /// Mean visibility; 0 without rays.
    pub(super) fn mean(&self) -> f32 {
        self.sum / self.units.max(1) as f32
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.units += other.units;
        self.sum += other.sum;
        self.in_units += other.in_units;
        self.in_fulls += other.in_fulls;
        self.bent += other.bent;
    }
}

/// How rays err in a scene.
///
/// The variance of the mean of `n` units is that of one over `n^11/8`. Visibility jumps along curves in the square of directions, where
/// stratified points err as `n^-3/2` (Mitchell, "Consequences of Stratified Sampling in Graphics", 1996) once they are many; from 16
/// to 256 rays a point, scenes of the study measure powers of 1.3 to 1.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    /// Variance of a unit over what rays that are independent in each of its cells would have.
    pub unit: f32,
    /// The same of a full bundle.
    pub full: f32,
    /// Units that the points of the lattice got.
    pub first: u32,
}

/// [`worth`] of a full bundle.
const FULL_WORTH: f32 = 6.727_171;

/// How many times the precision of one unit so many have.
pub(super) fn worth(units: f32) -> f32 {
    let fourth = units.sqrt().sqrt();
    units * fourth * fourth.sqrt()
}

impl Rays {
    /// Before any rays told, for points of one unit: about what scenes have.
    pub const UNKNOWN: Self = Self { unit: 0.5, full: 0.5, first: 1 };

    /// Variance of one unit as a point's own rays tell it; 0 without rays.
    pub(super) fn unit_variance(&self, tally: &Tally) -> f32 {
        let fulls = FULL as f32 * FULL_WORTH * self.full * tally.in_fulls;
        (self.unit * tally.in_units + fulls) / tally.units.max(1) as f32
    }

    /// Squared error of what one unit does not see: of many units whose rays all agree, one in 25 holds another ray.
    pub(super) const UNSEEN: f32 = 0.04 / (UNIT * UNIT) as f32;

    /// The same of so many units: what none of their rays meets is as small as they are many.
    pub(super) fn unseen(units: u32) -> f32 {
        Self::UNSEEN / (units as f32 * units as f32)
    }

    /// Variance of the mean of so many units.
    pub(super) fn variance(unit_variance: f32, units: u32) -> f32 {
        unit_variance / worth(units as f32) + Self::unseen(units)
    }

    /// From so much formal variance on, in that of one unit, cells say enough: half that of a point of the lattice.
    pub fn enough(&self) -> f32 {
        0.5 / worth(self.first as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_rays_are_worth_more_than_as_many_independent_ones() {
        assert!((worth(FULL as f32) - FULL_WORTH).abs() < 1e-5);
        assert_eq!((worth(0.0), worth(1.0)), (0.0, 1.0));
        for units in 1..1000 {
            let expected = f64::from(units).powf(1.375);
            assert!((f64::from(worth(units as f32)) / expected - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_unit_and_a_full_bundle_that_err_alike_tell_the_same_variance() {
        let rays = Rays { unit: 0.5, full: 0.25, first: 1 };
        let unit = Tally { units: 1, in_units: 0.01, ..Tally::default() };
        // The variance of its mean is that of a unit over what it is worth.
        let in_fulls = 0.5 * 0.01 / (FULL_WORTH * 0.25);
        let full = Tally { units: FULL, in_fulls, ..Tally::default() };
        let mut both = unit;
        both.merge(&full);
        for tally in [unit, full, both] {
            assert!((rays.unit_variance(&tally) - 0.005).abs() < 1e-8, "{tally:?}");
        }
    }
}
