//! The piece of a triangle inside a cell.
//!
//! Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974.

use glam::{DVec3, IVec3};

/// A triangle clipped by six planes has at most nine corners.
const MOST: usize = 9;

/// Clips a triangle to cells that are visited row by row, sharing the work of a row and of a column.
pub(crate) struct CellClipper {
    axes: [usize; 3],
    triangle: Polygon,
    row: Part,
    column: Part,
    piece: Polygon,
}

/// What of a triangle lies between two planes across an axis.
struct Part {
    /// Where the lower plane is.
    low: i32,
    polygon: Polygon,
    /// Lowest and highest coordinate on the axis that is cut next.
    range: (f64, f64),
}

impl Part {
    fn new(polygon: Polygon, next: usize) -> Self {
        Self { low: i32::MIN, range: polygon.range(next), polygon }
    }

    /// Takes the part of a polygon, whose range on the axis is known, above a plane; `next` is the axis to be cut after.
    #[inline]
    fn take(&mut self, from: &Polygon, range: (f64, f64), (axis, low): (usize, i32), next: usize) {
        self.low = low;
        from.clip_into(axis, f64::from(low), range, &mut self.polygon);
        self.range = self.polygon.range(next);
    }
}

impl CellClipper {
    /// `axes` says which coordinate of the cells changes slowest, and which fastest.
    pub(crate) fn new(corners: [DVec3; 3], axes: [usize; 3]) -> Self {
        let triangle = Polygon::triangle(corners);
        let part = |next: usize| Part::new(triangle, next);
        Self { axes, triangle, row: part(axes[1]), column: part(axes[2]), piece: triangle }
    }

    /// The piece of the triangle in the cell from `cell` to `cell + 1`.
    #[inline]
    pub(crate) fn in_cell(&mut self, cell: IVec3) -> &Polygon {
        let [u, v, w] = self.axes;
        if self.row.low != cell[u] {
            self.row.take(&self.triangle, self.triangle.range(u), (u, cell[u]), v);
            self.column.low = i32::MIN;
        }
        if self.column.low != cell[v] {
            self.column.take(&self.row.polygon, self.row.range, (v, cell[v]), w);
        }
        let low = f64::from(cell[w]);
        let (least, most) = self.column.range;
        if least >= low && most <= low + 1.0 && least < low + 1.0 {
            return &self.column.polygon;
        }
        self.column.polygon.clip_into(w, low, (least, most), &mut self.piece);
        &self.piece
    }
}

/// A convex planar polygon of few corners.
#[derive(Clone, Copy)]
pub(crate) struct Polygon {
    corners: [DVec3; MOST],
    count: usize,
}

impl Polygon {
    /// The triangle itself.
    pub(crate) fn triangle(corners: [DVec3; 3]) -> Self {
        let mut all = [DVec3::ZERO; MOST];
        all[..3].copy_from_slice(&corners);
        Self { corners: all, count: 3 }
    }

    /// Lowest and highest coordinate on an axis; without corners infinite, and the lowest above.
    #[inline]
    fn range(&self, axis: usize) -> (f64, f64) {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for c in self.corners() {
            (least, most) = (least.min(c[axis]), most.max(c[axis]));
        }
        (least, most)
    }

    /// Puts into `out` what lies in `[low, low + 1)` on an axis on which the polygon's range is known.
    ///
    /// A cell owns its lower faces and not its upper ones, so that a triangle lying between two cells counts once.
    #[inline]
    fn clip_into(&self, axis: usize, low: f64, (least, most): (f64, f64), out: &mut Self) {
        let high = low + 1.0;
        if least >= high || most < low {
            out.count = 0;
            return;
        }
        match (least < low, most > high) {
            (false, false) => {
                out.count = self.count;
                out.corners[..self.count].copy_from_slice(self.corners());
            }
            (true, false) => self.cut_into(|c| c[axis] - low, out),
            (false, true) => self.cut_into(|c| high - c[axis], out),
            (true, true) => {
                let mut above = Self { corners: [DVec3::ZERO; MOST], count: 0 };
                self.cut_into(|c| c[axis] - low, &mut above);
                above.cut_into(|c| high - c[axis], out);
            }
        }
    }

    /// Puts into `out` the side where `distance` is not negative.
    #[inline]
    fn cut_into(&self, distance: impl Fn(DVec3) -> f64, out: &mut Self) {
        let mut count = 0;
        let mut keep = |c: DVec3| {
            // A convex polygon gains one corner a cut; rounding could only repeat corners.
            if count < MOST {
                out.corners[count] = c;
                count += 1;
            }
        };
        let corners = self.corners();
        let Some(&last) = corners.last() else {
            out.count = 0;
            return;
        };
        let (mut p, mut dp) = (last, distance(last));
        for &q in corners {
            let dq = distance(q);
            if (dp < 0.0) != (dq < 0.0) {
                keep(p + (q - p) * (dp / (dp - dq)));
            }
            if dq >= 0.0 {
                keep(q);
            }
            (p, dp) = (q, dq);
        }
        out.count = count;
    }

    /// Corners in order.
    pub(crate) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Normal times area.
    pub(crate) fn area_vector(&self) -> DVec3 {
        self.fan().map(|[a, b, c]| (b - a).cross(c - a)).sum::<DVec3>() * 0.5
    }

    /// Triangles about the first corner that make up the polygon.
    pub(crate) fn fan(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let c = self.corners();
        (1..c.len().max(2) - 1).map(move |k| [c[0], c[k], c[k + 1]])
    }

    /// Mean of the corners: a point inside.
    pub(crate) fn middle(&self) -> DVec3 {
        self.corners().iter().sum::<DVec3>() / self.count.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corner() -> impl Strategy<Value = DVec3> {
        let number = || prop_oneof![0.0f64..4.0, (0i32..=8).prop_map(|i| f64::from(i) * 0.5)];
        (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn pieces_add_up_to_the_triangle(p in corner(), q in corner(), r in corner()) {
            let whole = Polygon::triangle([p, q, r]).area_vector();
            let mut sum = DVec3::ZERO;
            let mut clipper = CellClipper::new([p, q, r], [2, 1, 0]);
            // One more layer than the corners reach: pieces on an upper face belong to the next cell.
            for i in 0..125 {
                let cell = IVec3::new(i % 5, i / 5 % 5, i / 25);
                let piece = clipper.in_cell(cell);
                for c in piece.corners() {
                    let local = *c - cell.as_dvec3();
                    prop_assert!(local.min_element() > -1e-12 && local.max_element() < 1.0 + 1e-12);
                }
                sum += piece.area_vector();
            }
            prop_assert!((sum - whole).length() < 1e-12 * (1.0 + whole.length()), "{sum} {whole}");
        }
    }

    #[test]
    fn the_hexagon_across_a_cell() {
        // The plane x + y + z = 3/2 cuts the unit cube in a regular hexagon of edge 1 / sqrt 2.
        let corners = [DVec3::new(-4.0, 1.5, 4.0), DVec3::new(4.0, -6.5, 4.0), DVec3::new(4.0, 1.5, -4.0)];
        let mut clipper = CellClipper::new(corners, [0, 1, 2]);
        let piece = clipper.in_cell(IVec3::ZERO);
        assert_eq!(piece.corners().len(), 6);
        assert!((piece.area_vector().length() - 0.75 * 3f64.sqrt()).abs() < 1e-12);
        assert!((piece.middle() - 0.5).length() < 1e-12);
    }
}
