//! How like two places of a surface are, for sixteen places at a time.

use super::{HybridConstants, pixels::Pixels};
use conray_core::LANES;
use fearless_simd::{Simd, f32x16, prelude::*};

/// Sixteen places that ask.
#[derive(Clone, Copy)]
pub(super) struct Centres<S: Simd> {
    pub(super) position: [f32x16<S>; 3],
    pub(super) normal: [f32x16<S>; 3],
    by_distance: f32x16<S>,
    by_plane: f32x16<S>,
    by_cosine: f32x16<S>,
}

/// How like a place is.
pub(super) struct Likeness<S: Simd> {
    /// From 1, alike, to 0.
    pub(super) near: f32x16<S>,
    /// What planes and normals add to the exponent, an eighth of it: from 0, alike, to 1 and more.
    pub(super) bent: f32x16<S>,
}

impl<S: Simd> Centres<S> {
    /// Pixels `at` and on, for cells of `1 << size` pixels.
    #[inline(always)]
    pub(super) fn load(
        simd: S,
        pixels: &Pixels,
        constants: &HybridConstants,
        at: usize,
        size: usize,
    ) -> Self {
        let [px, py, pz, nx, ny, nz] = &pixels.place;
        // exp(-e) is taken as (1 - e/8)^8: close, cheap, and closed from e = 8 on. An eighth stands at every factor.
        let splat = |x: f32| f32x16::splat(simd, x);
        let sharpness = f32x16::from_slice(simd, &pixels.sharpness[at..at + LANES]);
        let cells = splat((1 << size) as f32) / sharpness.max(splat(f32::MIN_POSITIVE));
        let reach = cells * splat(constants.cells);
        let by_plane = sharpness * splat(1.0 / ((1 << size) as f32 * constants.plane));
        Self {
            position: [
                f32x16::from_slice(simd, &px[at..at + LANES]),
                f32x16::from_slice(simd, &py[at..at + LANES]),
                f32x16::from_slice(simd, &pz[at..at + LANES]),
            ],
            normal: [
                f32x16::from_slice(simd, &nx[at..at + LANES]),
                f32x16::from_slice(simd, &ny[at..at + LANES]),
                f32x16::from_slice(simd, &nz[at..at + LANES]),
            ],
            by_distance: splat(0.125) / (splat(constants.distance * constants.distance) + reach * reach),
            by_plane: by_plane * by_plane * splat(0.125),
            by_cosine: splat(0.125 / constants.cosine),
        }
    }

    /// Likeness of a place with that normal, `to` away.
    #[inline(always)]
    pub(super) fn likeness(&self, simd: S, to: [f32x16<S>; 3], normal: [f32x16<S>; 3]) -> Likeness<S> {
        let ([x, y, z], [a, b, c], [nx, ny, nz]) = (to, normal, self.normal);
        let plane = (x * nx + y * ny + z * nz).abs().max((x * a + y * b + z * c).abs());
        let cosine = a * nx + b * ny + c * nz;
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let bent = self.by_plane * plane * plane + self.by_cosine * (one - cosine).max(zero);
        let near = (one - bent - self.by_distance * (x * x + y * y + z * z)).max(zero);
        let near = near * near;
        let near = near * near;
        Likeness { near: near * near, bent }
    }
}
