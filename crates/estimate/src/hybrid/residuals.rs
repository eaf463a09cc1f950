//! How wrong guesses are, found where rays tell.
//!
//! A guess that leaves a pixel's own rays out differs from what those rays say by its own error and by theirs, and the two are
//! independent: the squared difference less the variance of the rays is on average the squared error of the guess. Over the
//! guess's formal variance it is a factor, in which is all that the formula leaves out - above all that visibility is not
//! linear. The factor is taken over like neighbours: sixteen pixels about, then four, then one, each leaning on the wider
//! one before it as on a few samples.

use super::{
    cells::Cells,
    likeness::Centres,
    pixels::Pixels,
    regress::Guess,
    tallies::{Rays, Tally},
    window::{Grid, Window},
};
use conray_bvh::Level;
use conray_core::LANES;
use fearless_simd::{Select, Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;

/// Sums over samples: how many; the variance of a bundle; the variance of all of a sample's rays; and for each size of cells
/// the squared error of the guess, and its formal variance.
const MOST_SUMS: usize = FIXED + 2 * super::weigh::SIZES;
const FIXED: usize = 3;

/// Sums of pixels, or of cells, channel by channel.
pub(super) type Told = Vec<Vec<f32>>;

/// The wider neighbourhood counts for that many samples.
const PRIOR_SAMPLES: f32 = 2.0;
/// Most doubt about a sample whose rays err more than the guess.
const MOST_DOUBT: f32 = 1e4;

/// What each pixel's rays tell of its guesses.
pub(super) fn told(tallies: &[Tally], rays: &Rays, guesses: &[Guess]) -> Told {
    let mut all = vec![vec![0.0; tallies.len()]; FIXED + 2 * guesses.len()];
    in_parts(&mut all, 1 << 12).into_par_iter().enumerate().for_each(|(part, mut out)| {
        for k in 0..out[0].len() {
            let at = (part << 12) + k;
            let tally = &tallies[at];
            if tally.bundles == 0 {
                continue;
            }
            let variance = rays.variance(tally.cells_variance(), tally.bundles);
            out[0][k] = 1.0;
            out[1][k] = tally.cells_variance();
            out[2][k] = variance;
            for (out, guess) in out[FIXED..].chunks_mut(2).zip(guesses) {
                if guess.formal[at].is_finite() {
                    let off = tally.mean() - guess.value[at];
                    out[0][k] = off * off - variance;
                    out[1][k] = guess.formal[at];
                }
            }
        }
    });
    all
}

/// Parts of so many places, each of all channels.
fn in_parts(channels: &mut [Vec<f32>], size: usize) -> Vec<Vec<&mut [f32]>> {
    let parts = channels.first().map_or(0, |c| c.len().div_ceil(size));
    let mut out: Vec<Vec<&mut [f32]>> = (0..parts).map(|_| Vec::new()).collect();
    for channel in channels {
        out.iter_mut().zip(channel.chunks_mut(size)).for_each(|(out, part)| out.push(part));
    }
    out
}

/// Sums over the pixels that were merged into each cell.
pub(super) fn of_cells(pixels: &Pixels, cells: &Cells<'_>, size: usize, own: &[f32], told: &Told) -> Told {
    let rows: Vec<[f32; MOST_SUMS]> = (0..cells.stride * cells.height)
        .into_par_iter()
        .with_min_len(64)
        .map(|cell| {
            let (cx, cy) = (cell % cells.stride, cell / cells.stride);
            let mut sums = [0.0; MOST_SUMS];
            for y in cy << size..((cy + 1) << size).min(pixels.height) {
                for x in cx << size..((cx + 1) << size).min(pixels.width) {
                    let at = y * pixels.stride + x;
                    if own[at] > 0.0 {
                        for (sum, told) in sums.iter_mut().zip(told) {
                            *sum += told[at];
                        }
                    }
                }
            }
            sums
        })
        .collect();
    channels(&rows, told.len())
}

/// Rows of sums, channel by channel.
fn channels(rows: &[[f32; MOST_SUMS]], count: usize) -> Told {
    (0..count).into_par_iter().map(|k| rows.iter().map(|row| row[k]).collect()).collect()
}

/// What is known about errors: the variance of a bundle whose rays are independent in each cell of the square; then, for each
/// size of cells, the squared error of its guesses over their formal variance.
#[derive(Clone, Debug)]
pub(super) enum Local {
    /// The same everywhere.
    Everywhere(Vec<f32>),
    /// At each pixel, channel by channel.
    Pixels(Vec<Vec<f32>>),
}

impl Local {
    /// From all samples together.
    pub(super) fn everywhere(told: &Told) -> Self {
        let sums: Vec<f64> = told.par_iter().map(|t| t.iter().map(|&x| f64::from(x)).sum()).collect();
        let ratio =
            |a: usize, b: usize, none: f32| if sums[b] > 0.0 { (sums[a] / sums[b]) as f32 } else { none };
        let factors = (FIXED..told.len()).step_by(2).map(|k| ratio(k, k + 1, 1.0).max(0.0));
        Self::Everywhere(std::iter::once(ratio(1, 0, 0.0)).chain(factors).collect())
    }

    /// One channel at a pixel.
    pub(super) fn at(&self, channel: usize, at: usize) -> f32 {
        match self {
            Self::Everywhere(values) => values[channel],
            Self::Pixels(channels) => channels[channel][at],
        }
    }

    /// With what the like samples in the 3 x 3 cells about each pixel tell.
    pub(super) fn refined(
        self,
        level: Level,
        pixels: &Pixels,
        cells: &Cells<'_>,
        size: usize,
        told: &Told,
    ) -> Self {
        let mut channels: Vec<&[f32]> = told.iter().map(|t| &t[..]).collect();
        channels.extend(cells.channels[2..].iter().map(|c| &c[..]));
        let grid =
            Grid { width: cells.width, height: cells.height, stride: cells.stride, channels: &channels };
        let rows = pixels.stride << size;
        let (everywhere, mut out) = match self {
            Self::Everywhere(values) => {
                let out = values.iter().map(|_| vec![0.0; pixels.len()]).collect();
                (Some(values), out)
            }
            Self::Pixels(channels) => (None, channels),
        };
        let window = || Window::new(pixels.stride, size, 1, channels.len());
        in_parts(&mut out, rows).into_par_iter().enumerate().for_each_init(
            window,
            |window, (row, mut out)| {
                window.load(&grid, row, size);
                if let Some(values) = &everywhere {
                    out.iter_mut().zip(values).for_each(|(out, value)| out.fill(*value));
                }
                for x in (0..out[0].len()).step_by(LANES) {
                    let at = row * rows + x;
                    if (at..at + LANES).any(|at| pixels.is_covered(at)) {
                        dispatch!(level, simd => sixteen(simd, pixels, window, size, at, x, &mut out));
                    }
                }
            },
        );
        Self::Pixels(out)
    }
}

/// Sixteen pixels, places `x` and on of the variance and the factors.
#[inline(always)]
fn sixteen<S: Simd>(
    simd: S,
    pixels: &Pixels,
    window: &Window,
    size: usize,
    at: usize,
    x: usize,
    out: &mut [&mut [f32]],
) {
    let centres = Centres::load(simd, pixels, at, size);
    let (zero, column_of_image) = (f32x16::splat(simd, 0.0), at % pixels.stride);
    let mut sums = [zero; MOST_SUMS];
    let told = FIXED + 2 * (out.len() - 1);
    for row in 0..3 {
        for column in 0..3 {
            let load = |channel: usize| window.sixteen(channel, [column, row], column_of_image, size);
            let away = [
                f32x16::from_slice(simd, load(told)) - centres.position[0],
                f32x16::from_slice(simd, load(told + 1)) - centres.position[1],
                f32x16::from_slice(simd, load(told + 2)) - centres.position[2],
            ];
            let normal = [
                f32x16::from_slice(simd, load(told + 3)),
                f32x16::from_slice(simd, load(told + 4)),
                f32x16::from_slice(simd, load(told + 5)),
            ];
            let near = centres.likeness(simd, away, normal).near;
            for (k, sum) in sums.iter_mut().enumerate().take(told) {
                *sum += near * f32x16::from_slice(simd, load(k));
            }
        }
    }
    let samples = sums[0];
    let one = f32x16::splat(simd, 1.0);
    for (k, out) in out.iter_mut().enumerate() {
        let out = &mut out[x..x + LANES];
        let before = f32x16::from_slice(simd, out);
        let (found, over, doubt) = if k == 0 {
            (sums[1], samples, one)
        } else {
            let (found, over) = (sums[FIXED + 2 * k - 2], sums[FIXED + 2 * k - 1]);
            // Rays that err more than the guess say little of it, unless they find more than twice what n samples of their own
            // variance scatter by: the square root of 2/n of it.
            let chance = sums[2] * (f32x16::splat(simd, 8.0) / samples.max(one)).sqrt();
            let sure = (before * over).max(found - chance).max(f32x16::splat(simd, f32::MIN_POSITIVE));
            let noise = one + sums[2] / sure;
            (found, over, (noise * noise).min(f32x16::splat(simd, MOST_DOUBT)))
        };
        let prior = doubt * f32x16::splat(simd, PRIOR_SAMPLES);
        let here = over.simd_gt(zero).select(found / over, before);
        (here + (before - here) * (prior / (samples + prior))).max(zero).store_slice(out);
    }
}
