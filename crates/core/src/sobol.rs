//! Owen-scrambled Sobol points in two dimensions, by hashing.
//!
//! Burley, "Practical Hash-based Owen Scrambling", 2020; hash constants after Laine and Karras, "Stratified Sampling
//! for Stochastic Transparency", 2011, as improved by Vegdahl, "Building a Better LK Hash", 2021. Unlike Burley's, the
//! seed is mixed by a full hash for each use, so neighbouring seeds are independent.

use crate::Vec2;

/// Make the two dimensions' scrambles independent.
pub(crate) const SEED_X: u32 = 0x5167_3e4d;
pub(crate) const SEED_Y: u32 = 0xa3d8_95b1;
/// The multipliers of the scrambling hash.
pub(crate) const SCRAMBLE: [u32; 3] = [0x3d20_adea, 0x0552_6c56, 0x53a2_2864];

/// Full-avalanche hash of 32 bits.
///
/// "lowbias32" by Wellons, "Prospecting for Hash Functions", 2018.
#[inline]
pub const fn hash_u32(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Point `index` of the sequence `seed`, in [0, 1)^2.
///
/// Every aligned block of 2^k indices is a (0, k, 2)-net: it has one point in each of the 2^k elementary intervals of every shape.
#[inline]
pub fn owen_sobol_2d(index: u32, seed: u32) -> Vec2 {
    // Shuffling scrambles the index as if it were a fraction: blocks of 2^k aligned indices stay together.
    let shuffled = owen_scramble(index, hash_u32(seed));
    // Dimension 0 of the Sobol sequence is bit reversal, and scrambling works on reversed bits.
    let x = owen_scramble(shuffled.reverse_bits(), hash_u32(seed ^ SEED_X));
    let y = owen_scramble(sobol_dimension_1(shuffled), hash_u32(seed ^ SEED_Y));
    Vec2::new(unit_float(x), unit_float(y))
}

/// Second dimension of the Sobol sequence as a 32-bit fraction: Pascal's triangle modulo 2 times the index.
#[inline]
const fn sobol_dimension_1(index: u32) -> u32 {
    // The matrix is the tensor power of [[1, 1], [0, 1]]: five butterfly steps apply it.
    let mut x = index;
    x ^= (x >> 1) & 0x5555_5555;
    x ^= (x >> 2) & 0x3333_3333;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^= (x >> 16) & 0x0000_ffff;
    x.reverse_bits()
}

/// Owen scrambling of a 32-bit fraction: each bit flips depending on the bits above it only.
#[inline]
const fn owen_scramble(fraction: u32, seed: u32) -> u32 {
    let mut x = fraction.reverse_bits();
    x ^= x.wrapping_mul(SCRAMBLE[0]);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(SCRAMBLE[1]);
    x ^= x.wrapping_mul(SCRAMBLE[2]);
    x.reverse_bits()
}

/// The upper 24 bits as a float in [0, 1).
#[inline]
fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Moments;

    /// Counts points in each elementary interval of 2^-a by 2^-(k-a).
    fn is_net(points: &[Vec2], k: u32) -> bool {
        (0..=k).all(|a| {
            let mut seen = vec![0u32; 1 << k];
            for p in points {
                let (x, y) = ((p.x * (1 << a) as f32) as usize, (p.y * (1 << (k - a)) as f32) as usize);
                seen[(x << (k - a)) + y] += 1;
            }
            seen.iter().all(|&n| n == 1)
        })
    }

    #[test]
    fn aligned_blocks_are_nets() {
        for seed in 0..20 {
            for k in 0..=8 {
                for block in 0..3 {
                    let points: Vec<Vec2> =
                        (0..1 << k).map(|i| owen_sobol_2d((block << k) + i, seed)).collect();
                    assert!(is_net(&points, k), "seed {seed}, k {k}, block {block}");
                }
            }
        }
    }

    #[test]
    fn plain_hashing_is_no_net() {
        let points: Vec<Vec2> = (0..64)
            .map(|i| Vec2::new(unit_float(hash_u32(i)), unit_float(hash_u32(i ^ 0x9e37_79b9))))
            .collect();
        assert!(!is_net(&points, 6), "the oracle must be able to fail");
    }

    #[test]
    fn unscrambled_dimensions_agree_with_sobol_burley() {
        for i in 0..1024u32 {
            let theirs = sobol_burley::parts::sobol_rev(i.reverse_bits(), 1).reverse_bits();
            assert_eq!(sobol_dimension_1(i), theirs, "index {i}");
        }
    }

    #[test]
    fn mean_over_seeds_is_unbiased() {
        // x * y integrates to 1/4; each seed's 16-point mean is one draw.
        let m: Moments = (0..4000)
            .map(|seed| {
                (0..16).map(|i| owen_sobol_2d(i, seed)).map(|p| f64::from(p.x * p.y)).sum::<f64>() / 16.0
            })
            .collect();
        assert!((m.mean - 0.25).abs() < 4.0 * m.standard_error(), "{m:?}");
        assert!(m.standard_error() > 0.0);
    }

    #[test]
    fn converges_faster_than_random() {
        // Variance of the mean of a smooth function falls as n^-3; random sampling would give n^-1.
        let variance = |n: u32| {
            (0..500)
                .map(|seed| {
                    (0..n).map(|i| owen_sobol_2d(i, seed)).map(|p| f64::from(p.x * p.y)).sum::<f64>()
                        / f64::from(n)
                })
                .collect::<Moments>()
                .sample_variance()
        };
        assert!(variance(16) / variance(256) > 16f64.powf(2.0));
    }
}
