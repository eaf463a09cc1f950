//! Bundles of rays, and what of them is kept.

use super::tallies::{Bundle, Tally};
use crate::{
    AoPlan,
    methods::{PointRays, Squares},
};
use conray_bvh::{BUNDLE_RAYS, Bvh, Directions};
use conray_core::{LANES, SurfacePoint, hash_u32};
use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use std::ops::Range;

/// Most cells of the square.
const CELLS: usize = 16;
/// Rays of a bundle in each.
const IN_CELL: f32 = 4.0;

/// Rays that are traced together, and where they come from.
struct Batch {
    directions: Directions,
    cells: [u32; BUNDLE_RAYS],
    visible: [f32; BUNDLE_RAYS],
}

/// Traces some bundles of a point's sequence; `salt` chooses another sequence.
pub(super) fn trace(
    plan: &AoPlan,
    bvh: &Bvh,
    point: &SurfacePoint,
    unit: Bundle,
    bundles: Range<u32>,
    salt: u32,
) -> Tally {
    let squares = Squares::Sobol { seed: hash_u32(point.id ^ hash_u32(plan.seed ^ salt)) };
    let rays = PointRays::new(plan, bvh, point);
    let mut tally = Tally::default();
    let mut batch =
        Batch { directions: Directions::new(), cells: [0; BUNDLE_RAYS], visible: [0.0; BUNDLE_RAYS] };
    let together = BUNDLE_RAYS as u32 / unit.rays;
    for first in bundles.clone().step_by(together as usize) {
        let count = together.min(bundles.end - first);
        let samples = first * unit.rays..(first + count) * unit.rays;
        dispatch!(bvh.level(), simd => fill(simd, &squares, samples.clone(), unit, &rays, &mut batch));
        batch.visible[samples.len()..].fill(0.0);
        rays.visibilities(&batch.directions, &mut batch.visible[..samples.len()]);
        tally.merge(&summed(&rays, &batch, unit, count));
        batch.directions.clear();
    }
    tally
}

/// Fills an empty batch, each sample with its cell.
#[inline(always)]
fn fill<S: Simd>(
    simd: S,
    squares: &Squares,
    samples: Range<u32>,
    unit: Bundle,
    rays: &PointRays<'_>,
    batch: &mut Batch,
) {
    let side = f32x16::splat(simd, unit.side as f32);
    for group in 0..samples.len() / LANES {
        let drawn = squares.sixteen(simd, samples.start + (group * LANES) as u32, &rays.frame);
        let [u, v] = drawn.square;
        let of_group: [f32; LANES] = ((u * side).floor() + (v * side).floor() * side).into();
        let cells = &mut batch.cells[group * LANES..][..LANES];
        for (cell, of_group) in cells.iter_mut().zip(of_group) {
            *cell = of_group as u32;
        }
        batch.directions.push_group(&drawn.world, LANES);
    }
}

/// The tally of so many bundles. Four rays of each lie in every cell, as in every aligned block of the sequence.
fn summed(rays: &PointRays<'_>, batch: &Batch, unit: Bundle, count: u32) -> Tally {
    let all = rays.tally(&batch.directions, &batch.visible);
    let of_one = unit.rays as f32;
    let mut variance = 0.0;
    let parts = batch.cells.chunks(unit.rays as usize).zip(batch.visible.chunks(unit.rays as usize));
    for (cells, visible) in parts.take(count as usize) {
        let mut open = [0.0f32; CELLS];
        let mut squares = 0.0;
        for (&cell, &visible) in cells.iter().zip(visible) {
            open[cell as usize % CELLS] += visible;
            squares += visible * visible;
        }
        let within = squares - open.iter().map(|open| open * open).sum::<f32>() / IN_CELL;
        variance += within.max(0.0) / (of_one * of_one);
    }
    let bundles = count as f32;
    Tally { bundles: count, sum: all.mean() * bundles, variance, bent: all.open / of_one }
}
