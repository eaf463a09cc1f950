//! What rays, neighbours and errors come to: each weighed by its expected squared error.

use super::{
    cells::Pyramid,
    pixels::Pixels,
    regress::{Guess, guesses, usable},
    residuals::{self, Local},
    tallies::{Rays, Tally, mean_bundle},
};
use conray_bvh::Level;
use rayon::prelude::*;

/// Sizes of cells, pixels among them.
pub(super) const SIZES: usize = 5;
/// Sizes over whose cells errors are looked at, the widest first.
const ERROR_SIZES: [usize; 3] = [4, 2, 0];
/// Squared error of saying one half where nothing is known.
const UNKNOWN: f32 = 0.05;
/// The least that a guess can err: the noise of its neighbours' rays alone, which are a little better together than apart.
const LEAST_NOISE: f32 = 0.7;

/// What is known of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    /// Visibility.
    pub(super) value: f32,
    /// Its expected squared error.
    pub(super) error2: f32,
    /// Expected squared error of what the neighbours say, the pixel's own rays left out.
    pub(super) guess_error2: f32,
    /// Variance of a bundle within cells of the square.
    pub(super) cells_variance: f32,
}

impl Known {
    /// Nothing.
    pub(super) const NOTHING: Self =
        Self { value: 0.5, error2: UNKNOWN, guess_error2: UNKNOWN, cells_variance: 0.25 };
}

/// Weighs all that is known.
pub(super) fn weigh(level: Level, pixels: &Pixels, tallies: &[Tally], rays: &Rays) -> Vec<Known> {
    let of_each =
        |f: fn(&Tally) -> f32| tallies.par_iter().with_min_len(1 << 12).map(f).collect::<Vec<f32>>();
    let (bundles, mean) = (of_each(|t| t.bundles as f32), of_each(Tally::mean));
    let pyramid = Pyramid::new(pixels, &bundles, &mean, SIZES);
    let bundle = mean_bundle(tallies, rays);
    let guesses = guesses(level, pixels, &pyramid, &mean, bundle);
    let told = residuals::told(tallies, rays, &guesses);
    let mut local = Local::everywhere(&told);
    for size in ERROR_SIZES {
        let (cells, own) = (&pyramid.cells[size], &pyramid.own[size]);
        local = if size == 0 {
            local.refined(level, pixels, cells, size, &told)
        } else {
            local.refined(level, pixels, cells, size, &residuals::of_cells(pixels, cells, size, own, &told))
        };
    }
    let known = |at: usize| {
        if pixels.is_covered(at) { one(at, tallies, rays, &guesses, &local) } else { Known::NOTHING }
    };
    (0..pixels.len()).into_par_iter().with_min_len(1 << 12).map(known).collect()
}

fn one(at: usize, tallies: &[Tally], rays: &Rays, guesses: &[Guess], local: &Local) -> Known {
    let cells_variance = local.at(0, at);
    let bundle = rays.bundle(cells_variance);
    let (mut weights, mut value, mut error2) = (0.0, 0.0, 0.0);
    for size in usable(guesses, at) {
        let (guess, factor) = (&guesses[size], local.at(1 + size, at));
        let formal = guess.formal[at];
        if formal.is_finite() {
            let expected = formal * f32::max(factor, LEAST_NOISE * bundle);
            // Both see the same neighbours, so that their mean is no better than they are; the better one counts more.
            let weight = 1.0 / (expected * expected);
            weights += weight;
            value += weight * guess.value[at];
            error2 += weight * expected;
        }
    }
    let (guess, guess_error2) =
        if weights > 0.0 { (value / weights, (error2 / weights).min(UNKNOWN)) } else { (0.5, UNKNOWN) };
    let tally = &tallies[at];
    let own_error2 = rays.variance(cells_variance, tally.bundles);
    let value = if tally.bundles == 0 {
        guess
    } else {
        (guess * own_error2 + tally.mean() * guess_error2) / (own_error2 + guess_error2)
    };
    Known { value, error2: together(guess_error2, own_error2), guess_error2, cells_variance }
}

/// Expected squared error of the mean of two, weighted by their own.
pub(super) fn together(a: f32, b: f32) -> f32 {
    if b == f32::INFINITY { a } else { a * b / (a + b) }
}
