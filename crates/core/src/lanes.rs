//! Sixteen samples at once: the sequence of `sobol.rs` and the map of `warp.rs`, side by side.
//!
//! Points of the square are those of [`owen_sobol_2d`](crate::owen_sobol_2d) to the bit. Directions are those of
//! [`cosine_hemisphere`](crate::cosine_hemisphere) but for some roundings: sine and cosine are polynomials, and nothing is
//! fused, so that every level of SIMD gives the same bits. There are no closures, which would not be compiled for the level.

use crate::{
    Frame, hash_u32,
    sobol::{SCRAMBLE, SEED_X, SEED_Y},
};
use fearless_simd::{Level, Select, Simd, f32x16, prelude::*, u32x16};
use std::f32::consts::FRAC_PI_4;

/// How many samples.
pub const LANES: usize = 16;

/// Every level of SIMD that this processor has, the slowest first: what tests of kernels run through.
pub fn simd_levels() -> Vec<Level> {
    let mut levels = vec![Level::baseline()];
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_sse4_2().map(Level::Sse4_2));
        levels.extend(best.as_avx2().map(Level::Avx2));
        levels.extend(best.as_avx512().map(Level::Avx512));
    }
    levels.push(best);
    levels
}

/// Points `first` to `first + 15` of the sequence `seed`, x and y in [0, 1).
///
/// Reversing bits twice changes nothing, so of the six reversals of the scalar form three remain.
#[inline(always)]
pub fn owen_sobol_2d_lanes<S: Simd>(simd: S, first: u32, seed: u32) -> [f32x16<S>; 2] {
    let index: [u32; LANES] = std::array::from_fn(|lane| (first.wrapping_add(lane as u32)).reverse_bits());
    let shuffled = reversed(simd, scrambled(simd, u32x16::simd_from(simd, index), hash_u32(seed)));
    let x = scrambled(simd, shuffled, hash_u32(seed ^ SEED_X));
    let y = scrambled(simd, butterflies(simd, shuffled), hash_u32(seed ^ SEED_Y));
    [unit_floats(simd, reversed(simd, x)), unit_floats(simd, reversed(simd, y))]
}

/// Directions about +z for points of the unit square, their density the cosine over pi.
#[inline(always)]
pub fn cosine_hemisphere_lanes<S: Simd>(simd: S, square: [f32x16<S>; 2]) -> [f32x16<S>; 3] {
    cosine_cone_lanes(simd, square, 1.0)
}

/// Directions within a cone about +z, their density proportional to the cosine; `reach` is the sine of the half-angle, in (0, 1].
#[inline(always)]
pub fn cosine_cone_lanes<S: Simd>(simd: S, [x, y]: [f32x16<S>; 2], reach: f32) -> [f32x16<S>; 3] {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let (x, y) = (x + x - one, y + y - one);
    let steep = x.abs().simd_gt(y.abs());
    let (radius, other) = (steep.select(x, y), steep.select(y, x));
    let angle = other / radius * f32x16::splat(simd, FRAC_PI_4);
    // The middle of the square: zero over zero.
    let angle = radius.simd_eq(zero).select(zero, angle);
    let (sin, cos) = sin_cos_of_eighth(simd, angle);
    // A disc is the foot of the hemisphere (Malley's method), a smaller one that of the cone.
    let radius = radius * splat(simd, reach);
    let (x, y) = (radius * steep.select(cos, sin), radius * steep.select(sin, cos));
    let z = (one - x * x - y * y).max(zero).sqrt();
    [x, y, z]
}

impl Frame {
    /// [`Frame::to_world`] for sixteen directions.
    #[inline(always)]
    pub fn to_world_lanes<S: Simd>(&self, simd: S, [x, y, z]: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        let (a, b, c) = (self.x, self.y, self.z);
        [
            x * splat(simd, a.x) + y * splat(simd, b.x) + z * splat(simd, c.x),
            x * splat(simd, a.y) + y * splat(simd, b.y) + z * splat(simd, c.y),
            x * splat(simd, a.z) + y * splat(simd, b.z) + z * splat(simd, c.z),
        ]
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

#[inline(always)]
fn times<S: Simd>(simd: S, x: u32x16<S>, factor: u32) -> u32x16<S> {
    x * u32x16::splat(simd, factor)
}

#[inline(always)]
fn swapped<S: Simd>(simd: S, x: u32x16<S>, mask: u32, by: u32) -> u32x16<S> {
    let mask = u32x16::splat(simd, mask);
    ((x >> by) & mask) | ((x & mask) << by)
}

/// The nested scrambling of `sobol.rs` on reversed bits.
#[inline(always)]
fn scrambled<S: Simd>(simd: S, bits: u32x16<S>, seed: u32) -> u32x16<S> {
    let mut x = bits;
    x = x ^ times(simd, x, SCRAMBLE[0]);
    x += u32x16::splat(simd, seed);
    x = times(simd, x, (seed >> 16) | 1);
    x = x ^ times(simd, x, SCRAMBLE[1]);
    x ^ times(simd, x, SCRAMBLE[2])
}

/// Pascal's triangle modulo 2 times the index: see `sobol.rs`; without the reversal at its end.
#[inline(always)]
fn butterflies<S: Simd>(simd: S, mut x: u32x16<S>) -> u32x16<S> {
    x = x ^ ((x >> 1) & u32x16::splat(simd, 0x5555_5555));
    x = x ^ ((x >> 2) & u32x16::splat(simd, 0x3333_3333));
    x = x ^ ((x >> 4) & u32x16::splat(simd, 0x0f0f_0f0f));
    x = x ^ ((x >> 8) & u32x16::splat(simd, 0x00ff_00ff));
    x ^ ((x >> 16) & u32x16::splat(simd, 0x0000_ffff))
}

/// Each lane's bits in reverse.
#[inline(always)]
fn reversed<S: Simd>(simd: S, mut x: u32x16<S>) -> u32x16<S> {
    x = swapped(simd, x, 0x5555_5555, 1);
    x = swapped(simd, x, 0x3333_3333, 2);
    x = swapped(simd, x, 0x0f0f_0f0f, 4);
    x = swapped(simd, x, 0x00ff_00ff, 8);
    (x >> 16) | (x << 16)
}

/// The upper 24 bits as a float in [0, 1).
#[inline(always)]
fn unit_floats<S: Simd>(simd: S, bits: u32x16<S>) -> f32x16<S> {
    let float: f32x16<S> = (bits >> 8).to_float();
    float * f32x16::splat(simd, 1.0 / 16_777_216.0)
}

/// Sine and cosine of angles up to an eighth of a turn: Taylor's series, its rest below 3e-8.
#[inline(always)]
fn sin_cos_of_eighth<S: Simd>(simd: S, angle: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    let square = angle * angle;
    let sin = splat(simd, -1.0 / 5040.0) + square * splat(simd, 1.0 / 362_880.0);
    let sin = splat(simd, -1.0 / 6.0) + square * (splat(simd, 1.0 / 120.0) + square * sin);
    let cos = splat(simd, -1.0 / 720.0) + square * splat(simd, 1.0 / 40_320.0);
    let cos = splat(simd, -0.5) + square * (splat(simd, 1.0 / 24.0) + square * cos);
    (angle + angle * square * sin, splat(simd, 1.0) + square * cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Vec3, cosine_hemisphere, owen_sobol_2d};
    use fearless_simd::dispatch;

    type Sixteen = ([[f32; 16]; 2], [[f32; 16]; 3]);

    fn at(level: Level, first: u32, seed: u32, frame: &Frame) -> Sixteen {
        #[inline(always)]
        fn both<S: Simd>(simd: S, first: u32, seed: u32, frame: &Frame) -> Sixteen {
            let square = owen_sobol_2d_lanes(simd, first, seed);
            let world = frame.to_world_lanes(simd, cosine_hemisphere_lanes(simd, square));
            (square.map(Into::into), world.map(Into::into))
        }
        dispatch!(level, simd => both(simd, first, seed, frame))
    }

    #[test]
    fn lanes_are_what_single_samples_are() {
        let frame = Frame::from_normal(Vec3::new(0.6, -0.48, 0.64));
        let mut worst = 0.0f32;
        for seed in 0..50 {
            for first in [0, 16, 37, 4096, u32::MAX - 7] {
                let (square, world) = at(Level::new(), first, seed, &frame);
                for lane in 0..16 {
                    let expected = owen_sobol_2d(first.wrapping_add(lane as u32), seed);
                    assert_eq!([square[0][lane], square[1][lane]], expected.to_array());
                    let found = Vec3::new(world[0][lane], world[1][lane], world[2][lane]);
                    let direction = frame.to_world(cosine_hemisphere(expected));
                    worst = worst.max((found - direction).length());
                }
                for level in simd_levels() {
                    assert_eq!(at(level, first, seed, &frame), (square, world), "{level:?}");
                }
            }
        }
        // Near the horizon the root magnifies the roundings of x and y: z^2 errs by some 4e-7.
        assert!(worst < 1e-3 && worst > 0.0, "{worst}");
    }

    #[test]
    fn the_middle_and_the_corners_of_the_square_are_no_special_case() {
        #[inline(always)]
        fn map<S: Simd>(simd: S, x: [f32; 16], y: [f32; 16]) -> [[f32; 16]; 3] {
            cosine_hemisphere_lanes(simd, [f32x16::simd_from(simd, x), f32x16::simd_from(simd, y)])
                .map(Into::into)
        }
        let mut x = [0.5; 16];
        let mut y = [0.5; 16];
        (x[1], y[1], x[2], y[2], x[3], y[3]) = (0.0, 0.0, 1.0, 1.0, 0.5, 0.0);
        let found = dispatch!(Level::new(), simd => map(simd, x, y));
        for lane in 0..4 {
            let expected = cosine_hemisphere(crate::Vec2::new(x[lane], y[lane]));
            let direction = Vec3::new(found[0][lane], found[1][lane], found[2][lane]);
            assert!((direction - expected).length() < 1e-3, "{direction} {expected}");
            assert!((direction.length() - 1.0).abs() < 1e-6);
        }
    }
}
