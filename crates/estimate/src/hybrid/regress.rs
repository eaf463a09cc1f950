//! What the neighbours of each pixel say of it: a local linear fit to the cells about it, its own rays left out.
//!
//! The 5 x 5 cells about a pixel are weighed by their worth and by how like they are; visibility is fitted as a linear
//! function on the tangent plane and read off at the pixel. A ridge keeps the slope finite where the cells do not tell it.
//! (Local linear fits for noisy pixels: Moon, Carr, Yoon, "Adaptive Rendering Based on Weighted Local Regression", 2014.)

use super::{HybridConstants, guesses::Layer, likeness::Centres, weigh::SIZES, window::Window};
use conray_core::LANES;
use fearless_simd::{Select, Simd, f32x16, prelude::*};

/// Cells on either side of a pixel's own.
pub(super) const REACH: usize = 2;
const ROWS: usize = 2 * REACH + 1;
/// Least weight, in units of rays, from which something can be said.
const LEAST_WEIGHT: f32 = 0.05;
/// Formal variance, in that of a unit, of a guess that says nothing: cells far off to one side.
const NOTHING: f32 = 1e4;

/// What the fit expects.
pub(super) struct Fit {
    /// Variance of a unit over that of the slope.
    ridge: f32,
    /// Squared difference of what is bent away, over the variance of a unit.
    bend: f32,
}

impl Fit {
    /// Where the variance of a unit is that on average.
    pub(super) fn new(unit: f32, constants: &HybridConstants) -> Self {
        Self { ridge: unit / (constants.slope * constants.slope), bend: constants.bend / unit }
    }
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
pub(super) fn sixteen<S: Simd>(
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
    let centres = Centres::load(simd, layer.pixels, layer.constants, at, size);
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
    let told = column(&layer.columns.sampled).simd_gt(zero) & formal.simd_lt(f32x16::splat(simd, f32::MAX));
    let off = column(&layer.columns.mean) - fitted;
    let off = off * off - column(&layer.columns.variance);
    // A guess that says next to nothing tells little of others: it counts as one that just says enough.
    let heard = (f32x16::splat(simd, layer.enough) / formal).min(one);
    let found = [fitted, formal, told.select(off * heard, zero), told.select(formal * heard, zero)];
    for (out, found) in out.iter_mut().zip(found) {
        found.store_slice(&mut out[x..x + LANES]);
    }
    true
}

/// Even if all neighbours were alike in all: could their rays be enough? The widest cells are always asked.
#[inline(always)]
fn can_say_enough<S: Simd>(simd: S, layer: &Layer<'_>, window: &Window, x: usize) -> bool {
    let size = layer.size;
    if size + 1 == SIZES {
        return true;
    }
    let mut worth = f32x16::splat(simd, 0.0);
    for row in 0..ROWS {
        for column in 0..ROWS {
            worth += f32x16::from_slice(simd, window.sixteen(0, [column, row], x, size));
        }
    }
    worth.simd_ge(f32x16::splat(simd, 1.0 / layer.enough)).any_true()
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
