//! Who is guessed from cells of which size.
//!
//! Cells of the finest size that says enough make the first guess, those of the next size the second. More sizes to choose
//! from gain nothing: the choice itself is noisy.

use super::{
    HybridConstants,
    cells::{CHANNELS, Channels, Pyramid},
    columns::{Columns, in_parts},
    pixels::{NO_POINT, Pixels},
    regress::{Fit, REACH, sixteen},
    tallies::Rays,
    weigh::SIZES,
    window::{Grid, Window},
};
use conray_bvh::Level;
use conray_core::LANES;
use fearless_simd::dispatch;
use rayon::prelude::*;

/// One of so many pixels is too few to look at another size for.
const FEW: usize = 200;

/// What cells of one size say of all pixels, and what the pixels' own rays say of that.
#[derive(Clone, Debug, Default)]
pub(super) struct Guess {
    pub(super) value: Vec<f32>,
    /// Formal variance, in that of one unit of rays; infinite where nothing like was found.
    pub(super) formal: Vec<f32>,
    /// Squared difference to what the pixel's own rays found, less their variance; 0 where there are none, or no guess. Where the
    /// formal variance is more than enough, as much less as that is more.
    pub(super) off: Vec<f32>,
    /// The formal variance where that is told, at most what is enough; else 0.
    pub(super) over: Vec<f32>,
    /// For each sixteen pixels, whether these cells were asked.
    asked: Vec<bool>,
}

/// Guesses from one size after the other, the finest first, where a pixel can use them (see [`Rays::enough`]).
#[derive(Clone, Debug, Default)]
pub(super) struct Guesses {
    all: Vec<Guess>,
    /// How many sizes each pixel asks, the finest first: none where there is no point, [`ALL`] until one says enough.
    asks: Vec<u8>,
    sizes: usize,
}

/// More sizes than there are.
const ALL: u8 = SIZES as u8 + 1;

impl Guesses {
    /// Those of each size, as far as they are needed.
    pub(super) fn of_sizes(&self) -> &[Guess] {
        &self.all[..self.sizes]
    }

    /// Looks at what is known.
    pub(super) fn make(
        &mut self,
        level: Level,
        constants: &HybridConstants,
        pixels: &Pixels,
        columns: &Columns,
        pyramid: &Pyramid,
        rays: &Rays,
    ) {
        let enough = rays.enough();
        self.asks.clear();
        self.asks.extend(pixels.point.iter().map(|&point| if point == NO_POINT { 0 } else { ALL }));
        self.sizes = 0;
        let mut lacking = pixels.place_of.len();
        for size in 0..SIZES {
            if size > 1 && lacking * FEW < pixels.place_of.len() {
                break;
            }
            if self.all.len() == size {
                self.all.push(Guess::default());
            }
            let layer = Layer::new(constants, pixels, columns, pyramid, enough, size, false);
            lacking = self.all[size].make(level, &layer, &mut self.asks);
            self.sizes = size + 1;
        }
        // Where no size says enough, whatever says anything counts.
        for (size, guess) in self.all[..self.sizes - 1].iter_mut().enumerate() {
            let layer = Layer::new(constants, pixels, columns, pyramid, enough, size, true);
            guess.make(level, &layer, &mut self.asks);
        }
    }
}

/// One size of cells, and what is known of the pixels.
pub(super) struct Layer<'a> {
    pub(super) constants: &'a HybridConstants,
    pub(super) pixels: &'a Pixels,
    pub(super) columns: &'a Columns,
    /// Cells have `1 << size` pixels a side.
    pub(super) size: usize,
    grid: Grid,
    channels: Channels<'a>,
    pub(super) widest: &'a [f32],
    pub(super) fit: Fit,
    /// Formal variance from which cells say enough.
    pub(super) enough: f32,
    /// A second look at pixels of which no size said enough.
    pub(super) again: bool,
}

impl<'a> Layer<'a> {
    fn new(
        constants: &'a HybridConstants,
        pixels: &'a Pixels,
        columns: &'a Columns,
        pyramid: &'a Pyramid,
        enough: f32,
        size: usize,
        again: bool,
    ) -> Self {
        let (grid, channels) = pyramid.grid(pixels, columns, size);
        let fit = Fit::new(columns.unit, constants);
        Self { constants, pixels, columns, size, grid, channels, widest: &pyramid.widest, fit, enough, again }
    }

    /// The least number of sizes asked by a pixel that asks this one.
    fn least(&self) -> u8 {
        if self.again { ALL } else { self.size as u8 + 1 }
    }
}

impl Guess {
    /// Looks at cells of one size; tells how many pixels ask the next.
    fn make(&mut self, level: Level, layer: &Layer<'_>, asks: &mut [u8]) -> usize {
        let (pixels, size) = (layer.pixels, layer.size);
        let mut out = [&mut self.value, &mut self.formal, &mut self.off, &mut self.over];
        out.iter_mut().for_each(|out| out.resize(pixels.len(), 0.0));
        self.asked.resize(pixels.len() / LANES, false);
        if !layer.again {
            self.asked.fill(false);
        }
        let rows = (pixels.stride << size).max(LANES);
        let window = || Window::new(pixels.stride, size, REACH, CHANNELS);
        let parts = in_parts(&mut out, rows).into_par_iter().zip(asks.par_chunks_mut(rows));
        let parts = parts.zip(self.asked.par_chunks_mut(rows / LANES));
        let lacking = parts.enumerate().map_init(window, |window, (row, ((mut out, asks), asked))| {
            let (mut loaded, mut lacking) = (false, 0);
            for (k, (asks, asked)) in asks.chunks_exact_mut(LANES).zip(asked).enumerate() {
                let (at, lanes) = (row * rows + k * LANES, k * LANES..(k + 1) * LANES);
                let most = asks.iter().fold(0, |most, &asks| asks.max(most));
                if most >= layer.least() && !*asked {
                    if !loaded {
                        window.load(&layer.grid, &layer.channels, row, size);
                        loaded = true;
                    }
                    *asked = dispatch!(level, simd => sixteen(simd, layer, window, at, k * LANES, &mut out));
                }
                if !*asked {
                    out[1][lanes.clone()].fill(f32::INFINITY);
                    out[2][lanes.clone()].fill(0.0);
                    out[3][lanes].fill(0.0);
                } else if !layer.again {
                    for (asks, &formal) in asks.iter_mut().zip(&out[1][lanes]) {
                        let enough = *asks == ALL && formal <= layer.enough;
                        *asks = if enough { size as u8 + 2 } else { *asks };
                    }
                }
                lacking += asks.iter().map(|&asks| usize::from(asks > size as u8 + 1)).sum::<usize>();
            }
            lacking
        });
        lacking.sum()
    }
}
