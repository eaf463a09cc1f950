//! Surface points in an image, component by component, so that neighbours stand side by side.

use super::{
    columns::{PART, in_parts},
    scattered::Scattered,
};
use conray_core::{LANES, SurfacePoint, Vec3};
use rayon::prelude::*;

/// What is known of each pixel without a ray. Rows are padded to whole vectors; what has no point is not covered.
#[derive(Clone, Debug)]
pub(super) struct Pixels {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Places in a row: the width, rounded up to whole vectors.
    pub(super) stride: usize,
    /// Position over the unit of length, then shading normal.
    pub(super) place: [Vec<f32>; 6],
    /// One over the footprint in units of length; 0 where there is no point.
    pub(super) sharpness: Vec<f32>,
    /// Which point each place has; [`NO_POINT`] where none.
    pub(super) point: Vec<u32>,
    /// The place of each point.
    pub(super) place_of: Vec<u32>,
}

/// Footprint of a point that does not tell it, in units of length.
const UNKNOWN_FOOTPRINT: f32 = 0.01;
/// Footprints below one over this make no difference, and squares of more would not be finite.
const SHARPEST: f32 = 1e6;

/// Stands for a pixel that sees nothing.
pub(super) const NO_POINT: u32 = u32::MAX;

impl Pixels {
    /// Points of an image. Points whose id is no pixel, or that are not valid, have no place.
    pub(super) fn of_image(points: &[SurfacePoint], first: u32, size: [u32; 2], distance: f32) -> Self {
        let [width, height] = size.map(|side| side as usize);
        let cell = |index: usize| {
            let pixel = points[index].id.checked_sub(first)? as usize;
            (pixel < width * height).then_some(pixel)
        };
        Self::lay(points, [width, height], distance, cell, |index| points[index].footprint)
    }

    /// Points that lie in no image.
    pub(super) fn of_scattered(points: &[SurfacePoint], distance: f32) -> Self {
        let Scattered { width, height, cell, spacing } = Scattered::new(points);
        Self::lay(points, [width, height], distance, |index| cell[index], |index| spacing[index])
    }

    /// Positions are told in units of the AO distance, or of a quarter of what the points span where that is less.
    fn lay(
        points: &[SurfacePoint],
        [width, height]: [usize; 2],
        distance: f32,
        cell: impl Fn(usize) -> Option<usize> + Sync,
        footprint: impl Fn(usize) -> f32 + Sync,
    ) -> Self {
        let unit = unit(points, distance);
        let stride = width.next_multiple_of(LANES);
        let count = stride * height;
        let place = |(index, point): (usize, &SurfacePoint)| {
            let cell = cell(index).filter(|_| point.is_valid());
            cell.map_or(NO_POINT, |cell| (cell / width * stride + cell % width) as u32)
        };
        let place_of: Vec<u32> = points.par_iter().enumerate().with_min_len(PART).map(place).collect();
        let mut point = vec![NO_POINT; count];
        for (index, &at) in (0..).zip(&place_of).filter(|(_, at)| **at != NO_POINT) {
            point[at as usize] = index;
        }
        let origin = points.iter().find(|p| p.is_valid()).map_or(Vec3::ZERO, |p| p.position);
        let mut columns: [Vec<f32>; 7] = std::array::from_fn(|_| vec![0.0; count]);
        let parts = in_parts(&mut columns, PART).into_par_iter().zip(point.par_chunks(PART));
        parts.for_each(|(mut out, indices)| {
            for (k, &index) in indices.iter().enumerate().filter(|(_, index)| **index != NO_POINT) {
                let point = &points[index as usize];
                let (position, normal) = ((point.position - origin) / unit, point.shading_normal);
                let footprint = footprint(index as usize);
                let footprint = if footprint > 0.0 { footprint / unit } else { UNKNOWN_FOOTPRINT };
                let sharpness = (1.0 / footprint).clamp(f32::MIN_POSITIVE, SHARPEST);
                let of_point = [position.x, position.y, position.z, normal.x, normal.y, normal.z, sharpness];
                out.iter_mut().zip(of_point).for_each(|(out, value)| out[k] = value);
            }
        });
        let [px, py, pz, nx, ny, nz, sharpness] = columns;
        Self { width, height, stride, place: [px, py, pz, nx, ny, nz], sharpness, point, place_of }
    }

    /// Places in all.
    pub(super) fn len(&self) -> usize {
        self.point.len()
    }

    pub(super) fn is_covered(&self, at: usize) -> bool {
        self.point[at] != NO_POINT
    }

    /// Places that have a point, in their order.
    pub(super) fn covered(&self) -> impl Iterator<Item = u32> {
        (0u32..).zip(&self.point).filter(|(_, point)| **point != NO_POINT).map(|(at, _)| at)
    }

    pub(super) fn normal(&self, at: usize) -> Vec3 {
        Vec3::new(self.place[3][at], self.place[4][at], self.place[5][at])
    }

    /// Footprint, in units of length, of the first covered pixel in a block of pixels; 0 where none is covered.
    pub(super) fn footprint(&self, (x, y): (usize, usize), side: usize) -> f32 {
        let rows = y..(y + side).min(self.height);
        let first = rows
            .flat_map(|y| &self.sharpness[y * self.stride + x..y * self.stride + (x + side).min(self.width)])
            .find(|&&s| s > 0.0);
        first.map_or(0.0, |s| 1.0 / s)
    }
}

/// The length in which positions are told.
fn unit(points: &[SurfacePoint], distance: f32) -> f32 {
    let valid =
        points.par_iter().with_min_len(PART).filter(|p| p.is_valid()).map(|p| (p.position, p.position));
    let wider = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
    let (low, high) = valid.reduce(|| (Vec3::INFINITY, Vec3::NEG_INFINITY), wider);
    let unit = distance.min(0.25 * (high - low).length());
    if unit > 0.0 && unit.is_finite() { unit } else { 1.0 }
}
