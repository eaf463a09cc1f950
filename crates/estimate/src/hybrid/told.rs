//! What rays tell of guesses: by pixels, and summed over the cells that they are part of.

use super::{
    cells::{Channels, Pyramid},
    columns::{Columns, in_parts},
    guesses::Guesses,
    pixels::Pixels,
    weigh::SIZES,
    window::{Grid, Window},
};
use rayon::prelude::*;

/// Channels of samples before those of guesses: how many; the variance of a unit; the variance of all of a sample's rays.
pub(super) const FIXED: usize = 3;

/// Samples of pixels or of cells, and where they stand: [`FIXED`] channels, two for each guess, place and normal.
pub(super) struct Told<'a> {
    pub(super) size: usize,
    grid: Grid,
    channels: Vec<&'a [f32]>,
    pub(super) guesses: usize,
}

impl<'a> Told<'a> {
    /// What pixels tell.
    pub(super) fn of_pixels(
        pixels: &'a Pixels,
        columns: &'a Columns,
        pyramid: &'a Pyramid,
        guesses: &'a Guesses,
    ) -> Self {
        let guesses = guesses.of_sizes();
        let mut channels: Vec<&[f32]> = vec![&columns.sampled, &columns.unit_variance, &columns.variance];
        channels.extend(guesses.iter().flat_map(|g| [&g.off[..], &g.over[..]]));
        Self::new(pyramid.grid(pixels, columns, 0), 0, channels, guesses.len())
    }

    /// What cells tell.
    pub(super) fn of_cells(
        sums: &'a Sums,
        pixels: &'a Pixels,
        columns: &'a Columns,
        pyramid: &'a Pyramid,
    ) -> Self {
        let channels = sums.channels.iter().map(|c| &c[..]).collect();
        Self::new(pyramid.grid(pixels, columns, sums.size), sums.size, channels, sums.guesses())
    }

    fn new(
        (grid, cells): (Grid, Channels<'a>),
        size: usize,
        mut channels: Vec<&'a [f32]>,
        guesses: usize,
    ) -> Self {
        channels.extend(&cells[2..]);
        Self { size, grid, channels, guesses }
    }

    /// For rows of these pixels.
    pub(super) fn window(&self, pixels: &Pixels) -> Window {
        Window::new(pixels.stride, self.size, 1, self.channels.len())
    }

    pub(super) fn load(&self, window: &mut Window, row: usize) {
        window.load(&self.grid, &self.channels, row >> self.size, self.size);
    }
}

/// Sums over the pixels that were merged into each cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    size: usize,
    channels: Vec<Vec<f32>>,
}

impl Sums {
    /// Becomes those of cells of `1 << size` pixels a side.
    pub(super) fn fill(
        &mut self,
        pixels: &Pixels,
        columns: &Columns,
        pyramid: &Pyramid,
        told: &Told<'_>,
        size: usize,
    ) {
        let (grid, _) = pyramid.grid(pixels, columns, size);
        let count = FIXED + 2 * told.guesses;
        self.size = size;
        self.channels.resize(count, Vec::new());
        self.channels.iter_mut().for_each(|channel| {
            // What lies beyond the cells of a row counts for nothing.
            channel.clear();
            channel.resize(grid.stride * grid.height, 0.0);
        });
        let rows = pixels.stride << size;
        let least = size as f32;
        let column = || vec![0.0f32; pixels.stride];
        in_parts(&mut self.channels, grid.stride).into_par_iter().enumerate().for_each_init(
            column,
            |column, (row, mut out)| {
                let of_row = row * rows..((row + 1) * rows).min(pixels.len());
                let widest = &pyramid.widest[of_row.clone()];
                for (out, told) in out.iter_mut().zip(&told.channels) {
                    column.fill(0.0);
                    let lines = told[of_row.clone()].chunks(pixels.stride).zip(widest.chunks(pixels.stride));
                    for (told, widest) in lines {
                        for ((sum, &told), &widest) in column.iter_mut().zip(told).zip(widest) {
                            *sum += if widest >= least { told } else { 0.0 };
                        }
                    }
                    for (out, part) in out.iter_mut().zip(column.chunks(1 << size)) {
                        *out = part.iter().sum();
                    }
                }
            },
        );
    }

    fn guesses(&self) -> usize {
        (self.channels.len() - FIXED) / 2
    }

    /// What all cells together tell.
    pub(super) fn everywhere(&self) -> Everywhere {
        let sum = |channel: &Vec<f32>| channel.iter().map(|&x| f64::from(x)).sum::<f64>();
        let sums: Vec<f64> = self.channels.par_iter().map(sum).collect();
        let ratio = |a: f64, b: f64, none: f32| if b > 0.0 { (a / b) as f32 } else { none };
        let mut factors = [1.0; SIZES];
        for (factor, pair) in factors.iter_mut().zip(sums[FIXED..].chunks(2)) {
            *factor = ratio(pair[0], pair[1], 1.0).max(0.0);
        }
        Everywhere { unit_variance: ratio(sums[1], sums[0], 0.0), factors }
    }
}

/// What holds on average.
#[derive(Clone, Copy, Debug)]
pub(super) struct Everywhere {
    pub(super) unit_variance: f32,
    pub(super) factors: [f32; SIZES],
}
