//! Which of many like pixels come first, so that those chosen are spread.

/// Pixels on each side after which it repeats, as a power of two.
const BITS: u32 = 4;

/// Between 0 and 1, each value once in 16 x 16 pixels: those below any limit are spread evenly, and as many as it says. Limits of 1/2, 1/4
/// and so on give every other pixel of a checkerboard, one of each 2 x 2, and so on.
///
/// Ranks as in Bayer, "An Optimum Method for Two-Level Rendition of Continuous-Tone Pictures", 1973.
pub(super) fn spread(x: usize, y: usize) -> f32 {
    let mut rank = 0;
    for bit in 0..BITS {
        let (x, y) = (x >> bit & 1, y >> bit & 1);
        rank = rank * 4 + 2 * (x ^ y) + y;
    }
    (rank as f32 + 0.5) / (1 << (2 * BITS)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_as_the_limit_says_and_the_same_in_every_part() {
        let side = 1 << BITS;
        for share in [1, 2, 4, 8, 16, 64, 256] {
            // A block of as many pixels as have one, wherever it lies: squares, or two of them side by side.
            let (width, height) = match (1usize..=side).find(|s| s * s == share) {
                Some(s) => (s, s),
                None => ((2.0 * share as f64).sqrt() as usize, (0.5 * share as f64).sqrt() as usize),
            };
            for (left, top) in
                (0..side / width).flat_map(|x| (0..side / height).map(move |y| (x * width, y * height)))
            {
                let all = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
                let count = all.filter(|&(x, y)| spread(x, y) < 1.0 / share as f32).count();
                assert_eq!(count, 1, "one of {share}, in {width} x {height} at {left}, {top}");
            }
        }
        let mut ranks: Vec<f32> = (0..side * side).map(|k| spread(k % side, k / side)).collect();
        ranks.sort_by(f32::total_cmp);
        assert!(ranks.windows(2).all(|w| w[1] - w[0] > 0.9 / (side * side) as f32));
    }
}
