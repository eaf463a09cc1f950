//! Points that lie in no image, laid out in one, so that the same cells and windows serve them.
//!
//! Points that face one way and lie about one plane are a chart. Halves of it, then halves of those, go to halves of a rectangle
//! of cells, so that each cell has one point at most, however dense points are where, and cells side by side have neighbours.

use conray_core::{LANES, SurfacePoint, Vec3};

/// Gaps in depth of so many mean distances between neighbours part surfaces that face the same way.
const GAP: f32 = 3.0;
/// No chart is longer than so many times the side of a square with as many cells.
const LONGEST: usize = 4;
/// Room between charts that no shelf fills.
const SLACK: f64 = 1.05;
/// From so many points on halves are laid out side by side.
const MANY: usize = 1 << 12;

/// Where each point lies in an image of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Scattered {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Cell of each point, row by row; none of those that are not valid.
    pub(super) cell: Vec<Option<usize>>,
    /// Distance to neighbours; 0 of points without any.
    pub(super) spacing: Vec<f32>,
}

/// A point of a chart: which it is, where along the two axes of the plane, and its cell.
#[derive(Clone, Copy, Debug)]
struct Placed {
    index: u32,
    along: [f32; 2],
    cell: [usize; 2],
}

/// Points about one plane, as many as cells of a rectangle or a few less.
struct Chart {
    points: Vec<Placed>,
    size: [usize; 2],
}

impl Scattered {
    /// Lays the points out, by positions and shading normals alone.
    pub(super) fn new(points: &[SurfacePoint]) -> Self {
        let mut facing: [Vec<u32>; 6] = Default::default();
        for (index, point) in points.iter().enumerate().filter(|(_, p)| p.is_valid()) {
            facing[side(point.shading_normal)].push(index as u32);
        }
        let mut charts = Vec::new();
        for (side, group) in facing.into_iter().enumerate() {
            by_depth(points, group, side / 2, &mut charts);
        }
        // Shelves of charts, the highest first.
        charts.sort_by_key(|chart| std::cmp::Reverse(chart.size[1]));
        let cells: usize = charts.iter().map(|chart| chart.size[0] * chart.size[1]).sum();
        let widest = charts.iter().map(|chart| chart.size[0]).max().unwrap_or(1);
        let width = ((SLACK * (cells as f64).sqrt()) as usize).max(widest).next_multiple_of(LANES);
        let (mut cell, mut spacing) = (vec![None; points.len()], vec![0.0; points.len()]);
        let (mut x, mut y, mut shelf) = (0, 0, 0);
        for chart in &mut charts {
            if x + chart.size[0] > width {
                (x, y, shelf) = (0, y + shelf, 0);
            }
            shelf = shelf.max(chart.size[1]);
            halve(&mut chart.points, [x, y], chart.size);
            for placed in &chart.points {
                cell[placed.index as usize] = Some(placed.cell[1] * width + placed.cell[0]);
            }
            chart.tell_spacing(points, [x, y], &mut spacing);
            x += chart.size[0];
        }
        Self { width, height: y + shelf, cell, spacing }
    }
}

/// Which of six ways a normal faces: twice the axis, and one more the other way.
fn side(normal: Vec3) -> usize {
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}

/// Charts of points that face along an axis, parted where nothing lies between.
fn by_depth(points: &[SurfacePoint], mut group: Vec<u32>, axis: usize, charts: &mut Vec<Chart>) {
    let position = |index: u32| points[index as usize].position;
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    group.sort_by(|&a, &b| position(a)[axis].total_cmp(&position(b)[axis]));
    let [a, b] = extents(group.iter().map(|&index| position(index)), [u, v]);
    let gap = GAP * (a * b / group.len() as f32).sqrt();
    for part in group.chunk_by(|&a, &b| position(b)[axis] - position(a)[axis] <= gap) {
        let placed =
            |&index: &u32| Placed { index, along: [position(index)[u], position(index)[v]], cell: [0, 0] };
        let extents = extents(part.iter().map(|&index| position(index)), [u, v]);
        charts
            .push(Chart { points: part.iter().map(placed).collect(), size: rectangle(part.len(), extents) });
    }
}

fn extents(positions: impl Iterator<Item = Vec3>, axes: [usize; 2]) -> [f32; 2] {
    let all = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = positions.fold(all, |(low, high), p| (low.min(p), high.max(p)));
    axes.map(|axis| high[axis] - low[axis])
}

/// Cells for so many points, of about the shape of what they span.
fn rectangle(count: usize, [a, b]: [f32; 2]) -> [usize; 2] {
    let longest = LONGEST * (count as f64).sqrt().ceil() as usize;
    // Of points on one line the ratio is 0, infinite or no number: the limits say what is made of it.
    let wanted = (count as f64 * f64::from(a) / f64::from(b)).sqrt();
    let width = (wanted.round() as usize).clamp(count.div_ceil(longest), longest.min(count));
    [width, count.div_ceil(width)]
}

/// Points to cells of a rectangle: the lower half along its longer side to the lower half of it, and so on.
fn halve(points: &mut [Placed], from: [usize; 2], size: [usize; 2]) {
    if size == [1, 1] || points.is_empty() {
        points.iter_mut().for_each(|point| point.cell = from);
        return;
    }
    let axis = usize::from(size[1] > size[0]);
    let (mut low, mut high, mut beyond) = (size, size, from);
    low[axis] = size[axis] / 2;
    high[axis] = size[axis] - low[axis];
    beyond[axis] += low[axis];
    let room = |size: [usize; 2]| size[0] * size[1];
    let share = (points.len() * low[axis]).div_ceil(size[axis]);
    let count = share.clamp(points.len().saturating_sub(room(high)), room(low).min(points.len()));
    if (1..points.len()).contains(&count) {
        points.select_nth_unstable_by(count, |a, b| {
            a.along[axis].total_cmp(&b.along[axis]).then(a.index.cmp(&b.index))
        });
    }
    let many = points.len() >= MANY;
    let (lower, higher) = points.split_at_mut(count);
    if many {
        rayon::join(|| halve(lower, from, low), || halve(higher, beyond, high));
    } else {
        halve(lower, from, low);
        halve(higher, beyond, high);
    }
}

impl Chart {
    /// The distance of each point to its neighbours in the four cells about: half of them are no farther.
    fn tell_spacing(&self, points: &[SurfacePoint], from: [usize; 2], spacing: &mut [f32]) {
        let [width, height] = self.size;
        let mut grid = vec![None; width * height];
        for placed in &self.points {
            grid[(placed.cell[1] - from[1]) * width + placed.cell[0] - from[0]] = Some(placed.index as usize);
        }
        for (at, own) in grid.iter().enumerate().filter_map(|(at, own)| Some((at, (*own)?))) {
            let (x, y) = (at % width, at / width);
            let about = [
                (x > 0).then(|| at - 1),
                (x + 1 < width).then_some(at + 1),
                (y > 0).then(|| at.wrapping_sub(width)),
                (y + 1 < height).then_some(at + width),
            ];
            // Of places too far from each other for a number it is the largest.
            let distance = |other: usize| points[other].position.distance(points[own].position).min(f32::MAX);
            let mut found = [f32::INFINITY; 4];
            let mut count = 0;
            for other in about.into_iter().flatten().filter_map(|at| grid[at]) {
                found[count] = distance(other);
                count += 1;
            }
            let found = &mut found[..count];
            found.sort_by(f32::total_cmp);
            spacing[own] = found.get(count.saturating_sub(1) / 2).copied().unwrap_or(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conray_core::{hash_u32, owen_sobol_2d};
    use proptest::prelude::*;

    /// Every valid point has a cell of its own in the image.
    fn check(points: &[SurfacePoint]) -> Scattered {
        let laid = Scattered::new(points);
        let mut taken = vec![false; laid.width * laid.height];
        for ((point, cell), spacing) in points.iter().zip(&laid.cell).zip(&laid.spacing) {
            assert_eq!(point.is_valid(), cell.is_some());
            assert!(*spacing >= 0.0 && spacing.is_finite());
            if let Some(cell) = *cell {
                assert!(!std::mem::replace(&mut taken[cell], true), "two points in one cell");
            }
        }
        laid
    }

    /// Points of a square, facing up or down, some of them on a second floor, in no order.
    fn floors(count: u32, dense: bool) -> Vec<SurfacePoint> {
        let point = |k: u32| {
            let at = owen_sobol_2d(k, 5);
            // Twenty times as many in one corner as in the other.
            let along = |x: f32| if dense { x.powi(3) } else { x };
            let floor = f32::from(u8::from(hash_u32(k).is_multiple_of(3)));
            SurfacePoint::new(Vec3::new(along(at.x), floor, along(at.y)), Vec3::Y)
        };
        let mut points: Vec<(u32, SurfacePoint)> =
            (0..count).map(|k| (hash_u32(k ^ 0xabcd), point(k))).collect();
        points.sort_by_key(|(key, _)| *key);
        points.into_iter().map(|(_, point)| point).collect()
    }

    /// Of points in cells side by side, the share that are on one floor and no farther than five times the nearest of all.
    fn near(points: &[SurfacePoint], laid: &Scattered) -> f64 {
        let mut grid = vec![None; laid.width * laid.height];
        laid.cell.iter().enumerate().for_each(|(index, cell)| grid[cell.unwrap()] = Some(index));
        let (mut near, mut all) = (0, 0);
        for (at, own) in grid.iter().enumerate().filter_map(|(at, own)| Some((at, (*own)?))) {
            let Some(&Some(other)) = grid.get(at + 1) else { continue };
            let own = points[own].position;
            let nearest = points.iter().map(|p| p.position.distance(own)).filter(|d| *d > 0.0);
            let nearest = nearest.fold(f32::INFINITY, f32::min);
            near += u32::from(points[other].position.distance(own) <= 5.0 * nearest);
            all += 1;
        }
        f64::from(near) / f64::from(all)
    }

    #[test]
    fn points_side_by_side_are_near() {
        for (dense, least) in [(false, 0.9), (true, 0.6)] {
            let points = floors(3000, dense);
            let laid = check(&points);
            assert!(laid.width * laid.height < 2 * points.len());
            let share = near(&points, &laid);
            assert!(share > least, "{share}");
            // Negative control: the order of the file.
            let cell = (0..points.len()).map(Some).collect();
            let as_told = Scattered { cell, ..laid };
            assert!(near(&points, &as_told) < 0.1);
        }
    }

    #[test]
    fn odd_shapes_take_little_room() {
        let line = |k: u32| SurfacePoint::new(Vec3::new(k as f32, 0.0, 0.0), Vec3::Y);
        let heap = |_: u32| SurfacePoint::new(Vec3::ONE, Vec3::Z);
        let stairs = |k: u32| SurfacePoint::new(Vec3::splat(k as f32), Vec3::X);
        for shape in [line, heap, stairs] {
            let points: Vec<SurfacePoint> = (0..5000).map(shape).collect();
            let laid = check(&points);
            assert!(laid.width * laid.height < 20 * points.len(), "{} x {}", laid.width, laid.height);
        }
        assert_eq!(check(&[]).height, 0);
    }

    proptest! {
        #[test]
        fn any_points_have_cells(found in prop::collection::vec(
            (any::<[f32; 3]>(), -1i8..2, -1i8..2, -1i8..2), 0..200)) {
            let point = |&(at, x, y, z): &([f32; 3], i8, i8, i8)| {
                SurfacePoint::new(Vec3::from_array(at), Vec3::new(x.into(), y.into(), z.into()))
            };
            check(&found.iter().map(point).collect::<Vec<_>>());
        }
    }
}
