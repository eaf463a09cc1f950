//! Which cells of a grid a triangle touches.
//!
//! The separating-axis test arranged so that most of it is solved for whole rows and columns of cells: Schwarz and
//! Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs", 2010, section 4; the full set of axes after
//! Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", 2001. Unlike theirs, every axis is tested against the
//! interval of all three corners, so triangles of no area (points and segments) need no case of their own.

use glam::{DVec3, IVec3};

/// A line through the grid in a plane of two axes: cells with `lo <= a i + b j <= hi` are not separated by it.
#[derive(Clone, Copy, Debug, Default)]
struct Strip {
    a: f64,
    b: f64,
    lo: f64,
    hi: f64,
}

impl Strip {
    /// The strip of an edge from `p` to `q` and the third corner `r`, widened by half a cell and the padding.
    fn new([p, q, r]: [[f64; 2]; 3], pad: f64) -> Self {
        let (a, b) = (p[1] - q[1], q[0] - p[0]);
        let (on_edge, opposite) = (a * p[0] + b * p[1], a * r[0] + b * r[1]);
        let pad = pad * (a.abs() + b.abs());
        let lo = on_edge.min(opposite) - a.max(0.0) - b.max(0.0) - pad;
        let hi = on_edge.max(opposite) - a.min(0.0) - b.min(0.0) + pad;
        Self { a, b, lo, hi }
    }

    #[inline]
    fn contains(&self, i: f64, j: f64) -> bool {
        let s = self.a * i + self.b * j;
        self.lo <= s && s <= self.hi
    }

    /// Narrows a range of `j` at a given `i` to where the strip lies.
    #[inline]
    fn narrow(&self, i: f64, range: &mut (f64, f64)) {
        let (lo, hi) = (self.lo - self.a * i, self.hi - self.a * i);
        if self.b > 0.0 {
            *range = (range.0.max(lo / self.b), range.1.min(hi / self.b));
        } else if self.b < 0.0 {
            *range = (range.0.max(hi / self.b), range.1.min(lo / self.b));
        } else if lo > 0.0 || hi < 0.0 {
            *range = (1.0, 0.0);
        }
    }
}

/// A triangle prepared for finding the cells that it touches; cell `c` is the cube from `c` to `c + 1`.
pub(crate) struct TriangleCells {
    min: IVec3,
    max: IVec3,
    /// Order of the axes: the last is the one along which columns run.
    axes: [usize; 3],
    /// Edges in the planes (u, v), (v, w) and (w, u).
    strips: [[Strip; 3]; 3],
    normal: DVec3,
    /// `n . c` lies between these where the triangle's plane meets cell `c`.
    plane: (f64, f64),
}

/// Cells are widened by this much, whatever the caller asks for: far above the rounding of double precision.
const MIN_PAD: f64 = 1e-6;

/// Slivers whose normal is shorter than this share of the square of their longest edge are tested without their
/// plane: its direction would be rounding, and the other axes still bound them.
const SLIVER: f64 = 1e-7;

impl TriangleCells {
    /// Prepares a triangle given in cell units; cells are widened by `pad` on every side.
    pub(crate) fn new(corners: [DVec3; 3], pad: f64) -> Self {
        let [p, q, r] = corners;
        let pad = pad + MIN_PAD;
        let low = p.min(q).min(r) - pad;
        let high = p.max(q).max(r) + pad;
        let (min, max) = (low.floor().as_ivec3(), high.floor().as_ivec3());
        let mut this = Self {
            min,
            max,
            axes: [0, 1, 2],
            strips: Default::default(),
            normal: DVec3::ZERO,
            plane: (f64::NEG_INFINITY, f64::INFINITY),
        };
        if min != max {
            this.prepare(corners, pad);
        }
        this
    }

    fn prepare(&mut self, corners: [DVec3; 3], pad: f64) {
        let [p, q, r] = corners;
        let normal = (q - p).cross(r - p);
        let size = normal.abs();
        let w = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        self.axes = [(w + 1) % 3, (w + 2) % 3, w];
        let [u, v, w] = self.axes;
        for (strips, (a, b)) in self.strips.iter_mut().zip([(u, v), (v, w), (w, u)]) {
            let flat = corners.map(|c| [c[a], c[b]]);
            for (k, strip) in strips.iter_mut().enumerate() {
                *strip = Strip::new([flat[k], flat[(k + 1) % 3], flat[(k + 2) % 3]], pad);
            }
        }
        let longest = (q - p).length_squared().max((r - q).length_squared()).max((p - r).length_squared());
        if size[w] > SLIVER * longest {
            self.normal = normal;
            let (at, pad) = (normal.dot(p), pad * size.element_sum());
            let above = normal.max(DVec3::ZERO).element_sum();
            let below = normal.min(DVec3::ZERO).element_sum();
            self.plane = (at - above - pad, at - below + pad);
        }
    }

    /// Order in which coordinates change from cell to cell: the first slowest.
    pub(crate) fn axes(&self) -> [usize; 3] {
        self.axes
    }

    /// Calls `visit` with each cell between `low` and `high`, both included, that the triangle touches.
    #[inline]
    pub(crate) fn for_each(&self, low: IVec3, high: IVec3, mut visit: impl FnMut(IVec3)) {
        let (min, max) = (self.min.max(low), self.max.min(high));
        if min.cmpgt(max).any() {
            return;
        }
        if self.min == self.max {
            return visit(min);
        }
        let [u, v, w] = self.axes;
        for i in min[u]..=max[u] {
            let i_cell = f64::from(i);
            let mut row = (f64::from(min[v]), f64::from(max[v]));
            self.strips[0].iter().for_each(|strip| strip.narrow(i_cell, &mut row));
            // Rounded outward by far less than the padding.
            let rows = (row.0 - 1e-9).ceil() as i32..=(row.1 + 1e-9).floor() as i32;
            for j in rows {
                let j_cell = f64::from(j);
                let mut column = (f64::from(min[w]), f64::from(max[w]));
                self.narrow_to_plane(i_cell, j_cell, &mut column);
                for k in (column.0 - 1e-9).ceil() as i32..=(column.1 + 1e-9).floor() as i32 {
                    let k_cell = f64::from(k);
                    let touched = self.strips[1].iter().all(|s| s.contains(j_cell, k_cell))
                        && self.strips[2].iter().all(|s| s.contains(k_cell, i_cell));
                    if touched {
                        let mut cell = IVec3::ZERO;
                        (cell[u], cell[v], cell[w]) = (i, j, k);
                        visit(cell);
                    }
                }
            }
        }
    }

    #[inline]
    fn narrow_to_plane(&self, i: f64, j: f64, range: &mut (f64, f64)) {
        let [u, v, w] = self.axes;
        let slope = self.normal[w];
        if slope == 0.0 {
            return;
        }
        let at = self.normal[u] * i + self.normal[v] * j;
        let (a, b) = ((self.plane.0 - at) / slope, (self.plane.1 - at) / slope);
        *range = (range.0.max(a.min(b)), range.1.min(a.max(b)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Distance in the largest-coordinate sense from a triangle to a cell, by clipping the triangle to the cell grown
    /// by more and more: an oracle without separating axes.
    fn is_touched(corners: [DVec3; 3], cell: IVec3, grow: f64) -> bool {
        let (low, high) = (cell.as_dvec3() - grow, cell.as_dvec3() + 1.0 + grow);
        let mut polygon = corners.to_vec();
        for axis in 0..3 {
            for (bound, sign) in [(low[axis], 1.0), (high[axis], -1.0)] {
                let inside = |p: DVec3| sign * (p[axis] - bound);
                let mut kept = Vec::new();
                for (k, &p) in polygon.iter().enumerate() {
                    let q = polygon[(k + 1) % polygon.len()];
                    let (dp, dq) = (inside(p), inside(q));
                    if dp >= 0.0 {
                        kept.push(p);
                    }
                    if dp * dq < 0.0 {
                        kept.push(p + (q - p) * (dp / (dp - dq)));
                    }
                }
                polygon = kept;
            }
        }
        !polygon.is_empty()
    }

    fn compare(corners: [DVec3; 3], pad: f64) {
        let cells = TriangleCells::new(corners, pad);
        let mut found = std::collections::HashSet::new();
        let (low, high) = (IVec3::ZERO, IVec3::splat(11));
        cells.for_each(low, high, |c| assert!(found.insert(c), "{c} twice"));
        for z in 0..12 {
            for y in 0..12 {
                for x in 0..12 {
                    let cell = IVec3::new(x, y, z);
                    let (inner, outer) =
                        (is_touched(corners, cell, pad), is_touched(corners, cell, pad + 1e-4));
                    let touched = found.contains(&cell);
                    assert!(touched || !inner, "{cell} is missed: {corners:?}");
                    assert!(!touched || outer, "{cell} is not touched: {corners:?}");
                }
            }
        }
    }

    fn corner() -> impl Strategy<Value = DVec3> {
        // Whole and half numbers put corners, edges and faces on cell boundaries.
        let number = || prop_oneof![-2.0f64..14.0, (-4i32..28).prop_map(|i| f64::from(i) * 0.5)];
        (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        #[test]
        fn cells_equal_those_of_exact_clipping(p in corner(), q in corner(), r in corner(), pad in 0.0f64..0.3) {
            compare([p, q, r], pad);
        }

        #[test]
        fn small_ones_and_slivers_too(p in corner(), d in corner(), e in corner(), scale in -6i32..0) {
            let s = 10f64.powi(scale);
            compare([p, p + d * s, p + e * s], 0.0);
            compare([p, p + d, p + d * (1.0 - s)], 0.0);
            compare([p, d, d], 0.0);
        }

        #[test]
        fn huge_ones_too(p in corner(), d in corner(), e in corner()) {
            compare([p - 200.0 * d, p + 100.0 * d - 150.0 * e, p + 170.0 * e], 0.0);
        }
    }

    #[test]
    fn a_diagonal_wall_misses_most_of_its_bounds() {
        let corners = [DVec3::ZERO, DVec3::new(12.0, 12.0, 0.0), DVec3::new(12.0, 12.0, 12.0)];
        let mut count = 0;
        TriangleCells::new(corners, 0.0).for_each(IVec3::ZERO, IVec3::splat(11), |_| count += 1);
        assert!((78..400).contains(&count), "{count} of 1728");
    }
}
