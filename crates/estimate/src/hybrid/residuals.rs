//! How wrong guesses are, found where rays tell.
//!
//! A guess that leaves a pixel's own rays out differs from what those rays say by its own error and by theirs, and the two are
//! independent: the squared difference less the variance of the rays is on average the squared error of the guess. Over the
//! guess's formal variance it is a factor, in which is all that the formula leaves out - above all that visibility is not
//! linear. The factor is taken over like neighbours: sixteen pixels about, then four, then one, each leaning on the wider
//! one before it as on a few samples.

use super::{
    HybridConstants,
    likeness::Centres,
    pixels::Pixels,
    told::{Everywhere, FIXED, Told},
    weigh::SIZES,
    window::Window,
};
use fearless_simd::{Select, Simd, f32x16, prelude::*};
use std::ops::Range;

/// Most doubt about a sample whose rays err more than the guess.
const MOST_DOUBT: f32 = 1e4;

/// What is known about errors at sixteen pixels.
pub(super) struct Local<S: Simd> {
    /// Variance of one unit of rays.
    pub(super) unit_variance: f32x16<S>,
    /// For each size of cells the squared error of its guesses over their formal variance.
    pub(super) factors: [f32x16<S>; SIZES],
}

impl<S: Simd> Local<S> {
    #[inline(always)]
    pub(super) fn everywhere(simd: S, everywhere: &Everywhere) -> Self {
        let mut factors = [f32x16::splat(simd, 1.0); SIZES];
        for (factor, &value) in factors.iter_mut().zip(&everywhere.factors) {
            *factor = f32x16::splat(simd, value);
        }
        Self { unit_variance: f32x16::splat(simd, everywhere.unit_variance), factors }
    }

    /// With what the like samples in the 3 x 3 cells about tell of some sizes. `told` is that of the window, `at` the first
    /// pixel.
    #[inline(always)]
    pub(super) fn refine(
        &mut self,
        simd: S,
        constants: &HybridConstants,
        pixels: &Pixels,
        (told, window): (&Told<'_>, &Window),
        at: usize,
        sizes: Range<usize>,
    ) {
        let (size, x, place) = (told.size, at % pixels.stride, FIXED + 2 * told.guesses);
        let centres = Centres::load(simd, pixels, constants, at, size);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let mut near = [zero; 9];
        let (mut samples, mut unit_variance, mut variance) = (zero, zero, zero);
        for (k, near) in near.iter_mut().enumerate() {
            let to = [k % 3, k / 3];
            let dx = f32x16::from_slice(simd, window.sixteen(place, to, x, size)) - centres.position[0];
            let dy = f32x16::from_slice(simd, window.sixteen(place + 1, to, x, size)) - centres.position[1];
            let dz = f32x16::from_slice(simd, window.sixteen(place + 2, to, x, size)) - centres.position[2];
            let normal = [
                f32x16::from_slice(simd, window.sixteen(place + 3, to, x, size)),
                f32x16::from_slice(simd, window.sixteen(place + 4, to, x, size)),
                f32x16::from_slice(simd, window.sixteen(place + 5, to, x, size)),
            ];
            *near = centres.likeness(simd, [dx, dy, dz], normal).near;
            samples += *near * f32x16::from_slice(simd, window.sixteen(0, to, x, size));
            unit_variance += *near * f32x16::from_slice(simd, window.sixteen(1, to, x, size));
            variance += *near * f32x16::from_slice(simd, window.sixteen(2, to, x, size));
        }
        let prior = f32x16::splat(simd, constants.prior_samples);
        self.unit_variance = leaning(simd, [unit_variance, samples], self.unit_variance, samples, prior);
        // Rays that err more than the guess say little of it, unless they find far more than n samples of their own variance
        // scatter by: the square root of 2/n of it.
        let scatter = (f32x16::splat(simd, 2.0) / samples.max(one)).sqrt();
        let chance = variance * scatter * f32x16::splat(simd, constants.beyond_chance);
        for guess in sizes {
            let (mut found, mut over) = (zero, zero);
            for (k, &near) in near.iter().enumerate() {
                let to = [k % 3, k / 3];
                found += near * f32x16::from_slice(simd, window.sixteen(FIXED + 2 * guess, to, x, size));
                over += near * f32x16::from_slice(simd, window.sixteen(FIXED + 2 * guess + 1, to, x, size));
            }
            let before = self.factors[guess];
            let sure = (before * over).max(found - chance).max(f32x16::splat(simd, f32::MIN_POSITIVE));
            let noise = one + variance / sure;
            let doubt = (noise * noise).min(f32x16::splat(simd, MOST_DOUBT));
            self.factors[guess] = leaning(simd, [found, over], before, samples, doubt * prior);
        }
    }
}

/// The ratio found here, leaning on the one before as on so many samples.
#[inline(always)]
fn leaning<S: Simd>(
    simd: S,
    [found, over]: [f32x16<S>; 2],
    before: f32x16<S>,
    samples: f32x16<S>,
    prior: f32x16<S>,
) -> f32x16<S> {
    let zero = f32x16::splat(simd, 0.0);
    let here = over.simd_gt(zero).select(found / over, before);
    (here + (before - here) * (prior / (samples + prior))).max(zero)
}
