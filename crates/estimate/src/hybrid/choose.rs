//! Who gets rays next.

use super::{
    HybridConstants,
    columns::PART,
    pixels::Pixels,
    spread::spread,
    tallies::{FULL, Rays, Tally},
    weigh::Known,
};
use rayon::prelude::*;

/// Share of the time of a full bundle that a bundle of no rays takes: a unit takes 0.45 of it.
const START: f32 = 0.27;

/// Bits of a gain that are looked at at once.
const DIGIT: u32 = u16::BITS;
/// Parts that one thread counts at least, for its counts have to be added up.
const AT_ONCE: usize = 16;

/// A point and the units that it is to get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Order {
    /// Place of its pixel.
    pub(super) at: u32,
    pub(super) units: u32,
}

/// What more rays would gain at one point: a step, and a further one that gains less for its time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Candidate {
    /// Bits of the gains, which are not negative: they order as those do.
    gains: [u32; 2],
    units: [u32; 2],
}

/// Orders for `budget` units more than the `had` so far, or a few less; in the order of the points, whose neighbours then share what they meet.
///
/// Neyman's rule, in steps: rays go where they lower the expected squared error most for their time. Steps double what
/// a point has, since sequences are best at powers of two, or make a full bundle of it. Errors are only estimates, so no point is
/// left far behind the mean.
pub(super) fn choose(
    constants: &HybridConstants,
    pixels: &Pixels,
    tallies: &[Tally],
    known: &Known,
    rays: &Rays,
    had: u64,
    budget: u64,
) -> Vec<Order> {
    let (points, lattice) = (pixels.place_of.len().max(1), rays.first);
    let least = (f64::from(constants.least_share) * had as f64 / (points as f64 * f64::from(lattice))) as u32
        * lattice;
    let candidate = |at: usize| {
        if pixels.is_covered(at) {
            let dither = dither(at % pixels.stride, at / pixels.stride);
            candidate(constants, known, at, tallies[at].units, [lattice, least], dither)
        } else {
            Candidate::default()
        }
    };
    let candidates: Vec<Candidate> =
        (0..pixels.len()).into_par_iter().with_min_len(1 << 12).map(candidate).collect();
    let (least_gain, mut left) = threshold(&candidates, budget);
    let above = |(part, candidates): (usize, &[Candidate])| {
        let ties = candidates.iter().any(|candidate| candidate.gains.contains(&least_gain));
        (orders_of(part, candidates, least_gain, &mut 0), ties)
    };
    let parts: Vec<(Vec<Order>, bool)> = candidates.par_chunks(PART).enumerate().map(above).collect();
    // Of those that gain just as much, the first ones: one part after the other, where there are any.
    let with_ties = |(part, (above, ties)): (usize, (Vec<Order>, bool))| {
        let from = part * PART;
        let candidates = &candidates[from..(from + PART).min(candidates.len())];
        if ties && left > 0 { orders_of(part, candidates, least_gain, &mut left) } else { above }
    };
    parts.into_iter().enumerate().flat_map(with_ties).collect()
}

/// Orders for the steps of a part that gain more than that, and for those that gain as much while there are units left.
fn orders_of(part: usize, candidates: &[Candidate], least_gain: u32, left: &mut u64) -> Vec<Order> {
    let mut orders = Vec::new();
    for (k, Candidate { gains, units }) in candidates.iter().enumerate() {
        let mut order = Order { at: (part * PART + k) as u32, units: 0 };
        for (&gain, &units) in gains.iter().zip(units) {
            let fits = gain == least_gain && u64::from(units) <= *left;
            *left -= if fits { u64::from(units) } else { 0 };
            order.units += if gain > least_gain || fits { units } else { 0 };
        }
        if order.units > 0 {
            orders.push(order);
        }
    }
    orders
}

/// The steps of a point that has so many units; one that has less than `least` must take the first.
fn candidate(
    constants: &HybridConstants,
    known: &Known,
    at: usize,
    had: u32,
    [lattice, least]: [u32; 2],
    dither: f32,
) -> Candidate {
    let (guess_error2, unit_variance) = (known.guess_error2[at], known.unit_variance[at]);
    let after = |units| {
        let own = if units == 0 { f32::INFINITY } else { Rays::variance(unit_variance, units) };
        together(guess_error2, own)
    };
    let near = (2 * had).max(1);
    let far = if had > 0 { near.max(FULL) } else { lattice };
    let first = if had == 0 { constants.first_rays } else { 1.0 };
    let gain = |from, to| dither * first * (after(from) - after(to)) / (time(to - had) - time(from - had));
    let (step, further) = (gain(had, near), if far > near { gain(near, far) } else { 0.0 });
    let (gains, units) = if further <= step {
        ([step, further], [near - had, far - near])
    } else {
        ([gain(had, far), 0.0], [far - had, 0])
    };
    let must = if had < least { f32::INFINITY } else { 0.0 };
    Candidate { gains: [gains[0].max(must), gains[1].max(0.0)].map(f32::to_bits), units }
}

/// Expected squared error of the mean of two, weighted by their own.
fn together(a: f32, b: f32) -> f32 {
    if b == f32::INFINITY { a } else { a * b / (a + b) }
}

/// Time that tracing so many units at one point takes, in that of a full bundle.
fn time(units: u32) -> f32 {
    let bundles = units as f32 / FULL as f32;
    if units > 0 && bundles < 1.0 { START + (1.0 - START) * bundles } else { bundles }
}

/// The least gain above which the budget pays for all, and what is left of it.
fn threshold(candidates: &[Candidate], budget: u64) -> (u32, u64) {
    // Digit by digit, from the highest down: as many as the budget pays for.
    let (mut found, mut left) = (0, budget);
    for shift in [DIGIT, 0] {
        let count = |mut costs: Vec<u64>, candidates: &[Candidate]| {
            for Candidate { gains, units } in candidates {
                for (gain, &units) in gains.iter().zip(units) {
                    if shift == DIGIT || gain >> DIGIT == found >> DIGIT {
                        costs[(gain >> shift) as usize % (1 << DIGIT)] += u64::from(units);
                    }
                }
            }
            costs
        };
        let add = |mut all: Vec<u64>, more: Vec<u64>| {
            all.iter_mut().zip(more).for_each(|(all, more)| *all += more);
            all
        };
        let none = || vec![0; 1 << DIGIT];
        let costs = candidates.par_chunks(PART).with_min_len(AT_ONCE).fold(none, count).reduce(none, add);
        let mut digit = costs.len() - 1;
        while digit > 0 && costs[digit] <= left {
            left -= costs[digit];
            digit -= 1;
        }
        found |= (digit as u32) << shift;
    }
    (found, left)
}

/// Between 0.6 and 1.4, each value at pixels far from each other: where some of many like pixels are chosen they are spread.
fn dither(x: usize, y: usize) -> f32 {
    0.6 + 0.8 * spread(x, y)
}
