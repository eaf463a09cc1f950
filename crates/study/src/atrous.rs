//! An edge-avoiding a-trous wavelet filter over an image of visibilities.
//!
//! Dammertz, Sewtz, Hanika, Lensch, "Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering",
//! 2010: a 5 x 5 B3-spline whose taps move apart by a factor of two each level, each tap weighed by how like its guides
//! are. Values stop it at edges in units of their own standard deviation, and variances are filtered along, as in
//! Schied et al., "Spatiotemporal Variance-Guided Filtering", 2017.
//!
//! Unlike there, all stops add up in one exponent e, and exp(-e) is (1 - e/8)^8 where that is positive, else 0: close to
//! the exponential, cheap, and closed exactly at strong edges. The plane distance counts along the centre's normal in
//! units of its footprint.

mod taps;
#[cfg(test)]
mod tests;

use crate::Case;
use conray::SurfacePoint;
use rayon::prelude::*;
use taps::Taps;

/// Most levels: the last has its outermost taps 64 pixels from the centre.
pub(crate) const MAX_LEVELS: u32 = 6;

/// Variance added where values stop the filter: pixels that claim certainty must not divide by zero.
const LEAST_VARIANCE: f32 = 1e-8;

/// How the filter weighs its taps. Each is a scale at which the exponent is 1; infinite is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AtrousSettings {
    /// Levels; 0 leaves the image as it is.
    pub(crate) levels: u32,
    /// Angle between normals, in degrees.
    pub(crate) normal_deg: f32,
    /// Distance from the centre's plane, in its footprints.
    pub(crate) plane_footprints: f32,
    /// Distance from the centre, in world units.
    pub(crate) distance: f32,
    /// Difference of values, in standard deviations of the centre's value.
    pub(crate) deviations: f32,
}

/// What is known of each pixel without noise, packed for the filter.
pub(crate) struct Guides {
    width: usize,
    /// Coordinates of positions, then of shading normals; 0 in the background.
    channels: [Vec<f32>; 6],
    /// 1 over the squared footprint.
    inverse_footprint2: Vec<f32>,
    /// 1 where there is a surface, 0 in the background.
    covered: Vec<f32>,
}

/// An image of estimates, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Noisy {
    /// Visibility.
    pub(crate) value: Vec<f32>,
    /// Its variance.
    pub(crate) variance: Vec<f32>,
}

impl Guides {
    /// Packs the surface points of a case.
    pub(crate) fn new(case: &Case) -> Self {
        let of = |f: &dyn Fn(&SurfacePoint) -> f32| -> Vec<f32> {
            case.pixels(&case.points().iter().map(f).collect::<Vec<_>>(), 0.0)
        };
        let channel = |i: usize| of(&|p| if i < 3 { p.position[i] } else { p.shading_normal[i - 3] });
        Self {
            width: case.size().0 as usize,
            channels: std::array::from_fn(channel),
            inverse_footprint2: of(&|p| if p.footprint > 0.0 { p.footprint.powi(-2) } else { 0.0 }),
            covered: of(&|_| 1.0),
        }
    }

    /// Filters an image in place; `after_level` sees its values after each level, counted from 1.
    ///
    /// Runs on the threads of the pool that calls it. Background pixels keep their values and lend them to nobody.
    pub(crate) fn filter(
        &self,
        image: &mut Noisy,
        settings: &AtrousSettings,
        mut after_level: impl FnMut(u32, &[f32]),
    ) {
        let mut next = image.clone();
        let mut stop = vec![0.0; image.value.len()];
        for level in 0..settings.levels {
            self.value_stop(&image.variance, settings.deviations, &mut stop);
            let taps = Taps { guides: self, from: image, stop: &stop, settings, step: 1 << level };
            let rows = next.value.par_chunks_mut(self.width).zip(next.variance.par_chunks_mut(self.width));
            rows.enumerate().for_each(|(y, (value, variance))| taps.row(y, value, variance));
            std::mem::swap(image, &mut next);
            after_level(level + 1, &image.value);
        }
    }

    /// Factor of the squared difference of values: 1 over `deviations` squared times the variance about each pixel.
    ///
    /// The variance of one pixel is itself noisy and goes with its value; so it is smoothed over 3 x 3 pixels.
    fn value_stop(&self, variance: &[f32], deviations: f32, stop: &mut [f32]) {
        if deviations.is_infinite() {
            return;
        }
        let (width, height) = (self.width, variance.len() / self.width);
        stop.par_chunks_mut(width).enumerate().for_each(|(y, stop)| {
            for (x, stop) in stop.iter_mut().enumerate() {
                let (mut sum, mut weights) = (0.0, 0.0);
                for v in y.saturating_sub(1)..(y + 2).min(height) {
                    for u in x.saturating_sub(1)..(x + 2).min(width) {
                        let near = if u == x { 2.0 } else { 1.0 } * if v == y { 2.0 } else { 1.0 };
                        let weight = near * self.covered[v * width + u];
                        sum += weight * variance[v * width + u];
                        weights += weight;
                    }
                }
                // In the background nothing is weighed, and nothing asks.
                let smooth = sum / f32::max(weights, 1.0);
                *stop = 1.0 / (deviations * deviations * (smooth + LEAST_VARIANCE));
            }
        });
    }
}
