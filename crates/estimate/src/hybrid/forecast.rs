//! What is foreseen: rays that an error needs, rays that a time allows, and whether weighing pays.

use super::{
    Hybrid,
    refine::Work,
    start::{MANY, first_units},
    tallies::{FULL, UNIT, worth},
};
use crate::{Choice, Round};

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
            rays = rays.min(needed(&self.rounds, self.begun_anew, f64::from(error)));
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
        let (Some(ray), Some(weighing)) = (self.costs.ray_seconds, self.costs.weighing_seconds) else {
            return;
        };
        let left = work.meter.left() - self.costs.answer_seconds.unwrap_or(0.0);
        let rays_in = |seconds: f64| seconds.max(0.0) / (ray * self.covered.max(1) as f64);
        let now = self.rays_per_point();
        let outlook = Outlook {
            error2: self.expected_rmse().powi(2),
            unit: self.known.unit,
            first: self.rays.first,
            now,
            even: rays_in(left),
            pooled: now + rays_in(left - 2.0 * weighing),
        };
        let [pooled, even] = outlook.squared_errors();
        self.foreseen_rmse = Some([pooled.sqrt(), even.sqrt()]);
        if even < pooled {
            self.choice = Choice::Evenly;
        }
    }
}

/// Two ways on from a lattice that was weighed, in rays a point.
struct Outlook {
    /// Expected squared error as weighed.
    error2: f64,
    /// Squared error of one unit of rays.
    unit: f32,
    /// Units of a point of the lattice.
    first: u32,
    /// Rays so far.
    now: f64,
    /// Rays in the time left, shared out evenly.
    even: f64,
    /// Rays with those so far in the time left, less two weighings.
    pooled: f64,
}

impl Outlook {
    /// Foreseen for pooled and for even rays; fewer even ones than points of the lattice have are nothing to share out.
    fn squared_errors(&self) -> [f64; 2] {
        let own = |rays: f64| {
            let units = rays / f64::from(UNIT);
            let enough = units >= f64::from(self.first);
            if enough { f64::from(self.unit / worth(units as f32)) } else { f64::INFINITY }
        };
        let guess = self.error2 * (self.now / self.pooled).powf(GUESS_POWER);
        [1.0 / (1.0 / guess + 1.0 / own(self.pooled)), own(self.even)]
    }
}

/// Rays a point until an error, by rounds of work that began anew after so many of them, if it did.
fn needed(rounds: &[Round], begun_anew: Option<usize>, error: f64) -> f64 {
    match begun_anew {
        // The new lattice alone tells no more than the first: what was foreseen before it holds, what is left behind included.
        Some(before) if rounds.len() == before + 1 => {
            let (before, lattice) = rounds.split_at(before);
            let left_behind = before.last().map_or(0.0, |last| last.rays_per_point);
            let least = lattice[0].rays_per_point * LEAST_GROWTH;
            (left_behind + needed_after(before, error)).min(needed_after(lattice, error)).max(least)
        }
        _ => needed_after(rounds, error),
    }
}

/// Rays a point until an error, as rounds so far tell.
fn needed_after(rounds: &[Round], error: f64) -> f64 {
    let Some(last) = rounds.last() else { return FIRST_LOOK };
    if last.expected_rmse <= error {
        return last.rays_per_point;
    }
    let before = rounds.len().checked_sub(2).map(|k| &rounds[k]);
    let power = before.map_or(POWER, |before| {
        let fell = (before.expected_rmse / last.expected_rmse).ln();
        let power = fell / (last.rays_per_point / before.rays_per_point).ln();
        if power.is_finite() { power.clamp(POWERS[0], POWERS[1]) } else { POWER }
    });
    let growth = (last.expected_rmse / (AIM * error)).powf(1.0 / power);
    last.rays_per_point * growth.max(LEAST_GROWTH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_rays_are_chosen_where_weighing_takes_what_they_give() {
        let outlook = |even, pooled| Outlook { error2: 1e-3, unit: 1e-3, first: 1, now: 4.0, even, pooled };
        // As many either way: neighbours are for nothing.
        let [pooled, even] = outlook(256.0, 256.0).squared_errors();
        assert!(pooled < even && even.is_finite());
        // Two weighings take almost all of the time.
        let [pooled, even] = outlook(256.0, 8.0).squared_errors();
        assert!(even < pooled);
        // Even rays err as their number says, and too few are none.
        assert!((outlook(64.0, 8.0).squared_errors()[1] / f64::from(1e-3 / worth(4.0)) - 1.0).abs() < 1e-6);
        assert_eq!(outlook(8.0, 8.0).squared_errors()[1], f64::INFINITY);
    }

    fn rounds(told: &[(f64, f64)]) -> Vec<Round> {
        let round = |&(rays_per_point, expected_rmse)| Round { rays_per_point, expected_rmse, seconds: 0.0 };
        told.iter().map(round).collect()
    }

    #[test]
    fn errors_fall_as_the_last_rounds_tell() {
        let near =
            |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        assert_eq!(needed(&[], None, 0.02), FIRST_LOOK);
        near(needed(&rounds(&[(1.0, 0.194)]), None, 0.02), 100.0);
        let power = (0.1f64 / 0.0525).ln() / 4f64.ln();
        near(
            needed(&rounds(&[(1.0, 0.1), (4.0, 0.0525)]), None, 0.05),
            4.0 * (0.0525 / 0.0485f64).powf(1.0 / power).max(LEAST_GROWTH),
        );
        assert_eq!(needed(&rounds(&[(1.0, 0.1), (4.0, 0.05)]), None, 0.05), 4.0);
    }

    #[test]
    fn a_new_lattice_alone_makes_no_new_forecast() {
        // As on the damaged helmet: half of the rays in few points, which tell little of those between them.
        let told = [(1.0, 0.0915), (8.3, 0.037), (27.0, 0.0516)];
        let before = needed(&rounds(&told[..2]), None, 0.02);
        assert!((35.0..40.0).contains(&before), "{before}");
        assert_eq!(needed(&rounds(&told), Some(2), 0.02), 8.3 + before);
        assert!(needed(&rounds(&told), None, 0.02) > 300.0, "what the lattice would have made of it");
        // Where the lattice comes near by itself a little more is enough, and never nothing.
        let near = [(1.0, 0.0915), (8.3, 0.037), (27.0, 0.0201)];
        assert_eq!(needed(&rounds(&near), Some(2), 0.02), 27.0 * LEAST_GROWTH);
        // Rounds after it tell again.
        let after = [(1.0, 0.0915), (8.3, 0.037), (27.0, 0.0516), (45.0, 0.021)];
        assert!(needed(&rounds(&after), Some(2), 0.02) < 55.0);
    }
}
