//! Open directions of points that have no rays of their own.

use super::{pixels::Pixels, tallies::Tally};
use conray_core::Vec3;

/// Pixels to either side, the nearest first.
const REACHES: [usize; 5] = [1, 2, 4, 8, 16];
/// Normals of neighbours that are asked have at least this cosine to the point's own.
const LIKE_COSINE: f32 = 0.9;

/// Mean open direction of a place: of its own rays, else of the nearest places like it that have some, else along the normal.
/// It is as long as the visibility allows at most.
pub(super) fn bent(pixels: &Pixels, tallies: &[Tally], at: usize, visibility: f32) -> Vec3 {
    let own = &tallies[at];
    let found = if own.units > 0 { Some(own.bent / own.units as f32) } else { near(pixels, tallies, at) };
    found.unwrap_or(visibility * pixels.normal(at)).clamp_length_max(visibility.max(f32::MIN_POSITIVE))
}

fn near(pixels: &Pixels, tallies: &[Tally], at: usize) -> Option<Vec3> {
    let (x, y, normal) = (at % pixels.stride, at / pixels.stride, pixels.normal(at));
    REACHES.into_iter().find_map(|reach| {
        let (mut sum, mut units) = (Vec3::ZERO, 0);
        for v in y.saturating_sub(reach)..(y + reach + 1).min(pixels.height) {
            for u in x.saturating_sub(reach)..(x + reach + 1).min(pixels.width) {
                let (place, tally) = (v * pixels.stride + u, &tallies[v * pixels.stride + u]);
                if tally.units > 0 && pixels.normal(place).dot(normal) >= LIKE_COSINE {
                    sum += tally.bent;
                    units += tally.units;
                }
            }
        }
        (units > 0).then(|| sum / units as f32)
    })
}
