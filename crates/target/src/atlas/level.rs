//! Both sides of a seam made to agree.
//!
//! Each place along a seam is read from up to four texels on either side. The texels are moved as little as possible, in the sense of least squares,
//! so that both reads come out the same: the noise of the two sides is averaged, and a renderer shows no line.

use super::{map::AtlasMap, seams::Seam};
use std::collections::HashMap;

/// Places a texel at which the sides are compared: between texels reads are not linear along a slanted seam.
const PLACES_A_TEXEL: f32 = 2.0;
/// How much a difference at a place weighs against moving a texel by as much.
const AGREEMENT: f64 = 400.0;
/// Steps of the solver at most, and the share of the first residual that is enough.
const MOST_STEPS: usize = 200;
const ENOUGH: f64 = 1e-4;

/// The texels that seams read, and how: rows of a matrix that is to give nothing.
#[derive(Default)]
struct Reads {
    /// Map and texel of each unknown.
    texels: Vec<(usize, usize)>,
    /// Unknowns and weights of each place, both sides, the second with minus.
    places: Vec<Vec<(u32, f32)>>,
}

/// Makes the visibility on both sides of seams agree. Texels without a value are not read; expected errors stay.
pub fn level(seams: &[Seam], maps: &mut [AtlasMap]) {
    let reads = Reads::of(seams, maps);
    let before: Vec<f64> =
        reads.texels.iter().map(|&(map, at)| f64::from(maps[map].visibility[at])).collect();
    for (&(map, at), moved) in reads.texels.iter().zip(reads.moved(&before)) {
        let value = &mut maps[map].visibility[at];
        *value = (f64::from(*value) + moved).clamp(0.0, 1.0) as f32;
    }
}

impl Reads {
    fn of(seams: &[Seam], maps: &[AtlasMap]) -> Self {
        let mut reads = Self::default();
        let mut unknown: HashMap<(usize, usize), u32> = HashMap::new();
        for seam in seams {
            let steps = (PLACES_A_TEXEL * seam.texels(maps)).max(1.0).ceil();
            for step in 0..=steps as u32 {
                let mut place = Vec::with_capacity(8);
                for (side, sign) in seam.sides.iter().zip([1.0, -1.0]) {
                    let uv = side.uvs[0].lerp(side.uvs[1], step as f32 / steps);
                    for (at, weight) in maps[side.map].taps(uv) {
                        let next = reads.texels.len() as u32;
                        let index = *unknown.entry((side.map, at)).or_insert(next);
                        if index == next {
                            reads.texels.push((side.map, at));
                        }
                        place.push((index, sign * weight));
                    }
                }
                let is_known = |&(index, _): &(u32, f32)| {
                    let (map, at) = reads.texels[index as usize];
                    !maps[map].visibility[at].is_nan()
                };
                if place.iter().all(is_known) {
                    reads.places.push(place);
                }
            }
        }
        reads
    }

    /// What each texel is to be moved by: conjugate gradients on (1 + a R'R) m = -a R'R before.
    fn moved(&self, before: &[f64]) -> Vec<f64> {
        let known: Vec<f64> = before.iter().map(|&value| if value.is_nan() { 0.0 } else { value }).collect();
        let mut residual: Vec<f64> = self.pulled(&known).iter().map(|pull| -pull).collect();
        let mut moved = vec![0.0; known.len()];
        let mut direction = residual.clone();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let first = dot(&residual, &residual);
        let mut left = first;
        for _ in 0..MOST_STEPS {
            if left <= ENOUGH * ENOUGH * first {
                break;
            }
            let pulled = self.pulled(&direction);
            let ahead: Vec<f64> = direction.iter().zip(&pulled).map(|(a, b)| a + b).collect();
            let step = left / dot(&direction, &ahead);
            moved.iter_mut().zip(&direction).for_each(|(moved, along)| *moved += step * along);
            residual.iter_mut().zip(&ahead).for_each(|(residual, ahead)| *residual -= step * ahead);
            let now = dot(&residual, &residual);
            let kept = now / left;
            direction
                .iter_mut()
                .zip(&residual)
                .for_each(|(along, residual)| *along = residual + kept * *along);
            left = now;
        }
        moved
    }

    /// a R'R of values.
    fn pulled(&self, values: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; values.len()];
        for place in &self.places {
            let read: f64 =
                place.iter().map(|&(index, weight)| f64::from(weight) * values[index as usize]).sum();
            for &(index, weight) in place {
                out[index as usize] += AGREEMENT * f64::from(weight) * read;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::{SeamReport, SeamSide};
    use conray_core::Vec2;

    const SIDE: u32 = 64;

    /// A slanted seam whose second side lies half a map further on.
    fn seams() -> Vec<Seam> {
        let ends = [Vec2::new(0.1, 0.12), Vec2::new(0.37, 0.41)];
        let side = |moved: f32| SeamSide { map: 0, uvs: ends.map(|uv| uv + moved) };
        vec![Seam { sides: [side(0.0), side(0.503)] }]
    }

    fn map(value: impl Fn(u32, u32) -> f32) -> AtlasMap {
        let mut map = AtlasMap::empty(SIDE, SIDE);
        for at in 0..SIDE * SIDE {
            map.visibility[at as usize] = value(at % SIDE, at / SIDE);
        }
        map
    }

    #[test]
    fn sides_that_differ_meet_in_the_middle() {
        let second = |x: u32, y: u32| x + y > SIDE;
        let mut maps = [map(|x, y| if second(x, y) { 0.7 } else { 0.6 })];
        assert!((SeamReport::of(&seams(), &maps, 0.0).worst - 0.1).abs() < 1e-6);
        level(&seams(), &mut maps);
        let report = SeamReport::of(&seams(), &maps, 0.002);
        assert_eq!(report.within, report.places, "{report:?}");
        assert!(
            (maps[0].read(seams()[0].sides[0].uvs[0].lerp(seams()[0].sides[0].uvs[1], 0.5)) - 0.65).abs()
                < 2e-3
        );
        // Texels that no seam reads stay.
        assert_eq!((maps[0].visibility[0], *maps[0].visibility.last().unwrap()), (0.6, 0.7));
    }

    #[test]
    fn noise_on_both_sides_is_evened_out_and_small() {
        let noise = |x: u32, y: u32| ((x * 7919 + y * 104_729) % 101) as f32 / 101.0 * 0.1 - 0.05;
        let mut maps = [map(|x, y| 0.5 + noise(x, y))];
        let before = SeamReport::of(&seams(), &maps, 0.02);
        level(&seams(), &mut maps);
        let after = SeamReport::of(&seams(), &maps, 0.02);
        assert!(before.within < before.places * 9 / 10, "{before:?}");
        assert_eq!(after.within, after.places, "{after:?}");
        let most = maps[0].visibility.iter().map(|v| (v - 0.5).abs()).fold(0.0, f32::max);
        assert!(most < 0.08, "{most}");
    }

    #[test]
    fn texels_without_a_value_and_maps_without_seams_stay() {
        let mut maps = [map(|_, _| f32::NAN)];
        level(&seams(), &mut maps);
        assert!(maps[0].visibility.iter().all(|value| value.is_nan()));
        let mut maps = [map(|x, _| x as f32 / 64.0)];
        let before = maps.clone();
        level(&[], &mut maps);
        assert_eq!(maps, before);
    }
}
