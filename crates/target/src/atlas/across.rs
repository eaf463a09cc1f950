//! Values for texels that surfaces read and that have none: from their own island, and over seams from where the surface goes on.

use super::{map::AtlasMap, seams::Seam};
use conray_core::Vec3;
use std::collections::BTreeMap;

/// Places a texel at which values go over a seam, so that each texel along it is met.
const PLACES_A_TEXEL: f32 = 2.0;

/// Gives values to texels that surfaces read and that have none: from their own island, however far, and where an island has no value at all from the other
/// side of its seams. What no value leads to stays without.
pub fn fill(seams: &[Seam], maps: &mut [AtlasMap]) {
    maps.iter_mut().for_each(AtlasMap::fill);
    // Islands get values in the order in which they hang together, so each step reaches at least one more.
    loop {
        let found = over(seams, maps);
        if found.is_empty() {
            return;
        }
        let mut changed = vec![false; maps.len()];
        for ((map, at), Mean { visibility, error, bent, count }) in found {
            maps[map].visibility[at] = visibility / count;
            maps[map].error[at] = error / count;
            maps[map].bent[at] = bent / count;
            changed[map] = true;
        }
        maps.iter_mut().zip(changed).filter(|(_, changed)| *changed).for_each(|(map, _)| map.fill());
    }
}

#[derive(Clone, Copy, Default)]
struct Mean {
    visibility: f32,
    error: f32,
    bent: Vec3,
    count: f32,
}

/// What texels without a value get from the other sides of seams.
fn over(seams: &[Seam], maps: &[AtlasMap]) -> BTreeMap<(usize, usize), Mean> {
    let mut found: BTreeMap<(usize, usize), Mean> = BTreeMap::new();
    for seam in seams {
        let steps = (PLACES_A_TEXEL * seam.texels(maps)).max(1.0).ceil();
        for step in 0..=steps as u32 {
            let uvs = seam.sides.map(|side| side.uvs[0].lerp(side.uvs[1], step as f32 / steps));
            for (here, there) in [(0, 1), (1, 0)] {
                let [map, other] = [here, there].map(|side| seam.sides[side].map);
                let mut lacking = maps[map]
                    .taps(uvs[here])
                    .filter(|&(at, _)| maps[map].is_read[at] && maps[map].visibility[at].is_nan())
                    .peekable();
                if lacking.peek().is_none() {
                    continue;
                }
                let visibility = maps[other].read(uvs[there]);
                if visibility.is_nan() {
                    continue;
                }
                let (mut error, mut bent) = (0.0, Vec3::ZERO);
                for (at, weight) in maps[other].taps(uvs[there]) {
                    error += weight * maps[other].error[at];
                    bent += weight * maps[other].bent[at];
                }
                for (at, _) in lacking {
                    let mean = found.entry((map, at)).or_default();
                    mean.visibility += visibility;
                    mean.error += error;
                    mean.bent += bent;
                    mean.count += 1.0;
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::SeamSide;
    use conray_core::Vec2;

    const SIDE: u32 = 40;

    /// Four islands side by side, of 6 columns each and 4 apart; the first has values, the seams join each to the next but the last.
    fn islands() -> (Vec<Seam>, AtlasMap) {
        let mut map = AtlasMap::empty(SIDE, 8);
        for (at, x, y) in (0..8 * SIDE as usize).map(|at| (at, at % SIDE as usize, at / SIDE as usize)) {
            map.is_read[at] = x % 10 < 6;
            if x < 6 {
                (map.visibility[at], map.error[at]) = (0.1 * y as f32, 0.01);
            }
        }
        let side = |x: f32| SeamSide { map: 0, uvs: [0.5, 7.5].map(|y| Vec2::new(x / SIDE as f32, y / 8.0)) };
        // The right rim of an island to the left rim of the next, the later seam first.
        let seam = |k: f32| Seam { sides: [side(10.0 * k + 5.0), side(10.0 * k + 11.0)] };
        (vec![seam(1.0), seam(0.0)], map)
    }

    #[test]
    fn islands_without_a_value_take_those_of_the_surface_that_goes_on() {
        let (seams, map) = islands();
        let mut maps = [map];
        fill(&seams, &mut maps);
        let at = |x: usize, y: usize| maps[0].visibility[y * SIDE as usize + x];
        for x in [10, 13, 20, 25] {
            let column: Vec<f32> = (0..8).map(|y| at(x, y)).collect();
            // Rows mix on the way.
            assert!(column.is_sorted() && column[7] - column[0] > 0.2, "{x}: {column:?}");
            assert!((column.iter().sum::<f32>() / 8.0 - 0.35).abs() < 0.05, "{x}: {column:?}");
        }
        assert!((0..8).all(|y| (at(11, y) - 0.1 * y as f32).abs() < 0.06));
        assert!((maps[0].error[25] - 0.01).abs() < 1e-6);
        assert!(at(30, 3).is_nan(), "no seam leads there");
        assert!(at(8, 3).is_nan(), "nothing reads it");
    }

    #[test]
    fn without_seams_islands_stay_by_themselves() {
        let (_, map) = islands();
        let mut maps = [map.clone()];
        fill(&[], &mut maps);
        assert!(maps[0].visibility[11].is_nan() && maps[0].visibility[3] == map.visibility[3]);
    }
}
