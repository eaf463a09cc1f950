//! What rays, neighbours and errors come to: each weighed by its expected squared error.

use super::{
    HybridConstants,
    cells::Pyramid,
    columns::{Columns, in_parts},
    guesses::{Guess, Guesses},
    pixels::Pixels,
    residuals::Local,
    tallies::{Rays, Tally},
    told::{Everywhere, Sums, Told},
    window::Window,
};
use conray_bvh::Level;
use conray_core::LANES;
use fearless_simd::{Select, Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;
use std::ops::Range;

/// Sizes of cells, pixels among them.
pub(super) const SIZES: usize = 5;
/// Sizes over whose cells errors are looked at before single pixels, the widest last.
const ERROR_SIZES: [usize; 2] = [2, 4];
/// Squared error of saying one half where nothing is known.
const UNKNOWN: f32 = 0.05;

/// What is known of each place once rays and neighbours were weighed, one value a place; those without a point are of no meaning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// Visibility, from 0 to 1.
    pub value: Vec<f32>,
    /// Its expected squared error.
    pub error2: Vec<f32>,
    /// Expected squared error of what the neighbours say, the place's own rays left out.
    pub guess_error2: Vec<f32>,
    /// Variance of the mean of one unit of rays.
    pub unit_variance: Vec<f32>,
    /// Mean squared error of one unit of rays over all places that have some.
    pub unit: f32,
}

/// Weighs all that is known; holds its memory for the next time.
#[derive(Clone, Debug, Default)]
pub(super) struct Weigher {
    columns: Columns,
    pyramid: Pyramid,
    guesses: Guesses,
    sums: [Sums; ERROR_SIZES.len()],
}

impl Weigher {
    /// Brings what is known up to date.
    pub(super) fn weigh(
        &mut self,
        level: Level,
        constants: &HybridConstants,
        pixels: &Pixels,
        tallies: &[Tally],
        rays: &Rays,
        known: &mut Known,
    ) {
        let Self { columns, pyramid, guesses, sums } = self;
        columns.fill(pixels, tallies, rays);
        pyramid.build(pixels, columns, SIZES);
        guesses.make(level, constants, pixels, columns, pyramid, rays);
        let of_pixels = Told::of_pixels(pixels, columns, pyramid, guesses);
        for (sums, size) in sums.iter_mut().zip(ERROR_SIZES) {
            sums.fill(pixels, columns, pyramid, &of_pixels, size);
        }
        let everywhere = sums[0].everywhere();
        known.unit = columns.unit;
        let mut told = vec![of_pixels];
        told.extend(sums.iter().map(|sums| Told::of_cells(sums, pixels, columns, pyramid)));
        let guesses = guesses.of_sizes();
        let witnesses = Witnesses { constants, pixels, columns, guesses, told, everywhere, rays };
        let mut out =
            [&mut known.value, &mut known.error2, &mut known.guess_error2, &mut known.unit_variance];
        out.iter_mut().for_each(|out| out.resize(pixels.len(), 0.0));
        let windows = || witnesses.told.iter().map(|told| told.window(pixels)).collect::<Vec<_>>();
        // Rows by fours, which share the rows of cells.
        let rows = in_parts(&mut out, 4 * pixels.stride);
        rows.into_par_iter().enumerate().for_each_init(windows, |windows, (part, mut out)| {
            for x in (0..out[0].len()).step_by(LANES) {
                let at = part * 4 * pixels.stride + x;
                if x % pixels.stride == 0 {
                    let row = at / pixels.stride;
                    witnesses
                        .told
                        .iter()
                        .zip(&mut *windows)
                        .for_each(|(told, window)| told.load(window, row));
                }
                if (at..at + LANES).any(|at| pixels.is_covered(at)) {
                    dispatch!(level, simd => sixteen(simd, &witnesses, windows, at, x, &mut out));
                }
            }
        });
    }
}

/// All that is known before it is weighed.
struct Witnesses<'a> {
    constants: &'a HybridConstants,
    pixels: &'a Pixels,
    columns: &'a Columns,
    guesses: &'a [Guess],
    /// Of pixels, then of ever wider cells.
    told: Vec<Told<'a>>,
    everywhere: Everywhere,
    rays: &'a Rays,
}

/// Sixteen pixels, `at` and on, places `x` and on of the parts: value, error, error of the guess, variance.
#[inline(always)]
fn sixteen<S: Simd>(
    simd: S,
    witnesses: &Witnesses<'_>,
    windows: &[Window],
    at: usize,
    x: usize,
    out: &mut [&mut [f32]],
) {
    let Witnesses { constants, pixels, columns, rays, .. } = *witnesses;
    let splat = |value: f32| f32x16::splat(simd, value);
    let (zero, one) = (splat(0.0), splat(1.0));
    let usable = usable(simd, witnesses.guesses, rays.enough(), at);
    let mut local = Local::everywhere(simd, &witnesses.everywhere);
    for (told, window) in witnesses.told.iter().zip(windows).rev() {
        local.refine(simd, constants, pixels, (told, window), at, usable.sizes.clone());
    }
    let unit = local.unit_variance;
    let least = splat(constants.least_noise) * unit;
    let (mut weights, mut value, mut error2) = (zero, zero, zero);
    for size in usable.sizes {
        let guess = &witnesses.guesses[size];
        let formal = f32x16::from_slice(simd, &guess.formal[at..at + LANES]);
        let used = formal.simd_lt(splat(f32::MAX))
            & usable.first.simd_le(splat(size as f32))
            & usable.first.simd_ge(splat(size as f32 - 1.0));
        let expected = formal * local.factors[size].max(least) + splat(Rays::UNSEEN) * formal * formal;
        // Both see the same neighbours, so that their mean is no better than they are; the better one counts more.
        let weight = used.select(one / (expected * expected), zero);
        weights += weight;
        value += used.select(weight * f32x16::from_slice(simd, &guess.value[at..at + LANES]), zero);
        error2 += used.select(weight * expected, zero);
    }
    let some = weights.simd_gt(zero);
    let guess = some.select(value / weights, splat(0.5));
    let found_error2 = some.select(error2 / weights, splat(UNKNOWN));
    let guess_error2 = found_error2.min(splat(UNKNOWN));
    let worth = f32x16::from_slice(simd, &columns.worth[at..at + LANES]);
    let mean = f32x16::from_slice(simd, &columns.mean[at..at + LANES]);
    let unseen = f32x16::from_slice(simd, &columns.unseen[at..at + LANES]);
    let sampled = worth.simd_gt(zero);
    let own_error2 = sampled.select(unit / worth + unseen, one);
    let units = (splat(Rays::UNSEEN) / unseen.max(splat(f32::MIN_POSITIVE))).sqrt();
    let doubted = found_error2 * (one + units * splat(1.0 / constants.doubt_units));
    // One half is said of what nothing is known of, and no rays are pulled there.
    let share = sampled.select(some.select(doubted / (own_error2 + doubted), one), zero);
    let rest = one - share;
    let value = (guess + (mean - guess) * share).max(zero).min(one);
    let error2 = sampled.select(own_error2 * share * share + guess_error2 * rest * rest, guess_error2);
    for (out, found) in out.iter_mut().zip([value, error2, guess_error2, local.unit_variance]) {
        found.store_slice(&mut out[x..x + LANES]);
    }
}

/// The guesses of sixteen pixels that count.
struct Usable<S: Simd> {
    /// For each pixel the finest size that says enough, else the finest that says anything; it counts, and the next.
    first: f32x16<S>,
    /// Those that count anywhere.
    sizes: Range<usize>,
}

#[inline(always)]
fn usable<S: Simd>(simd: S, guesses: &[Guess], least: f32, at: usize) -> Usable<S> {
    let none = guesses.len() as f32;
    let (mut enough, mut any) = (f32x16::splat(simd, none), f32x16::splat(simd, none));
    for (size, guess) in guesses.iter().enumerate().rev() {
        let formal = f32x16::from_slice(simd, &guess.formal[at..at + LANES]);
        let this = f32x16::splat(simd, size as f32);
        enough = formal.simd_le(f32x16::splat(simd, least)).select(this, enough);
        any = formal.simd_lt(f32x16::splat(simd, f32::MAX)).select(this, any);
    }
    let first = enough.simd_lt(f32x16::splat(simd, none)).select(enough, any);
    let of_each: [f32; LANES] = first.into();
    let (mut low, mut high) = (guesses.len(), 0);
    for first in of_each {
        low = low.min(first as usize);
        high = high.max((first as usize + 2).min(guesses.len()));
    }
    Usable { first, sizes: low..high.max(low) }
}
