//! The first rays: a lattice of points, some traced twice to find out how rays err here.

use super::{
    Hybrid, Order, Rays,
    bundles::{self, Again},
    refine::Work,
    spread,
    tallies::{FULL, Tally, UNIT, worth},
};
use conray_core::hash_u32;
use rayon::prelude::*;

/// Share of the rays that the lattice gets: with less for it the other half would be placed better, by weighings that take longer
/// than they save;
const FIRST_SHARE: f64 = 0.5;
/// all of so few rays a point: even one other weighing would take the time of more than they are.
const FEW: f64 = 8.0;
/// Least share of points in the lattice: one in 16 x 16.
const WIDEST: f64 = 1.0 / 256.0;
/// From so many rays a point on, the points of the lattice get full bundles, which cost less for each ray.
pub(super) const MANY: f64 = 32.0;
/// Points that are traced again at most, and for how many units of the lattice one is.
const PAIRS: usize = 2048;
const PAIR_OF: usize = 128;
/// Least ratio between what holds of units and of full bundles: as if visibility jumped nowhere.
const LEAST_RATIO: f64 = 0.1;
/// Variance over that of independent rays in each cell, before any pair.
const STRATIFIED: f64 = Rays::UNKNOWN.unit as f64;
/// That guess counts for so many pairs.
const PRIOR_PAIRS: f64 = 64.0;
/// Chooses another sequence for the second of a pair: digits of pi.
pub(super) const SALT: u32 = 0x243f_6a88;

/// How rays err before any told; points of the lattice get so many units.
pub(super) fn unknown(first: u32) -> Rays {
    Rays { first, ..Rays::UNKNOWN }
}

/// Units that points of the lattice get for a budget of so many rays a point.
pub(super) fn first_units(rays_per_point: f64) -> u32 {
    if rays_per_point < MANY { 1 } else { FULL }
}

/// The point to trace again in the `k`th part of so many: anywhere in it, since steps of one length would stay in a few columns of
/// the image.
fn pick(k: usize, every: usize) -> usize {
    k * every + hash_u32(k as u32) as usize % every.max(1)
}

impl Hybrid {
    /// Traces the lattice for a budget of so many rays a point, in bundles that suit it; not started where it was interrupted.
    pub(super) fn start(&mut self, work: &Work<'_>, rays_per_point: f64) {
        let first = first_units(rays_per_point);
        if first != self.rays.first {
            self.unfinished.clear();
        }
        let share = if rays_per_point < FEW { 1.0 } else { FIRST_SHARE };
        let part = (share * rays_per_point / f64::from(first * UNIT)).max(WIDEST) as f32;
        let stride = self.pixels.stride;
        let is_in = |&at: &u32| spread::spread(at as usize % stride, at as usize / stride) < part;
        let lattice: Vec<Order> =
            self.pixels.covered().filter(is_in).map(|at| Order { at, units: first }).collect();
        self.rays = unknown(first);
        if self.trace(work, &lattice, f64::INFINITY) {
            let rays = self.pilot(work, &lattice);
            if self.failure.is_some() {
                // The lattice waits for the pilot.
                let none = vec![Tally::default(); self.pixels.len()];
                self.unfinished = std::mem::replace(&mut self.tallies, none);
                self.units = 0;
                return;
            }
            self.rays = rays;
            self.started = true;
        }
    }

    /// Traces full bundles of other rays at some of the lattice's points: half the squared difference of two that are alike is their
    /// variance. What holds of units and of full bundles then follows from each other, for it is known how much more
    /// a full bundle is worth.
    fn pilot(&mut self, work: &Work<'_>, lattice: &[Order]) -> Rays {
        let first = self.rays.first;
        let pairs = PAIRS.min(lattice.len() * first as usize / PAIR_OF);
        let every = lattice.len() / pairs.max(1);
        let places: Vec<usize> = (0..pairs).map(|k| lattice[pick(k, every)].at as usize).collect();
        let points: Vec<u32> = places.iter().map(|&at| self.pixels.point[at]).collect();
        let again: Vec<Again> = match work.device {
            Some(device) => self.again_on(device, work, &points),
            None => {
                let one =
                    |&point: &u32| bundles::again(work.plan, work.bvh, &work.points[point as usize], SALT);
                points.par_iter().map(one).collect()
            }
        };
        let pair = |(at, again): (&usize, &Again)| {
            let tally = &self.tallies[*at];
            let (off, formal) = if first == FULL {
                (again.mean - tally.mean(), again.in_full + tally.in_fulls)
            } else {
                (again.first - tally.mean(), again.in_units + tally.in_units)
            };
            [off * off, formal, again.in_units, again.in_full].map(f64::from)
        };
        let found: Vec<[f64; 4]> = places.iter().zip(&again).map(pair).collect();
        let [mut squares, mut formal, mut in_units, mut in_fulls] = [0.0; 4];
        for [square, variance, in_unit, in_full] in found {
            squares += square;
            formal += variance;
            in_units += in_unit;
            in_fulls += in_full;
        }
        self.pilot_rays += again.len() as u64 * u64::from(FULL * UNIT);
        let prior = PRIOR_PAIRS * formal / pairs.max(1) as f64;
        let found = if formal > 0.0 { (squares + STRATIFIED * prior) / (formal + prior) } else { STRATIFIED };
        let full_to_unit =
            if in_units > 0.0 { f64::from(worth(FULL as f32)) * in_fulls / in_units } else { 1.0 };
        let [unit, full] = if first == FULL {
            [found * full_to_unit, found]
        } else {
            [found, found / full_to_unit.max(LEAST_RATIO)]
        };
        Rays { unit: unit as f32, full: full as f32, first }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_traced_again_in_all_columns_of_an_image() {
        let (every, width) = (128, 512);
        let columns: std::collections::BTreeSet<usize> = (0..2048)
            .map(|k| {
                let at = pick(k, every);
                assert!((k * every..(k + 1) * every).contains(&at));
                at % width
            })
            .collect();
        assert!(columns.len() > 450, "{}", columns.len());
    }
}
