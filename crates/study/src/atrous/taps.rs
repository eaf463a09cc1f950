//! The inner loop of the filter: the 25 taps of a row of pixels.
//!
//! Tap by tap over a tile of pixels, so that the compiler turns neighbours into lanes; each pixel's sums are taken in
//! the order of its taps, whatever the number of lanes or threads.

use super::{AtrousSettings, Guides, Noisy};
use std::ops::Range;

/// The B3-spline on five taps.
const SPLINE: [f32; 5] = [1.0 / 16.0, 1.0 / 4.0, 3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];

/// Pixels of a row that are worked on at once: what they touch stays in the first cache.
const TILE: usize = 128;

/// One level of the filter.
pub(super) struct Taps<'a> {
    pub(super) guides: &'a Guides,
    pub(super) from: &'a Noisy,
    /// Factor of the squared difference of values, for each pixel as the centre.
    pub(super) stop: &'a [f32],
    pub(super) settings: &'a AtrousSettings,
    /// Pixels between taps.
    pub(super) step: usize,
}

/// Sums over the taps of each pixel of a tile.
struct Sums {
    weight: [f32; TILE],
    /// Weighted differences from the centre's value: what is constant stays so to the bit.
    difference: [f32; TILE],
    variance: [f32; TILE],
}

impl Taps<'_> {
    /// Filters one row.
    pub(super) fn row(&self, y: usize, value: &mut [f32], variance: &mut [f32]) {
        let (width, row) = (self.guides.width, y * self.guides.width);
        for start in (0..width).step_by(TILE) {
            let tile = start..(start + TILE).min(width);
            let mut sums = Sums { weight: [0.0; TILE], difference: [0.0; TILE], variance: [0.0; TILE] };
            if self.guides.covered[row + tile.start..row + tile.end].iter().any(|&c| c > 0.0) {
                self.gather(y, tile.clone(), &mut sums);
            }
            for (i, x) in tile.enumerate() {
                let weight = sums.weight[i];
                // The centre is among its taps, so that only the background has no weight.
                if self.guides.covered[row + x] > 0.0 {
                    value[x] = self.from.value[row + x] + sums.difference[i] / weight;
                    variance[x] = sums.variance[i] / (weight * weight);
                } else {
                    value[x] = self.from.value[row + x];
                    variance[x] = self.from.variance[row + x];
                }
            }
        }
    }

    /// Sums over the taps that lie in the image.
    fn gather(&self, y: usize, tile: Range<usize>, sums: &mut Sums) {
        let (width, height) = (self.guides.width, self.from.value.len() / self.guides.width);
        for (j, vertical) in (0..).zip(SPLINE) {
            let Some(v) = (y + j * self.step).checked_sub(2 * self.step).filter(|&v| v < height) else {
                continue;
            };
            for (i, horizontal) in (0..).zip(SPLINE) {
                // Centres whose tap u = x + (i - 2) step is within the row.
                let (ahead, behind) = (i * self.step, 2 * self.step);
                let first = tile.start.max(behind.saturating_sub(ahead));
                let last = tile.end.min((width + behind).saturating_sub(ahead));
                if first < last {
                    let centres = y * width + first..y * width + last;
                    let tap = v * width + first + ahead - behind;
                    let at = first - tile.start;
                    self.tap(centres, tap, horizontal * vertical, at, sums);
                }
            }
        }
    }

    /// Adds one tap to each of a run of centres.
    #[inline]
    fn tap(&self, centres: Range<usize>, tap: usize, spline: f32, at: usize, sums: &mut Sums) {
        // An infinite scale makes its factor 0: off. The eighth belongs to the exponential.
        let scale = |sigma: f32| 0.125 / (sigma * sigma);
        let by_normal = 0.125 / (1.0 - self.settings.normal_deg.to_radians().cos()).max(f32::MIN_POSITIVE);
        let by_normal = if self.settings.normal_deg.is_finite() { by_normal } else { 0.0 };
        let by_plane = scale(self.settings.plane_footprints);
        let by_distance = scale(self.settings.distance);
        let by_value = if self.settings.deviations.is_finite() { 0.125 } else { 0.0 };

        let n = centres.len();
        let taps = tap..tap + n;
        let [px, py, pz, nx, ny, nz] = self.guides.channels.each_ref().map(|c| &c[centres.clone()]);
        let [qx, qy, qz, mx, my, mz] = self.guides.channels.each_ref().map(|c| &c[taps.clone()]);
        let footprint = &self.guides.inverse_footprint2[centres.clone()];
        let covered = &self.guides.covered[taps.clone()];
        let (value, stop) = (&self.from.value[centres.clone()], &self.stop[centres]);
        let (other, variance) = (&self.from.value[taps.clone()], &self.from.variance[taps]);
        let weights = &mut sums.weight[at..at + n];
        let differences = &mut sums.difference[at..at + n];
        let variances = &mut sums.variance[at..at + n];
        for i in 0..n {
            let (dx, dy, dz) = (qx[i] - px[i], qy[i] - py[i], qz[i] - pz[i]);
            let plane = nx[i] * dx + ny[i] * dy + nz[i] * dz;
            let cosine = nx[i] * mx[i] + ny[i] * my[i] + nz[i] * mz[i];
            let difference = other[i] - value[i];
            let exponent = by_normal * (1.0 - cosine)
                + by_plane * footprint[i] * plane * plane
                + by_distance * (dx * dx + dy * dy + dz * dz)
                + by_value * stop[i] * difference * difference;
            // (1 - e/8)^8; rounding of unit normals may leave the exponent a hair below 0.
            let near = (1.0 - exponent).clamp(0.0, 1.0);
            let near2 = near * near;
            let near4 = near2 * near2;
            let weight = spline * covered[i] * near4 * near4;
            weights[i] += weight;
            differences[i] += weight * difference;
            variances[i] += weight * weight * variance[i];
        }
    }
}
