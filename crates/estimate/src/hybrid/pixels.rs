//! Surface points in an image, component by component, so that neighbours stand side by side.

use super::scattered::Scattered;
use conray_core::{LANES, SurfacePoint, Vec3};

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
    pub(super) fn of_image(points: &[SurfacePoint], width: u32, height: u32, distance: f32) -> Self {
        let (width, height) = (width as usize, height as usize);
        let cell = |index: usize| Some(points[index].id as usize).filter(|&id| id < width * height);
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
        cell: impl Fn(usize) -> Option<usize>,
        footprint: impl Fn(usize) -> f32,
    ) -> Self {
        let unit = unit(points, distance);
        let stride = width.next_multiple_of(LANES);
        let count = stride * height;
        let mut pixels = Self {
            width,
            height,
            stride,
            place: std::array::from_fn(|_| vec![0.0; count]),
            sharpness: vec![0.0; count],
            point: vec![NO_POINT; count],
            place_of: vec![NO_POINT; points.len()],
        };
        let origin = points.iter().find(|p| p.is_valid()).map_or(Vec3::ZERO, |p| p.position);
        for (index, point) in points.iter().enumerate().filter(|(_, p)| p.is_valid()) {
            let Some(cell) = cell(index) else { continue };
            let at = cell / width * stride + cell % width;
            let position = (point.position - origin) / unit;
            for axis in 0..3 {
                pixels.place[axis][at] = position[axis];
                pixels.place[3 + axis][at] = point.shading_normal[axis];
            }
            let footprint = footprint(index);
            let footprint = if footprint > 0.0 { footprint / unit } else { UNKNOWN_FOOTPRINT };
            pixels.sharpness[at] = (1.0 / footprint).clamp(f32::MIN_POSITIVE, SHARPEST);
            pixels.point[at] = index as u32;
            pixels.place_of[index] = at as u32;
        }
        pixels
    }

    /// Places in all.
    pub(super) fn len(&self) -> usize {
        self.point.len()
    }

    pub(super) fn is_covered(&self, at: usize) -> bool {
        self.point[at] != NO_POINT
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
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for point in points.iter().filter(|p| p.is_valid()) {
        low = low.min(point.position);
        high = high.max(point.position);
    }
    let unit = distance.min(0.25 * (high - low).length());
    if unit > 0.0 && unit.is_finite() { unit } else { 1.0 }
}
