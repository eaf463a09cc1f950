//! Tallies of neighbours put together: pixels, then cells of 2 x 2, 4 x 4 and so on.
//!
//! A cell stands for one surface: of what lies in it, only what is like its best-known part is merged. It stands at the mean
//! place of its parts, weighted as their values are, so that values that change linearly stay so.

use super::pixels::Pixels;
use conray_core::Vec3;
use rayon::prelude::*;
use std::borrow::Cow;

/// Bundles, value, position (three), normal (three); bundles are 0 where there is nothing.
pub(super) const CHANNELS: usize = 8;

/// Normals of one surface have at least this cosine between them.
const LIKE_COSINE: f32 = 0.95;
/// Points of one surface lie within this share of a cell's size of each other's planes.
const LIKE_PLANE: f32 = 0.5;

/// Cells of one size.
#[derive(Clone, Debug)]
pub(super) struct Cells<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Places in a row.
    pub(super) stride: usize,
    pub(super) channels: [Cow<'a, [f32]>; CHANNELS],
}

/// Cells of each size from pixels on, and which pixels are part of theirs.
pub(super) struct Pyramid<'a> {
    pub(super) cells: Vec<Cells<'a>>,
    /// For each size, the bundles of each pixel that were merged into its cell.
    pub(super) own: Vec<Cow<'a, [f32]>>,
}

/// A cell's channels, and which of the four below are part of it.
type Merged = ([f32; CHANNELS], [bool; 4]);

impl<'a> Pyramid<'a> {
    /// `bundles` and `mean` are those of each pixel.
    pub(super) fn new(pixels: &'a Pixels, bundles: &'a [f32], mean: &'a [f32], sizes: usize) -> Self {
        let [px, py, pz, nx, ny, nz] = &pixels.place;
        let channels = [bundles, mean, px, py, pz, nx, ny, nz].map(Cow::Borrowed);
        let first = Cells { width: pixels.width, height: pixels.height, stride: pixels.stride, channels };
        let mut out = Self { own: vec![Cow::Borrowed(bundles)], cells: vec![first] };
        for size in 1..sizes {
            out.add(pixels, size);
        }
        out
    }

    fn add(&mut self, pixels: &Pixels, size: usize) {
        let below = &self.cells[size - 1];
        let (width, height) = (below.width.div_ceil(2), below.height.div_ceil(2));
        let merged: Vec<Merged> = (0..width * height)
            .into_par_iter()
            .with_min_len(256)
            .map(|cell| below.merge(pixels, size, cell % width, cell / width))
            .collect();
        let channel = |k: usize| merged.iter().map(|(cell, _)| cell[k]).collect::<Vec<f32>>();
        let channels: Vec<_> = (0..CHANNELS).into_par_iter().map(|k| Cow::Owned(channel(k))).collect();
        let channels = channels.try_into().expect("as many as asked for");
        let mut own = vec![0.0; pixels.len()];
        own.par_chunks_mut(pixels.stride)
            .zip(self.own[size - 1].par_chunks(pixels.stride))
            .enumerate()
            .for_each(|(y, (own, before))| {
                for x in 0..pixels.width {
                    let (cx, cy) = (x >> (size - 1), y >> (size - 1));
                    let (_, parts) = &merged[(cy / 2) * width + cx / 2];
                    own[x] = if parts[2 * (cy % 2) + cx % 2] { before[x] } else { 0.0 };
                }
            });
        self.own.push(Cow::Owned(own));
        self.cells.push(Cells { width, height, stride: width, channels });
    }
}

impl Cells<'_> {
    fn vector(&self, first: usize, at: usize) -> Vec3 {
        Vec3::new(self.channels[first][at], self.channels[first + 1][at], self.channels[first + 2][at])
    }

    /// The cell of twice the size, `1 << size` pixels, at that place.
    fn merge(&self, pixels: &Pixels, size: usize, x: usize, y: usize) -> Merged {
        let mut parts = [None; 4];
        let mut best = None;
        for (k, part) in parts.iter_mut().enumerate() {
            let (cx, cy) = (2 * x + k % 2, 2 * y + k / 2);
            let at = cy * self.stride + cx;
            if cx < self.width && cy < self.height && self.channels[0][at] > 0.0 {
                *part = Some(at);
                if best.is_none_or(|best| self.channels[0][at] > self.channels[0][best]) {
                    best = *part;
                }
            }
        }
        let (mut cell, mut flags) = ([0.0; CHANNELS], [false; 4]);
        let Some(best) = best else { return (cell, flags) };
        let (position, normal) = (self.vector(2, best), self.vector(5, best));
        let reach = LIKE_PLANE * (1 << size) as f32 * pixels.footprint((x << size, y << size), 1 << size);
        for (k, at) in parts.into_iter().enumerate() {
            let Some(at) = at else { continue };
            let (to, other) = (self.vector(2, at) - position, self.vector(5, at));
            let off = to.dot(normal).abs().max(to.dot(other).abs());
            if at == best || (normal.dot(other) >= LIKE_COSINE && off <= reach) {
                let bundles = self.channels[0][at];
                cell[0] += bundles;
                for (sum, channel) in cell.iter_mut().zip(&self.channels).skip(1) {
                    *sum += bundles * channel[at];
                }
                flags[k] = true;
            }
        }
        let bundles = cell[0];
        for value in &mut cell[1..] {
            *value /= bundles;
        }
        let length = Vec3::new(cell[5], cell[6], cell[7]).length().max(f32::MIN_POSITIVE);
        for value in &mut cell[5..] {
            *value /= length;
        }
        (cell, flags)
    }
}
