//! What each pixel's rays found, component by component.

use super::{
    pixels::Pixels,
    tallies::{Rays, Tally, worth},
};
use rayon::prelude::*;

/// Columns of tallies, one value a pixel; all 0 where a pixel has no rays.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    /// Precision of the mean, in that of one unit.
    pub(super) worth: Vec<f32>,
    /// Mean visibility.
    pub(super) mean: Vec<f32>,
    /// Variance of that mean.
    pub(super) variance: Vec<f32>,
    /// Squared error of what its rays do not see.
    pub(super) unseen: Vec<f32>,
    /// Variance of one unit.
    pub(super) unit_variance: Vec<f32>,
    /// 1 where there are rays.
    pub(super) sampled: Vec<f32>,
    /// Mean squared error of one unit, with what it does not see.
    pub(super) unit: f32,
}

/// Pixels of a part: sums are taken part by part, so that they do not depend on threads.
pub(super) const PART: usize = 1 << 13;

impl Columns {
    /// Becomes those of these tallies.
    pub(super) fn fill(&mut self, pixels: &Pixels, tallies: &[Tally], rays: &Rays) {
        let mut columns = [
            &mut self.worth,
            &mut self.mean,
            &mut self.variance,
            &mut self.unit_variance,
            &mut self.sampled,
            &mut self.unseen,
        ];
        columns.iter_mut().for_each(|column| column.resize(pixels.len(), 0.0));
        let part = |(mut out, tallies): (Vec<&mut [f32]>, &[Tally])| {
            let (mut sum, mut count) = (0.0, 0u32);
            for (k, tally) in tallies.iter().enumerate() {
                let some = tally.units > 0;
                let unit_variance = rays.unit_variance(tally);
                out[0][k] = worth(tally.units as f32);
                out[1][k] = tally.mean();
                out[2][k] = if some { Rays::variance(unit_variance, tally.units) } else { 0.0 };
                out[3][k] = unit_variance;
                out[4][k] = f32::from(u8::from(some));
                out[5][k] = if some { Rays::unseen(tally.units) } else { 0.0 };
                sum += f64::from(unit_variance);
                count += u32::from(some);
            }
            (sum, count)
        };
        let parts: Vec<(f64, u32)> =
            in_parts(&mut columns, PART).into_par_iter().zip(tallies.par_chunks(PART)).map(part).collect();
        let (sum, count) = parts.into_iter().fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        self.unit = Rays::variance((sum / f64::from(count.max(1))) as f32, 1);
    }
}

/// Parts of so many places, each of all columns.
pub(super) fn in_parts<C: AsMut<Vec<f32>>>(columns: &mut [C], size: usize) -> Vec<Vec<&mut [f32]>> {
    let mut out: Vec<Vec<&mut [f32]>> = Vec::new();
    for column in columns {
        for (part, piece) in column.as_mut().chunks_mut(size.max(1)).enumerate() {
            if part == out.len() {
                out.push(Vec::new());
            }
            out[part].push(piece);
        }
    }
    out
}
