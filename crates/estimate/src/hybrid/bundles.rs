//! Bundles of rays, and what of them is kept.

use super::tallies::{FULL, Tally, UNIT};
use crate::{
    AoPlan,
    methods::{PointRays, Squares},
};
use conray_bvh::{BUNDLE_RAYS, Bvh, Directions};
use conray_core::{LANES, SurfacePoint, hash_u32};
use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use std::ops::Range;

/// Cells of the square on each side, and in all.
const SIDE: u32 = 4;
const CELLS: usize = (SIDE * SIDE) as usize;
/// Rays of a full bundle in each, and of a unit in each four of them.
const IN_CELL: f32 = 4.0;

/// Rays that are traced together, and where they come from.
struct Batch {
    directions: Directions,
    cells: [u32; BUNDLE_RAYS],
    visible: [f32; BUNDLE_RAYS],
}

/// Traces some units of a point's sequence; `salt` chooses another sequence.
pub(super) fn trace(plan: &AoPlan, bvh: &Bvh, point: &SurfacePoint, units: Range<u32>, salt: u32) -> Tally {
    let mut tally = Tally::default();
    each(plan, bvh, point, units, salt, |rays, batch, count| tally.merge(&summed(rays, batch, count)));
    tally
}

/// A full bundle of another sequence.
pub(super) struct Again {
    /// Mean visibility.
    pub(super) mean: f32,
    /// That of its first unit.
    pub(super) first: f32,
    /// Mean over its units of the variance of their means, as if their rays were independent within each of 2 x 2 cells.
    pub(super) in_units: f32,
    /// The variance of its mean, as if its rays were independent within each of 4 x 4 cells.
    pub(super) in_full: f32,
}

/// Traces a full bundle apart from a point's own rays.
pub(super) fn again(plan: &AoPlan, bvh: &Bvh, point: &SurfacePoint, salt: u32) -> Again {
    let mut found = Again { mean: 0.0, first: 0.0, in_units: 0.0, in_full: 0.0 };
    each(plan, bvh, point, 0..FULL, salt, |_, batch, _| {
        let unit = UNIT as usize;
        let mean = |visible: &[f32]| visible.iter().sum::<f32>() / visible.len() as f32;
        let units = batch.cells.chunks(unit).zip(batch.visible.chunks(unit));
        found = Again {
            mean: mean(&batch.visible),
            first: mean(&batch.visible[..unit]),
            in_units: units.map(|(cells, visible)| within_quarters(cells, visible)).sum::<f32>()
                / FULL as f32,
            in_full: within_cells(&batch.cells, &batch.visible),
        };
    });
    found
}

/// Traces units of a point's sequence, batch by batch: full bundles where they are aligned.
fn each(
    plan: &AoPlan,
    bvh: &Bvh,
    point: &SurfacePoint,
    units: Range<u32>,
    salt: u32,
    mut found: impl FnMut(&PointRays<'_>, &Batch, u32),
) {
    let squares = Squares::Sobol { seed: hash_u32(point.id ^ hash_u32(plan.seed ^ salt)) };
    let rays = PointRays::new(plan, bvh, point);
    let mut batch =
        Batch { directions: Directions::new(), cells: [0; BUNDLE_RAYS], visible: [0.0; BUNDLE_RAYS] };
    let mut first = units.start;
    while first < units.end {
        let count = (FULL - first % FULL).min(units.end - first);
        let samples = first * UNIT..(first + count) * UNIT;
        dispatch!(bvh.level(), simd => fill(simd, &squares, samples.clone(), &rays, &mut batch));
        batch.visible[samples.len()..].fill(0.0);
        rays.visibilities(&batch.directions, &mut batch.visible[..samples.len()]);
        found(&rays, &batch, count);
        batch.directions.clear();
        first += count;
    }
}

/// Fills an empty batch, each sample with its cell.
#[inline(always)]
fn fill<S: Simd>(simd: S, squares: &Squares, samples: Range<u32>, rays: &PointRays<'_>, batch: &mut Batch) {
    let side = f32x16::splat(simd, SIDE as f32);
    for group in 0..samples.len() / LANES {
        let drawn = squares.sixteen(simd, samples.start + (group * LANES) as u32, &rays.frame, rays.reach());
        let [u, v] = drawn.square;
        let of_group: [f32; LANES] = ((u * side).floor() + (v * side).floor() * side).into();
        let cells = &mut batch.cells[group * LANES..][..LANES];
        for (cell, of_group) in cells.iter_mut().zip(of_group) {
            *cell = of_group as u32;
        }
        batch.directions.push_group(&drawn.world, LANES);
    }
}

/// The tally of a batch of so many units.
fn summed(rays: &PointRays<'_>, batch: &Batch, count: u32) -> Tally {
    let all = rays.tally(&batch.directions, &batch.visible);
    let mut tally = Tally {
        units: count,
        sum: all.mean() * count as f32,
        bent: all.open / UNIT as f32,
        ..Tally::default()
    };
    if count == FULL {
        tally.in_fulls = within_cells(&batch.cells, &batch.visible);
    } else {
        let unit = UNIT as usize;
        let units = batch.cells.chunks(unit).zip(batch.visible.chunks(unit)).take(count as usize);
        tally.in_units = units.map(|(cells, visible)| within_quarters(cells, visible)).sum();
    }
    tally
}

/// Variance of the mean of rays that are independent within the cells of the square; four lie in each.
fn within_cells(cells: &[u32], visible: &[f32]) -> f32 {
    within(visible, cells.iter().map(|&cell| cell as usize % CELLS))
}

/// The same for the quarters of the square.
fn within_quarters(cells: &[u32], visible: &[f32]) -> f32 {
    within(
        visible,
        cells.iter().map(|&cell| (cell / (SIDE / 2) % 2 + cell / (SIDE * SIDE / 2) * 2) as usize % CELLS),
    )
}

fn within(visible: &[f32], cells: impl Iterator<Item = usize>) -> f32 {
    let mut open = [0.0f32; CELLS];
    let mut squares = 0.0;
    for (cell, &visible) in cells.zip(visible) {
        open[cell] += visible;
        squares += visible * visible;
    }
    let within = squares - open.iter().map(|open| open * open).sum::<f32>() / IN_CELL;
    within.max(0.0) / (visible.len() * visible.len()) as f32
}
