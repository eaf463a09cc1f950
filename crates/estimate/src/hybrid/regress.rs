//! What the neighbours of each pixel say of it: a local linear fit to the cells about it, its own rays left out.
//!
//! The 5 x 5 cells about a pixel are weighed by their worth and by how like they are; visibility is fitted as a linear
//! function on the tangent plane and read off at the pixel. A ridge keeps the slope finite where the cells do not tell it.
//! (Local linear fits for noisy pixels: Moon, Carr, Yoon, "Adaptive Rendering Based on Weighted Local Regression", 2014.)
//!
//! Cells of the finest size that says enough make the first guess, those of the next size the second. More sizes to choose
//! from gain nothing: the choice itself is noisy.

use super::{
    cells::{CHANNELS, Channels, Pyramid},
    columns::{Columns, in_parts},
    likeness::Centres,
    pixels::Pixels,
    tallies::Rays,
    weigh::SIZES,
    window::{Grid, Window},
};
use conray_bvh::Level;
use conray_core::LANES;
use fearless_simd::{Select, Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;

/// Cells on either side of a pixel's own.
const REACH: usize = 2;
const ROWS: usize = 2 * REACH + 1;
/// Least weight, in units of rays, from which something can be said.
const LEAST_WEIGHT: f32 = 0.05;
/// Formal variance, in that of a unit, of a guess that says nothing: cells far off to one side.
const NOTHING: f32 = 1e4;
/// One of so many pixels is too few to look at another size for.
const FEW: usize = 200;
/// Slope of visibility that is expected, per unit of length.
const SLOPE: f32 = 2.0;
/// Squared difference of visibility that is expected where planes and normals alone make likeness fall to 1/e, over 8.
const BEND: f32 = 0.01;

/// What cells of one size say of all pixels, and what the pixels' own rays say of that.
#[derive(Clone, Debug, Default)]
pub(super) struct Guess {
    pub(super) value: Vec<f32>,
    /// Formal variance, in units of the variance of one bundle; infinite where nothing like was found.
    pub(super) formal: Vec<f32>,
    /// Squared difference to what the pixel's own rays found, less their variance; 0 where there are none, or no guess.
    pub(super) off: Vec<f32>,
    /// The formal variance where that is told, else 0.
    pub(super) over: Vec<f32>,
}

/// Guesses from one size after the other, the finest first, where a pixel can use them (see [`Rays::enough`]).
#[derive(Clone, Debug, Default)]
pub(super) struct Guesses {
    all: Vec<Guess>,
    /// The size from which each pixel knows enough.
    enough: Vec<u8>,
    sizes: usize,
}

impl Guesses {
    /// Those of each size, as far as they are needed.
    pub(super) fn of_sizes(&self) -> &[Guess] {
        &self.all[..self.sizes]
    }

    /// Looks at what is known.
    pub(super) fn make(
        &mut self,
        level: Level,
        pixels: &Pixels,
        columns: &Columns,
        pyramid: &Pyramid,
        rays: &Rays,
    ) {
        let enough = rays.enough();
        self.enough.clear();
        self.enough.resize(pixels.len(), u8::MAX);
        self.sizes = 0;
        let mut lacking = pixels.place_of.len();
        for size in 0..SIZES {
            if size > 1 && lacking * FEW < pixels.place_of.len() {
                break;
            }
            if self.all.len() == size {
                self.all.push(Guess::default());
            }
            let layer = Layer::new(pixels, columns, pyramid, enough, size, false);
            lacking = self.all[size].make(level, &layer, &mut self.enough);
            self.sizes = size + 1;
        }
        // Where no size says enough, whatever says anything counts.
        for (size, guess) in self.all[..self.sizes - 1].iter_mut().enumerate() {
            guess.make(level, &Layer::new(pixels, columns, pyramid, enough, size, true), &mut self.enough);
        }
    }
}

/// One size of cells, and what is known of the pixels.
struct Layer<'a> {
    pixels: &'a Pixels,
    columns: &'a Columns,
    /// Cells have `1 << size` pixels a side.
    size: usize,
    grid: Grid,
    channels: Channels<'a>,
    widest: &'a [f32],
    fit: Fit,
    /// Formal variance from which cells say enough.
    enough: f32,
    /// A second look at pixels of which no size said enough.
    again: bool,
}

impl<'a> Layer<'a> {
    fn new(
        pixels: &'a Pixels,
        columns: &'a Columns,
        pyramid: &'a Pyramid,
        enough: f32,
        size: usize,
        again: bool,
    ) -> Self {
        let (grid, channels) = pyramid.grid(pixels, columns, size);
        let fit = Fit { ridge: columns.unit / (SLOPE * SLOPE), bend: BEND / columns.unit };
        Self { pixels, columns, size, grid, channels, widest: &pyramid.widest, fit, enough, again }
    }

    /// True for a pixel that these cells are asked about.
    fn is_wanted(&self, at: usize, enough: u8) -> bool {
        let lacks = if self.again { enough == u8::MAX } else { usize::from(enough) + 1 >= self.size };
        lacks && self.pixels.is_covered(at)
    }
}

impl Guess {
    /// Looks at cells of one size; tells how many pixels want the next.
    fn make(&mut self, level: Level, layer: &Layer<'_>, enough: &mut [u8]) -> usize {
        let (pixels, size) = (layer.pixels, layer.size);
        let mut out = [&mut self.value, &mut self.formal, &mut self.off, &mut self.over];
        out.iter_mut().for_each(|out| out.resize(pixels.len(), 0.0));
        let rows = (pixels.stride << size).max(1);
        let window = || Window::new(pixels.stride, size, REACH, CHANNELS);
        let parts = in_parts(&mut out, rows).into_par_iter().zip(enough.par_chunks_mut(rows));
        let lacking = parts.enumerate().map_init(window, |window, (row, (mut out, enough))| {
            let (mut loaded, mut lacking) = (false, 0);
            for x in (0..enough.len()).step_by(LANES) {
                let (at, lanes) = (row * rows + x, x..x + LANES);
                let mut told = layer.again;
                if lanes.clone().any(|i| layer.is_wanted(row * rows + i, enough[i])) {
                    if !loaded {
                        window.load(&layer.grid, &layer.channels, row, size);
                        loaded = true;
                    }
                    told |= dispatch!(level, simd => sixteen(simd, layer, window, at, x, &mut out));
                }
                if !told {
                    out[1][lanes.clone()].fill(f32::INFINITY);
                    out[2][lanes.clone()].fill(0.0);
                    out[3][lanes.clone()].fill(0.0);
                }
                for i in lanes.filter(|i| pixels.is_covered(row * rows + i)) {
                    if enough[i] == u8::MAX && out[1][i] <= layer.enough {
                        enough[i] = size as u8;
                    }
                    lacking += usize::from(usize::from(enough[i]) >= size);
                }
            }
            lacking
        });
        lacking.sum()
    }
}

/// What the fit expects.
struct Fit {
    /// Variance of a bundle over that of the slope.
    ridge: f32,
    /// Squared difference of what is bent away, over the variance of a bundle.
    bend: f32,
}

/// Sums of a weighted fit.
struct Sums<S: Simd> {
    weight: f32x16<S>,
    u: f32x16<S>,
    v: f32x16<S>,
    uu: f32x16<S>,
    uv: f32x16<S>,
    vv: f32x16<S>,
    y: f32x16<S>,
    uy: f32x16<S>,
    vy: f32x16<S>,
}

/// Sixteen pixels, `at` and on, places `x` and on of the parts; false where the cells cannot say enough.
#[inline(always)]
fn sixteen<S: Simd>(
    simd: S,
    layer: &Layer<'_>,
    window: &Window,
    at: usize,
    x: usize,
    out: &mut [&mut [f32]],
) -> bool {
    let (size, column_of_image) = (layer.size, at % layer.pixels.stride);
    if !layer.again && !can_say_enough(simd, layer, window, column_of_image) {
        return false;
    }
    let centres = Centres::load(simd, layer.pixels, at, size);
    let [[ux, uy, uz], [vx, vy, vz]] = tangents(simd, centres.normal);
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let bend = f32x16::splat(simd, layer.fit.bend);
    let mut sums =
        Sums { weight: zero, u: zero, v: zero, uu: zero, uv: zero, vv: zero, y: zero, uy: zero, vy: zero };
    for row in 0..ROWS {
        for column in 0..ROWS {
            let to = [column, row];
            let mut worth = f32x16::from_slice(simd, window.sixteen(0, to, column_of_image, size));
            let mut y = f32x16::from_slice(simd, window.sixteen(1, to, column_of_image, size));
            let mut dx =
                f32x16::from_slice(simd, window.sixteen(2, to, column_of_image, size)) - centres.position[0];
            let mut dy =
                f32x16::from_slice(simd, window.sixteen(3, to, column_of_image, size)) - centres.position[1];
            let mut dz =
                f32x16::from_slice(simd, window.sixteen(4, to, column_of_image, size)) - centres.position[2];
            let normal = [
                f32x16::from_slice(simd, window.sixteen(5, to, column_of_image, size)),
                f32x16::from_slice(simd, window.sixteen(6, to, column_of_image, size)),
                f32x16::from_slice(simd, window.sixteen(7, to, column_of_image, size)),
            ];
            if row == REACH && column == REACH {
                // The pixel's own part leaves its cell; what is left stands further off, on the other side.
                let part = f32x16::from_slice(simd, &layer.widest[at..at + LANES])
                    .simd_ge(f32x16::splat(simd, size as f32));
                let own = f32x16::from_slice(simd, &layer.columns.worth[at..at + LANES]);
                let own = part.select(own, zero);
                let left = worth - own;
                let some = left.simd_gt(f32x16::splat(simd, 0.5));
                let share = some.select(own / left, zero);
                y += (y - f32x16::from_slice(simd, &layer.columns.mean[at..at + LANES])) * share;
                dx += dx * share;
                dy += dy * share;
                dz += dz * share;
                worth = some.select(left, zero);
            }
            let likeness = centres.likeness(simd, [dx, dy, dz], normal);
            let weight = worth * likeness.near / (one + worth * likeness.bent * bend);
            let u = dx * ux + dy * uy + dz * uz;
            let v = dx * vx + dy * vy + dz * vz;
            let (wu, wv) = (weight * u, weight * v);
            sums.weight += weight;
            sums.u += wu;
            sums.v += wv;
            sums.uu += wu * u;
            sums.uv += wu * v;
            sums.vv += wv * v;
            sums.y += weight * y;
            sums.uy += wu * y;
            sums.vy += wv * y;
        }
    }
    let (fitted, formal) = solve(simd, &sums, layer.fit.ridge);
    let column = |column: &[f32]| f32x16::from_slice(simd, &column[at..at + LANES]);
    let told =
        column(&layer.columns.sampled) * formal.simd_lt(f32x16::splat(simd, f32::MAX)).select(one, zero);
    let told = told.simd_gt(zero);
    let off = column(&layer.columns.mean) - fitted;
    let off = off * off - column(&layer.columns.variance);
    let found = [fitted, formal, told.select(off, zero), told.select(formal, zero)];
    for (out, found) in out.iter_mut().zip(found) {
        found.store_slice(&mut out[x..x + LANES]);
    }
    true
}

/// Even if all neighbours were alike in all: could their rays be enough?
#[inline(always)]
fn can_say_enough<S: Simd>(simd: S, layer: &Layer<'_>, window: &Window, x: usize) -> bool {
    let size = layer.size;
    let mut worth = f32x16::splat(simd, 0.0);
    for row in 0..ROWS {
        for column in 0..ROWS {
            worth += f32x16::from_slice(simd, window.sixteen(0, [column, row], x, size));
        }
    }
    size + 1 == SIZES || worth.simd_ge(f32x16::splat(simd, 1.0 / layer.enough)).any_true()
}

/// The fit at the centre and its formal variance.
#[inline(always)]
fn solve<S: Simd>(simd: S, sums: &Sums<S>, ridge: f32) -> (f32x16<S>, f32x16<S>) {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let told = sums.weight.simd_ge(f32x16::splat(simd, LEAST_WEIGHT));
    let scale = one / told.select(sums.weight, one);
    let (u, v, y) = (sums.u * scale, sums.v * scale, sums.y * scale);
    let ridge = f32x16::splat(simd, ridge) * scale;
    let uu = sums.uu * scale - u * u + ridge;
    let uv = sums.uv * scale - u * v;
    let vv = sums.vv * scale - v * v + ridge;
    let (uy, vy) = (sums.uy * scale - u * y, sums.vy * scale - v * y);
    let inverse = one / (uu * vv - uv * uv).max(f32x16::splat(simd, f32::MIN_POSITIVE));
    let (slope_u, slope_v) = ((uy * vv - vy * uv) * inverse, (vy * uu - uy * uv) * inverse);
    let fitted = y - slope_u * u - slope_v * v;
    let beyond = (u * u * vv - f32x16::splat(simd, 2.0) * u * v * uv + v * v * uu) * inverse;
    let formal = (one + beyond.max(zero)) * scale;
    let told = told & formal.simd_lt(f32x16::splat(simd, NOTHING));
    let formal = told.select(formal, f32x16::splat(simd, f32::INFINITY));
    (fitted, formal)
}

/// Two tangents of each normal, as [`conray_core::Frame::from_normal`] takes them.
#[inline(always)]
fn tangents<S: Simd>(simd: S, [x, y, z]: [f32x16<S>; 3]) -> [[f32x16<S>; 3]; 2] {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let sign = z.simd_ge(zero).select(one, zero - one);
    let a = (zero - one) / (sign + z);
    let b = x * y * a;
    [[one + sign * x * x * a, sign * b, zero - sign * x], [b, sign + y * y * a, zero - y]]
}
