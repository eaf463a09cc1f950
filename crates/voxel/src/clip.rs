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
    row: (i32, Polygon),
    column: (i32, Polygon),
}

impl CellClipper {
    /// `axes` says which coordinate of the cells changes slowest, and which fastest.
    pub(crate) fn new(corners: [DVec3; 3], axes: [usize; 3]) -> Self {
        let triangle = Polygon::triangle(corners);
        Self { axes, triangle, row: (i32::MIN, triangle), column: (i32::MIN, triangle) }
    }

    /// The piece of the triangle in the cell from `cell` to `cell + 1`.
    #[inline]
    pub(crate) fn in_cell(&mut self, cell: IVec3) -> Polygon {
        let [u, v, w] = self.axes;
        if self.row.0 != cell[u] {
            self.row = (cell[u], self.triangle);
            self.row.1.clip(u, f64::from(cell[u]));
            self.column.0 = i32::MIN;
        }
        if self.column.0 != cell[v] {
            self.column = (cell[v], self.row.1);
            self.column.1.clip(v, f64::from(cell[v]));
        }
        let mut piece = self.column.1;
        piece.clip(w, f64::from(cell[w]));
        piece
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

    /// Keeps what lies in `[low, low + 1)` on an axis.
    ///
    /// A cell owns its lower faces and not its upper ones, so that a triangle lying between two cells counts once.
    #[inline]
    pub(crate) fn clip(&mut self, axis: usize, low: f64) {
        let high = low + 1.0;
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for c in self.corners() {
            (least, most) = (least.min(c[axis]), most.max(c[axis]));
        }
        if least >= high || most < low {
            self.count = 0;
            return;
        }
        if least < low {
            self.cut(|c| c[axis] - low);
        }
        if most > high {
            self.cut(|c| high - c[axis]);
        }
    }

    /// Keeps the side where `distance` is not negative.
    #[inline]
    fn cut(&mut self, distance: impl Fn(DVec3) -> f64) {
        let (mut kept, mut count) = ([DVec3::ZERO; MOST], 0);
        let mut keep = |c: DVec3| {
            // A convex polygon gains one corner a cut; rounding could only repeat corners.
            if count < MOST {
                kept[count] = c;
                count += 1;
            }
        };
        for k in 0..self.count {
            let p = self.corners[k];
            let q = self.corners[if k + 1 == self.count { 0 } else { k + 1 }];
            let (dp, dq) = (distance(p), distance(q));
            if dp >= 0.0 {
                keep(p);
            }
            if (dp < 0.0) != (dq < 0.0) {
                keep(p + (q - p) * (dp / (dp - dq)));
            }
        }
        (self.corners, self.count) = (kept, count);
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
        let piece = CellClipper::new(corners, [0, 1, 2]).in_cell(IVec3::ZERO);
        assert_eq!(piece.corners().len(), 6);
        assert!((piece.area_vector().length() - 0.75 * 3f64.sqrt()).abs() < 1e-12);
        assert!((piece.middle() - 0.5).length() < 1e-12);
    }
}
