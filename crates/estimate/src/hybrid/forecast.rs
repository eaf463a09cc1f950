//! What is foreseen: rays that an error needs, rays that a time allows, and whether weighing pays.

use super::{
    Hybrid,
    refine::Work,
    start::{MANY, first_units},
    tallies::{FULL, Rays, UNIT},
};
use crate::Choice;

/// Rays a point before anything is known of the error: a first look, which is a lattice.
const FIRST_LOOK: f64 = 1.0;
/// The expected error falls as rays to the power of minus this, until rounds tell; and the range in which they are believed.
/// About what the table of docs/method.md shows between its columns.
const POWER: f64 = 0.5;
const POWERS: [f64; 2] = [0.4, 0.7];
/// A round aims a little below the error, so that it need not be followed by a tiny one.
const AIM: f64 = 0.97;
/// The least that rays grow by where the error is not reached: weighing costs as much as some rays do.
const LEAST_GROWTH: f64 = 1.125;
/// Share of the time left that is planned for, since rays go where they cost more than on average.
const PLANNED: f64 = 0.93;
/// What was traced in small bundles is left behind where full ones suit the budget and it is less than this share of it.
const LEFT_BEHIND: f64 = 0.25;
/// How fast the squared error of neighbours' guesses falls with rays: between their noise, which falls faster, and their bias.
const GUESS_POWER: f64 = 0.5;

impl Hybrid {
    /// Rays a point at which the first limit of the budget will be met.
    pub(super) fn foresee(&self, work: &Work<'_>) -> f64 {
        let mut rays = f64::from(work.budget.rays);
        if let Some(error) = work.budget.error {
            rays = rays.min(self.needed(f64::from(error)));
        }
        if work.budget.seconds.is_some() {
            rays = rays.min(self.affordable(work));
        }
        rays
    }

    /// Rays a point so far.
    pub(super) fn rays_per_point(&self) -> f64 {
        self.rays_of_rounds() as f64 / self.covered.max(1) as f64
    }

    /// Rays a point until that error.
    fn needed(&self, error: f64) -> f64 {
        let Some(last) = self.rounds.last() else { return FIRST_LOOK };
        if last.expected_rmse <= error {
            return last.rays_per_point;
        }
        let before = self.rounds.len().checked_sub(2).map(|k| &self.rounds[k]);
        let power = before.map_or(POWER, |before| {
            let fell = (before.expected_rmse / last.expected_rmse).ln();
            let power = fell / (last.rays_per_point / before.rays_per_point).ln();
            if power.is_finite() { power.clamp(POWERS[0], POWERS[1]) } else { POWER }
        });
        let growth = (last.expected_rmse / (AIM * error)).powf(1.0 / power);
        last.rays_per_point * growth.max(LEAST_GROWTH)
    }

    /// Rays a point in all that the time left allows, a weighing and the answers kept back.
    pub(super) fn affordable(&self, work: &Work<'_>) -> f64 {
        let spare = PLANNED * (work.meter.left() - self.tail_seconds()).max(0.0);
        let after =
            |ray_seconds: f64| self.rays_per_point() + spare / (ray_seconds * self.covered.max(1) as f64);
        if self.started
            && let Some(ray_seconds) = self.costs.ray_seconds
        {
            return after(ray_seconds);
        }
        let of = |units| self.costs.piloted(units).map_or(FIRST_LOOK, after);
        let full = of(FULL);
        if full >= MANY { full } else { of(1).min(MANY - 1.0) }
    }

    /// True where it is better to begin anew with full bundles. What an error needs is not known from the lattice alone: on the
    /// Cornell box errors fall much faster than foreseen.
    pub(super) fn outgrown(&self, work: &Work<'_>) -> bool {
        let is_known = work.budget.error.is_none() || self.rounds.len() > 1;
        is_known
            && self.rays.first < FULL
            && first_units(self.foreseen) == FULL
            && self.rays_per_point() < LEFT_BEHIND * self.foreseen
    }

    /// Compares what the time left is worth: pooled rays less two weighings, or even rays. Once a lattice was weighed.
    pub(super) fn choose_method(&mut self, work: &Work<'_>) {
        let unit = f64::from(self.rays.first * UNIT);
        let (Some(ray), Some(weighing)) = (self.costs.ray_seconds, self.costs.weighing_seconds) else {
            return;
        };
        let answers = self.costs.answer_seconds.unwrap_or(0.0);
        let (now, known) = (self.rays_per_point(), self.expected_rmse());
        let bundle = f64::from(Rays::variance(self.weigher.unit_variance(), self.rays.first));
        let rays_in = |seconds: f64| seconds.max(0.0) / (ray * self.covered.max(1) as f64);
        let even_rays = rays_in(work.meter.left() - answers);
        let pooled_rays = now + rays_in(work.meter.left() - answers - 2.0 * weighing);
        // Own rays as `Rays::variance` has it; fewer than a bundle a point is nothing to share out evenly.
        let own = |rays: f64| if rays < unit { f64::INFINITY } else { bundle * (unit / rays).powf(1.5) };
        let guess = known * known * (now / pooled_rays).powf(GUESS_POWER);
        let (even, pooled) = (own(even_rays), 1.0 / (1.0 / guess + 1.0 / own(pooled_rays)));
        self.foreseen_rmse = Some([pooled.sqrt(), even.sqrt()]);
        if even < pooled {
            self.choice = Choice::Evenly;
        }
    }
}
