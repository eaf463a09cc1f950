//! The first rays: a lattice of points, some traced twice to find out how rays err here.

use super::{Hybrid, NO_POINT, Order, Rays, bundles, refine::Work, tallies::Bundle};
use rayon::prelude::*;

/// Share of the rays that the lattice gets.
const FIRST_SHARE: f64 = 0.25;
/// Most pixels between points of the lattice, as a power of two.
const WIDEST: f64 = 4.0;
/// Points that are traced twice at most, and of how many one is.
const PAIRS: usize = 2048;
const PAIR_OF: usize = 16;
/// Variance of a bundle over that of independent rays in its cells, before any pair: about what scenes have.
pub(super) const STRATIFIED: f64 = 0.5;
/// That guess counts for so many pairs.
const PRIOR_PAIRS: f64 = 64.0;
/// Chooses another sequence for the second of a pair: digits of pi.
pub(super) const SALT: u32 = 0x243f_6a88;

impl Hybrid {
    /// Traces the lattice for a budget of so many rays a point, in bundles that suit it; not started where it was interrupted.
    pub(super) fn start(&mut self, work: &Work<'_>, rays_per_point: f64) {
        let unit = Bundle::of(rays_per_point);
        if unit != self.rays.unit {
            self.unfinished.clear();
        }
        let area = f64::from(unit.rays) / (FIRST_SHARE * rays_per_point.max(f64::MIN_POSITIVE));
        let step = 1 << (0.5 * area.log2()).ceil().clamp(0.0, WIDEST) as usize;
        let pixels = &self.pixels;
        let in_lattice = |&&at: &&u32| {
            let (x, y) = (at as usize % pixels.stride, at as usize / pixels.stride);
            at != NO_POINT && x % step == step / 2 && y % step == step / 2
        };
        let lattice: Vec<Order> =
            pixels.place_of.iter().filter(in_lattice).map(|&at| Order { at, bundles: 1 }).collect();
        self.rays = Rays { unit, stratified: STRATIFIED as f32 };
        if self.trace(work, &lattice, f64::INFINITY) {
            self.rays = self.pilot(work, &lattice);
            self.started = true;
        }
    }

    /// Traces some of the lattice's points again, with other rays: half the squared difference is the variance of a bundle.
    fn pilot(&mut self, work: &Work<'_>, lattice: &[Order]) -> Rays {
        let unit = self.rays.unit;
        let pairs = PAIRS.min(lattice.len() / PAIR_OF);
        let every = lattice.len() / pairs.max(1);
        let pair = |k: usize| {
            let at = lattice[k * every].at as usize;
            let first = &self.tallies[at];
            let point = &work.points[self.pixels.point[at] as usize];
            let again = bundles::trace(work.plan, work.bvh, point, unit, 0..1, SALT);
            let off = f64::from(again.mean() - first.mean());
            [off * off, f64::from(again.variance + first.variance)]
        };
        let found: Vec<[f64; 2]> = (0..pairs).into_par_iter().map(pair).collect();
        let (mut squares, mut formal) = (0.0, 0.0);
        for [square, variance] in found {
            squares += square;
            formal += variance;
        }
        self.pilot_rays += pairs as u64 * u64::from(unit.rays);
        let prior = PRIOR_PAIRS * formal / pairs.max(1) as f64;
        let stratified =
            if formal > 0.0 { (squares + STRATIFIED * prior) / (formal + prior) } else { STRATIFIED };
        Rays { unit, stratified: stratified as f32 }
    }
}
