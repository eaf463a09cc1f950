//! What the neighbours of each pixel say of it: a local linear fit to the cells about it, its own rays left out.
//!
//! The 5 x 5 cells about a pixel are weighed by their bundles and by how like they are; visibility is fitted as a linear
//! function on the tangent plane and read off at the pixel. A ridge keeps the slope finite where the cells do not tell it.
//! (Local linear fits for noisy pixels: Moon, Carr, Yoon, "Adaptive Rendering Based on Weighted Local Regression", 2014.)
//!
//! Cells of the finest size that says enough make the first guess, those of the next size the second. More sizes to choose
//! from gain nothing: the choice itself is noisy.

use super::{
    cells::{CHANNELS, Cells, Pyramid},
    likeness::Centres,
    pixels::Pixels,
    window::{Grid, Window},
};
use conray_bvh::Level;
use conray_core::LANES;
use fearless_simd::{Select, Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;
use std::ops::Range;

/// Cells on either side of a pixel's own.
const REACH: usize = 2;
const ROWS: usize = 2 * REACH + 1;
/// Least weight, in bundles, from which something can be said.
const LEAST_WEIGHT: f32 = 0.05;
/// Formal variance, in that of a bundle, from which cells say enough.
const ENOUGH: f32 = 0.5;
/// One of so many pixels is too few to look at another size for.
const FEW: usize = 200;
/// Slope of visibility that is expected, per unit of length.
const SLOPE: f32 = 2.0;
/// Squared difference of visibility that is expected where planes and normals alone make likeness fall to 1/e, over 8.
const BEND: f32 = 0.01;

/// What cells of one size say of all pixels.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    pub(super) value: Vec<f32>,
    /// Formal variance, in units of the variance of one bundle; infinite where nothing like was found.
    pub(super) formal: Vec<f32>,
}

/// One size of cells, and which pixels are part of theirs.
struct Layer<'a> {
    cells: &'a Cells<'a>,
    /// Cells have `1 << size` pixels a side.
    size: usize,
    /// Bundles of each pixel that were merged into its cell.
    own: &'a [f32],
    /// What each pixel's own rays found.
    mean: &'a [f32],
}

/// Guesses from one size after the other, the finest first, where a pixel can use them ([`usable`]).
pub(super) fn guesses(
    level: Level,
    pixels: &Pixels,
    pyramid: &Pyramid<'_>,
    mean: &[f32],
    bundle: f32,
) -> Vec<Guess> {
    let mut found: Vec<Guess> = Vec::new();
    // The size from which each pixel knows enough.
    let mut enough = vec![u8::MAX; pixels.len()];
    for (size, (cells, own)) in pyramid.cells.iter().zip(&pyramid.own).enumerate() {
        let lacks = |&at: &usize| usize::from(enough[at]) + 1 >= size && pixels.is_covered(at);
        let lacking = (0..pixels.len()).into_par_iter().with_min_len(1 << 12).filter(lacks).count();
        if size > 1 && lacking * FEW < pixels.place_of.len() {
            break;
        }
        let layer = Layer { cells, size, own, mean };
        let guess = guess(level, pixels, &layer, bundle, &mut enough);
        found.push(guess);
    }
    found
}

/// The guesses of a pixel that count: of the finest size that says enough, else of the finest that says anything; and of the
/// next.
pub(super) fn usable(guesses: &[Guess], at: usize) -> Range<usize> {
    let first = guesses.iter().position(|g| g.formal[at] <= ENOUGH);
    let first = first.or_else(|| guesses.iter().position(|g| g.formal[at].is_finite())).unwrap_or(0);
    first..(first + 2).min(guesses.len())
}

/// `bundle` is the mean variance of a bundle.
fn guess(level: Level, pixels: &Pixels, layer: &Layer<'_>, bundle: f32, enough: &mut [u8]) -> Guess {
    let channels: Vec<&[f32]> = layer.cells.channels.iter().map(|c| &c[..]).collect();
    let (cells, size) = (layer.cells, layer.size);
    let grid = Grid { width: cells.width, height: cells.height, stride: cells.stride, channels: &channels };
    let fit = Fit { ridge: bundle / (SLOPE * SLOPE), bend: BEND / bundle };
    // Zeroed memory costs nothing until a thread writes to it.
    let mut out = Guess { value: vec![0.0; pixels.len()], formal: vec![0.0; pixels.len()] };
    let rows = pixels.stride << size;
    let window = || Window::new(pixels.stride, size, REACH, CHANNELS);
    let parts =
        out.value.par_chunks_mut(rows).zip(out.formal.par_chunks_mut(rows)).zip(enough.par_chunks_mut(rows));
    parts.enumerate().for_each_init(window, |window, (row, ((value, formal), enough))| {
        let mut loaded = false;
        for x in (0..value.len()).step_by(LANES) {
            let (at, lanes) = (row * rows + x, x..x + LANES);
            let lacks = |i: usize| usize::from(enough[i]) + 1 >= size && pixels.is_covered(row * rows + i);
            if !lanes.clone().any(lacks) {
                formal[lanes].fill(f32::INFINITY);
                continue;
            }
            if !loaded {
                window.load(&grid, row, size);
                loaded = true;
            }
            let out = [&mut value[x..], &mut formal[x..]];
            dispatch!(level, simd => sixteen(simd, pixels, window, layer, at, &fit, out));
            for i in lanes {
                if enough[i] == u8::MAX && formal[i] <= ENOUGH {
                    enough[i] = size as u8;
                }
            }
        }
    });
    out
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

#[inline(always)]
fn sixteen<S: Simd>(
    simd: S,
    pixels: &Pixels,
    window: &Window,
    layer: &Layer<'_>,
    at: usize,
    fit: &Fit,
    [value, formal]: [&mut [f32]; 2],
) {
    let size = layer.size;
    let centres = Centres::load(simd, pixels, at, size);
    let [[ux, uy, uz], [vx, vy, vz]] = tangents(simd, centres.normal);
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let bend = f32x16::splat(simd, fit.bend);
    let mut sums =
        Sums { weight: zero, u: zero, v: zero, uu: zero, uv: zero, vv: zero, y: zero, uy: zero, vy: zero };
    let x = at % pixels.stride;
    for row in 0..ROWS {
        for column in 0..ROWS {
            let to = [column, row];
            let mut bundles = f32x16::from_slice(simd, window.sixteen(0, to, x, size));
            let mut y = f32x16::from_slice(simd, window.sixteen(1, to, x, size));
            let mut dx = f32x16::from_slice(simd, window.sixteen(2, to, x, size)) - centres.position[0];
            let mut dy = f32x16::from_slice(simd, window.sixteen(3, to, x, size)) - centres.position[1];
            let mut dz = f32x16::from_slice(simd, window.sixteen(4, to, x, size)) - centres.position[2];
            let normal = [
                f32x16::from_slice(simd, window.sixteen(5, to, x, size)),
                f32x16::from_slice(simd, window.sixteen(6, to, x, size)),
                f32x16::from_slice(simd, window.sixteen(7, to, x, size)),
            ];
            if row == REACH && column == REACH {
                // The pixel's own part leaves its cell; what is left stands further off, on the other side.
                let own = f32x16::from_slice(simd, &layer.own[at..at + LANES]);
                let left = bundles - own;
                let some = left.simd_gt(f32x16::splat(simd, 0.5));
                let share = some.select(own / left, zero);
                y += (y - f32x16::from_slice(simd, &layer.mean[at..at + LANES])) * share;
                dx += dx * share;
                dy += dy * share;
                dz += dz * share;
                bundles = some.select(left, zero);
            }
            let likeness = centres.likeness(simd, [dx, dy, dz], normal);
            let weight = bundles * likeness.near / (one + bundles * likeness.bent * bend);
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
    let (fitted, spread) = solve(simd, &sums, fit.ridge);
    fitted.store_slice(&mut value[..LANES]);
    spread.store_slice(&mut formal[..LANES]);
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
    let fitted = (y - slope_u * u - slope_v * v).max(zero).min(one);
    let beyond = (u * u * vv - f32x16::splat(simd, 2.0) * u * v * uv + v * v * uu) * inverse;
    let formal = told.select((one + beyond.max(zero)) * scale, f32x16::splat(simd, f32::INFINITY));
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
