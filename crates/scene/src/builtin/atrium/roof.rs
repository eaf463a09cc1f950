//! Roofs that slope towards the court, with rows of half-round tiles.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::part::Part;
use crate::builtin::shapes::mitred_ring;
use conray_core::{Vec2, Vec3};
use std::f32::consts::PI;

/// Where the slope starts: distance outside the columns' axis, and height.
const FOOT: Vec2 = Vec2::new(-0.95, EAVES + 0.12);
/// Rise over run.
const SLOPE: f32 = 0.34;
const TILE_SPACING: f32 = 0.4;
const TILE_LENGTH: f32 = 1.1;

/// Adds the roof's slab and its tiles.
pub(crate) fn add(assembly: &mut Assembly, material: u32) {
    let on_slope = |out: f32, above: f32| Vec2::new(out, FOOT.y + SLOPE * (out - FOOT.x) + above);
    let end = 5.9;
    let slab = [on_slope(FOOT.x, 0.0), on_slope(end, 0.0), on_slope(end, 0.16), on_slope(FOOT.x, 0.16)];
    assembly.add("roof", mitred_ring(COURT, &slab).flat(), material);
    let mut tiles = Part::default();
    for side in Side::all() {
        tiles.place(&tile_rows(&side).smooth(60.0), &side.world_from_side);
    }
    assembly.add("tiles", tiles, material);
}

/// Half-round cover tiles of one side: single sheets in rows up the slope, each tile tucked under the next one.
fn tile_rows(side: &Side) -> Faces {
    let mut faces = Faces::default();
    let reach = side.half_length() + side.depth;
    let rows = (2.0 * reach / TILE_SPACING).floor() as i32;
    for row in 0..=rows {
        let x = (row as f32 - 0.5 * rows as f32) * TILE_SPACING;
        // Beyond the ends of the court the slope begins at the hip, where it meets that of the next side.
        let from = FOOT.x.max(x.abs() - side.half_length()) - 0.04;
        let count = ((side.depth - from) / TILE_LENGTH).ceil().max(0.0) as usize;
        for tile in 0..count {
            let low = from + tile as f32 * TILE_LENGTH;
            let high = (low + TILE_LENGTH + 0.1).min(side.depth + 0.05);
            faces.extend(&cover_tile(x, low, high));
        }
    }
    faces
}

/// A half-round tile from `low` to `high` outside the columns' axis, wider at its lower end.
fn cover_tile(x: f32, low: f32, high: f32) -> Faces {
    Faces::sheet(4, 1, |u, v| {
        let radius = 0.15 - 0.03 * v;
        let out = low + (high - low) * v;
        let angle = PI * (1.0 - u);
        // The upper end goes under the next tile.
        let y = FOOT.y + SLOPE * (out - FOOT.x) + 0.17 + 0.015 * (1.0 - v);
        Vec3::new(x + radius * angle.cos(), y + radius * angle.sin(), -out)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::assert_sound;

    #[test]
    fn tiles_are_sound_face_up_and_stay_on_their_side_of_the_hips() {
        for side in Side::all() {
            let part = tile_rows(&side).smooth(60.0);
            assert_sound(&part, "tiles");
            assert!(part.normals.iter().all(|n| n.y > -0.2), "tiles face up");
            let beyond = part.positions.iter().filter(|p| p.x.abs() > side.half_length() - p.z + 0.3).count();
            assert_eq!(beyond, 0, "tiles cross the hip");
        }
    }
}
