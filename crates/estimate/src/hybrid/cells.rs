//! Tallies of neighbours put together: pixels, then cells of 2 x 2, 4 x 4 and so on.
//!
//! A cell stands for one surface: of what lies in it, only what is like its best-known part is merged. It stands at the mean
//! place of its parts, weighted as their values are, so that values that change linearly stay so.

use super::{
    columns::{Columns, in_parts},
    pixels::Pixels,
    window::Grid,
};
use conray_core::{LANES, Vec3};
use rayon::prelude::*;

/// Worth, value, position (three), normal (three); worth is 0 where there is nothing.
pub(super) const CHANNELS: usize = 8;

/// Normals of one surface have at least this cosine between them.
const LIKE_COSINE: f32 = 0.95;
/// Points of one surface lie within this share of a cell's size of each other's planes.
const LIKE_PLANE: f32 = 0.5;

/// The channels of cells of one size, pixels among them.
pub(super) type Channels<'a> = [&'a [f32]; CHANNELS];

/// Cells of one size of two pixels a side or more.
#[derive(Clone, Debug, Default)]
struct Cells {
    width: usize,
    height: usize,
    /// Places in a row.
    stride: usize,
    channels: [Vec<f32>; CHANNELS],
}

/// Cells of each size, and which pixels are part of theirs.
#[derive(Clone, Debug, Default)]
pub(super) struct Pyramid {
    cells: Vec<Cells>,
    /// For each pixel the widest size of cells that it is part of: it is part of all narrower ones too.
    pub(super) widest: Vec<f32>,
}

/// A pixel that is part of every cell.
const EVERY: f32 = 255.0;

impl Pyramid {
    /// Merges what is known of each pixel into cells of sizes below `sizes`.
    pub(super) fn build(&mut self, pixels: &Pixels, columns: &Columns, sizes: usize) {
        self.widest.clear();
        self.widest.resize(pixels.len(), EVERY);
        self.cells.resize(sizes - 1, Cells::default());
        for size in 1..sizes {
            let mut cells = std::mem::take(&mut self.cells[size - 1]);
            let mut widest = std::mem::take(&mut self.widest);
            let (below, channels) = self.grid(pixels, columns, size - 1);
            cells.merge(pixels, size, &Below { grid: below, channels }, &mut widest);
            self.cells[size - 1] = cells;
            self.widest = widest;
        }
    }

    /// Cells of `1 << size` pixels a side: how they lie, and their channels.
    pub(super) fn grid<'a>(
        &'a self,
        pixels: &'a Pixels,
        columns: &'a Columns,
        size: usize,
    ) -> (Grid, Channels<'a>) {
        match size.checked_sub(1) {
            None => {
                let [px, py, pz, nx, ny, nz] = &pixels.place;
                let grid = Grid { width: pixels.width, height: pixels.height, stride: pixels.stride };
                (grid, [&columns.worth, &columns.mean, px, py, pz, nx, ny, nz])
            }
            Some(k) => {
                let Cells { width, height, stride, channels } = &self.cells[k];
                (
                    Grid { width: *width, height: *height, stride: *stride },
                    channels.each_ref().map(|c| &c[..]),
                )
            }
        }
    }
}

/// The cells that are merged.
struct Below<'a> {
    grid: Grid,
    channels: Channels<'a>,
}

impl Cells {
    /// Becomes the cells of `1 << size` pixels a side.
    fn merge(&mut self, pixels: &Pixels, size: usize, below: &Below<'_>, widest: &mut [f32]) {
        self.width = below.grid.width.div_ceil(2);
        self.height = below.grid.height.div_ceil(2);
        self.stride = self.width.next_multiple_of(LANES);
        let count = self.stride * self.height;
        self.channels.iter_mut().for_each(|channel| channel.resize(count, 0.0));
        let rows = in_parts(&mut self.channels, self.stride);
        let widest = widest.par_chunks_mut((pixels.stride << size).max(1));
        rows.into_par_iter().zip(widest).enumerate().with_min_len(4).for_each(|(y, (mut out, widest))| {
            for x in 0..self.width {
                let (cell, left_out) = below.merged(pixels, size, x, y);
                out.iter_mut().zip(cell).for_each(|(out, value)| out[x] = value);
                for part in (0..4).filter(|k| left_out[*k]) {
                    leave_out(widest, pixels, size, x, part);
                }
            }
        });
    }
}

/// Marks the pixels of a quarter of a cell as no part of it; `widest` has the rows of the cell.
fn leave_out(widest: &mut [f32], pixels: &Pixels, size: usize, x: usize, part: usize) {
    let side = 1 << (size - 1);
    let (left, top) = ((2 * x + part % 2) * side, part / 2 * side);
    for row in widest.chunks_mut(pixels.stride).skip(top).take(side) {
        for widest in &mut row[left..(left + side).min(pixels.width)] {
            *widest = widest.min((size - 1) as f32);
        }
    }
}

impl Below<'_> {
    fn vector(&self, first: usize, at: usize) -> Vec3 {
        Vec3::new(self.channels[first][at], self.channels[first + 1][at], self.channels[first + 2][at])
    }

    /// The channels of the cell of twice the size, `1 << size` pixels, at that place; and which of its four parts are on
    /// another surface.
    fn merged(&self, pixels: &Pixels, size: usize, x: usize, y: usize) -> ([f32; CHANNELS], [bool; 4]) {
        let mut parts = [None; 4];
        let mut best = None;
        for (k, part) in parts.iter_mut().enumerate() {
            let (cx, cy) = (2 * x + k % 2, 2 * y + k / 2);
            let at = cy * self.grid.stride + cx;
            if cx < self.grid.width && cy < self.grid.height && self.channels[0][at] > 0.0 {
                *part = Some(at);
                if best.is_none_or(|best| self.channels[0][at] > self.channels[0][best]) {
                    best = *part;
                }
            }
        }
        let (mut cell, mut left_out) = ([0.0; CHANNELS], [false; 4]);
        let Some(best) = best else { return (cell, left_out) };
        let (position, normal) = (self.vector(2, best), self.vector(5, best));
        let reach = LIKE_PLANE * (1 << size) as f32 * pixels.footprint((x << size, y << size), 1 << size);
        for (k, at) in parts.into_iter().enumerate() {
            let Some(at) = at else { continue };
            let (to, other) = (self.vector(2, at) - position, self.vector(5, at));
            let off = to.dot(normal).abs().max(to.dot(other).abs());
            if at == best || (normal.dot(other) >= LIKE_COSINE && off <= reach) {
                let worth = self.channels[0][at];
                cell[0] += worth;
                for (sum, channel) in cell.iter_mut().zip(&self.channels).skip(1) {
                    *sum += worth * channel[at];
                }
            } else {
                left_out[k] = true;
            }
        }
        let share = 1.0 / cell[0];
        for value in &mut cell[1..] {
            *value *= share;
        }
        let length = Vec3::new(cell[5], cell[6], cell[7]).length().max(f32::MIN_POSITIVE);
        for value in &mut cell[5..] {
            *value /= length;
        }
        (cell, left_out)
    }
}
