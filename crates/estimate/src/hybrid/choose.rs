//! Who gets rays next.

use super::{
    pixels::{NO_POINT, Pixels},
    tallies::{Rays, Tally},
    weigh::{Known, together},
};
use rayon::prelude::*;

/// Share of the mean number of bundles that every point must have.
const LEAST_SHARE: f64 = 0.5;

/// A point's first rays count for so much more: they also help its neighbours, and find out where guesses are wrong.
const FIRST_RAYS: f32 = 4.0;

/// A point and the bundles that it is to get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Order {
    /// Place of its pixel.
    pub(super) at: u32,
    pub(super) bundles: u32,
}

/// What a bundle would gain at one point.
#[derive(Clone, Copy)]
struct Candidate {
    /// Bits of the gain, which is not negative: they order as it does.
    gain: u32,
    order: Order,
}

/// Orders for `budget` bundles in all, or a few less; in the order of the points, whose neighbours then share what they meet.
///
/// Neyman's rule, a step at a time: a bundle goes where it lowers the expected squared error most. A point without rays gets
/// one, one that has some gets as many again, since sequences are best at powers of two. Errors are only estimates, so no
/// point is left far behind the mean.
pub(super) fn choose(
    pixels: &Pixels,
    tallies: &[Tally],
    known: &[Known],
    rays: &Rays,
    budget: u64,
) -> Vec<Order> {
    let points = pixels.place_of.len().max(1);
    let had: u64 = tallies.iter().map(|t| u64::from(t.bundles)).sum();
    let least = (LEAST_SHARE * had as f64 / points as f64) as u32;
    let candidate = |&at: &u32| {
        if at == NO_POINT {
            return Candidate { gain: 0, order: Order { at, bundles: 0 } };
        }
        let (index, x, y) = (at as usize, at as usize % pixels.stride, at as usize / pixels.stride);
        let had = tallies[index].bundles;
        let bundles = had.max(1);
        let known = &known[index];
        let after = |bundles| together(known.guess_error2, rays.variance(known.cells_variance, bundles));
        let first = if had == 0 { FIRST_RAYS } else { 1.0 };
        let gain = first * (after(had) - after(had + bundles)) / bundles as f32 * dither(x, y);
        let gain = if had < least { f32::INFINITY } else { gain.max(0.0) };
        Candidate { gain: gain.to_bits(), order: Order { at, bundles } }
    };
    let candidates: Vec<Candidate> =
        pixels.place_of.par_iter().with_min_len(1 << 12).map(candidate).collect();
    let least_gain = threshold(&candidates, budget);
    // Of those that gain just as much, the first ones.
    let above = |c: &&Candidate| c.gain > least_gain;
    let mut left = budget - candidates.iter().filter(above).map(|c| u64::from(c.order.bundles)).sum::<u64>();
    let mut chosen = |c: &Candidate| {
        let cost = u64::from(c.order.bundles);
        let fits = c.gain == least_gain && cost <= left && cost > 0;
        left -= if fits { cost } else { 0 };
        c.gain > least_gain || fits
    };
    candidates.iter().filter(|c| chosen(c)).map(|c| c.order).collect()
}

/// The least gain above which the budget pays for all.
fn threshold(candidates: &[Candidate], budget: u64) -> u32 {
    let cost = |gain: u32| -> u64 {
        let above = candidates.par_iter().with_min_len(1 << 12).filter(|c| c.gain > gain);
        above.map(|c| u64::from(c.order.bundles)).sum()
    };
    let (mut low, mut high) = (0, f32::INFINITY.to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        if cost(middle) <= budget {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

/// Between 0.6 and 1.4, each value at pixels far from each other: where some of many like pixels are chosen they are spread.
///
/// Ranks of an 8 x 8 matrix as in Bayer, "An Optimum Method for Two-Level Rendition of Continuous-Tone Pictures", 1973.
fn dither(x: usize, y: usize) -> f32 {
    let mut rank = 0;
    for bit in 0..3 {
        let (x, y) = (x >> bit & 1, y >> bit & 1);
        rank = rank * 4 + 2 * (x ^ y) + y;
    }
    0.6 + 0.8 * (rank as f32 + 0.5) / 64.0
}
