//! A ball of nearly equal triangles.

use crate::builtin::part::Part;
use conray_core::{Vec2, Vec3};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// The unit ball as an icosahedron whose edges are halved `halvings` times: 20 * 4^n triangles, smooth normals, closed.
///
/// One vertex lies exactly at each of plus and minus Y, so that a ball can stand on a floor.
pub(crate) fn icosphere(halvings: u32) -> Part {
    let (mut positions, mut triangles) = icosahedron();
    for _ in 0..halvings {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let mut middle = |v: u32, w: u32| {
                *middles.entry([v.min(w), v.max(w)]).or_insert_with(|| {
                    // The sum does not depend on the order of its two terms.
                    positions.push((positions[v as usize] + positions[w as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let uv = |p: &Vec3| Vec2::new(p.z.atan2(p.x) / TAU + 0.5, p.y.clamp(-1.0, 1.0).acos() / PI);
    Part { uvs: positions.iter().map(uv).collect(), normals: positions.clone(), positions, triangles }
}

/// Twelve vertices: both poles and two rings of five at latitude atan(1/2).
fn icosahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = vec![Vec3::Y];
    let (height, radius) = (1.0 / 5f32.sqrt(), 2.0 / 5f32.sqrt());
    for (half_turns, y) in [(0.0, height), (1.0, -height)] {
        positions.extend((0..5).map(|i| {
            let angle = TAU * (i as f32 + 0.5 * half_turns) / 5.0;
            Vec3::new(radius * angle.cos(), y, -radius * angle.sin())
        }));
    }
    positions.push(Vec3::NEG_Y);
    let mut triangles = Vec::with_capacity(20);
    for i in 0..5 {
        let j = (i + 1) % 5;
        let (upper, next_upper, lower, next_lower) = (1 + i, 1 + j, 6 + i, 6 + j);
        triangles.extend([
            [0, upper, next_upper],
            [upper, lower, next_upper],
            [next_upper, lower, next_lower],
            [lower, 11, next_lower],
        ]);
    }
    (positions, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn balls_are_round_closed_and_touch_the_poles() {
        for halvings in 0..4 {
            let ball = icosphere(halvings);
            assert_eq!(ball.triangles.len(), 20 << (2 * halvings));
            assert_closed(&ball, "ball");
            assert_sound(&ball, "ball");
            assert!(ball.positions.iter().all(|p| (p.length() - 1.0).abs() < 1e-6));
            let lowest = ball.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
            assert_eq!(lowest, -1.0);
        }
    }
}
