//! From triangles to leaves: exact emptiness and opacity.
//!
//! The grid is halved again and again, each half with the instances that may touch it, down to chunks of 4 x 4 x 4
//! bricks. One thread fills a chunk, triangle by triangle in a fixed order, so the result does not depend on threads.

use crate::{
    cells::TriangleCells,
    clusters::Clusters,
    coverage::{CoverageTriangle, MaskMeans},
    grid::Grid,
    level::{LeafBrick, cell_in_brick},
    marks::{BrickMarks, PlacedInstance},
    morton,
};
use conray_core::Geometry;
use glam::{DVec3, IVec3};

/// Leaves along a side of a chunk.
const CHUNK: u32 = 32;

/// Bytes that a thread needs to fill a chunk: three sums for each leaf.
pub(crate) const CHUNK_BYTES: u64 = 64 * 512 * 3 * size_of::<f32>() as u64;

/// Bytes for each instance in a list of those that may touch a part of the grid.
const LISTED_BYTES: u64 = size_of::<Listed>() as u64;

/// Three axis coverages of each leaf of a brick.
pub(crate) type AxisBrick = [[u8; 3]; 512];

/// An instance and its bounds in leaf units, rounded outward.
#[derive(Clone, Copy)]
struct Listed {
    instance: u32,
    min: [f32; 3],
    max: [f32; 3],
}

impl Listed {
    fn overlaps(&self, low: IVec3, high: IVec3) -> bool {
        (0..3).all(|k| self.min[k] <= high[k] as f32 && self.max[k] >= low[k] as f32)
    }
}

/// Bytes held at most by the lists: at each halving both halves may hold every instance, and each is shorter below.
pub(crate) fn list_bytes(geometry: &Geometry) -> u64 {
    4 * geometry.instances().len() as u64 * LISTED_BYTES
}

/// Fills the leaves of all marked bricks; `leaves` (and `axes`, unless empty) are in the order of the marks.
pub(crate) fn voxelise(
    geometry: &Geometry,
    clusters: &Clusters,
    grid: &Grid,
    marks: &BrickMarks,
    leaves: &mut [LeafBrick],
    axes: &mut [AxisBrick],
) {
    use rayon::prelude::*;
    let list = |i: usize| {
        let placed = PlacedInstance::new(geometry, clusters, grid, i);
        let (min, max) = clusters.of_mesh(placed.mesh).transformed_bounds(&placed.cells_from_mesh);
        // Half a leaf more than the most padding: rounding to single precision is far below it.
        let (min, max) = ((min - 1.0).as_vec3(), (max + 1.0).as_vec3());
        Listed { instance: i as u32, min: min.to_array(), max: max.to_array() }
    };
    let listed: Vec<Listed> = (0..geometry.instances().len()).into_par_iter().map(list).collect();
    let means = MaskMeans::new(geometry);
    Part { geometry, clusters, means: &means, grid, words: marks.words(), first: 0 }
        .fill(&listed, leaves, axes);
}

/// A power of two of chunks, consecutive in Morton order.
#[derive(Clone, Copy)]
struct Part<'a> {
    geometry: &'a Geometry,
    clusters: &'a Clusters,
    means: &'a MaskMeans,
    grid: &'a Grid,
    words: &'a [u64],
    first: u32,
}

impl Part<'_> {
    fn fill(self, listed: &[Listed], leaves: &mut [LeafBrick], axes: &mut [AxisBrick]) {
        if leaves.is_empty() || listed.is_empty() {
            return;
        }
        let (low, high) = self.bounds();
        let listed: Vec<Listed> = listed.iter().filter(|l| l.overlaps(low, high)).copied().collect();
        if self.words.len() == 1 {
            return self.fill_chunk(low, &listed, leaves, axes);
        }
        let (a, b) = self.words.split_at(self.words.len() / 2);
        let bricks: u32 = a.iter().map(|w| w.count_ones()).sum();
        let (leaves_a, leaves_b) = leaves.split_at_mut(bricks as usize);
        let (axes_a, axes_b) = axes.split_at_mut((bricks as usize).min(axes.len()));
        let (first_a, first_b) = (self.first, self.first + a.len() as u32);
        rayon::join(
            || Self { words: a, first: first_a, ..self }.fill(&listed, leaves_a, axes_a),
            || Self { words: b, first: first_b, ..self }.fill(&listed, leaves_b, axes_b),
        );
    }

    /// Lowest and highest corner in leaf units.
    fn bounds(&self) -> (IVec3, IVec3) {
        let corner = |word: u32| morton::decode(word).as_ivec3() * CHUNK as i32;
        let last = self.first + self.words.len() as u32 - 1;
        (corner(self.first), corner(last) + CHUNK as i32)
    }

    fn fill_chunk(self, low: IVec3, listed: &[Listed], leaves: &mut [LeafBrick], axes: &mut [AxisBrick]) {
        let mut sums = vec![[[0.0f32; 512]; 3]; leaves.len()];
        let (from, to) = (low.as_dvec3() - 1.0, (low + CHUNK as i32).as_dvec3() + 1.0);
        for l in listed {
            let placed = PlacedInstance::new(self.geometry, self.clusters, self.grid, l.instance as usize);
            let tree = self.clusters.of_mesh(placed.mesh);
            tree.overlapping(&placed.cells_from_mesh, from, to, &mut |group| {
                for &t in group {
                    let corners = placed.corners(self.geometry, t);
                    if is_near(corners, from, to) {
                        self.add(&placed, t, corners, low, leaves, &mut sums);
                    }
                }
            });
        }
        for (leaf, sums) in leaves.iter_mut().zip(&sums) {
            let opacity = |k: usize| sums[0][k].max(sums[1][k]).max(sums[2][k]);
            leaf.means = std::array::from_fn(|k| quantised(opacity(k)));
        }
        for (axes, sums) in axes.iter_mut().zip(&sums) {
            *axes = std::array::from_fn(|k| [sums[0][k], sums[1][k], sums[2][k]].map(quantised));
        }
    }

    /// Adds one triangle to the leaves of the chunk at `low`.
    fn add(
        &self,
        placed: &PlacedInstance,
        triangle: u32,
        corners: [DVec3; 3],
        low: IVec3,
        leaves: &mut [LeafBrick],
        sums: &mut [[[f32; 512]; 3]],
    ) {
        let cells = TriangleCells::new(corners, placed.pad);
        let mesh = placed.mesh as usize;
        let mut covering =
            CoverageTriangle::new(self.geometry, self.means, mesh, triangle as usize, corners, cells.axes());
        let last = IVec3::splat(CHUNK.min(self.grid.resolution) as i32 - 1);
        cells.for_each(low, low + last, |cell| {
            let local = (cell - low).as_uvec3();
            let bit = morton::encode(local / 8);
            debug_assert!(self.words[0] >> bit & 1 == 1, "the marks cover every leaf");
            if self.words[0] >> bit & 1 == 0 {
                return;
            }
            let brick = (self.words[0] & ((1 << bit) - 1)).count_ones() as usize;
            let index = cell_in_brick(local % 8);
            leaves[brick].occupied[index / 64] |= 1 << (index % 64);
            let covered = covering.in_cell(cell);
            for (sum, covered) in sums[brick].iter_mut().zip(covered.to_array()) {
                sum[index] += covered as f32;
            }
        });
    }
}

fn is_near(corners: [DVec3; 3], low: DVec3, high: DVec3) -> bool {
    let [p, q, r] = corners;
    p.min(q).min(r).cmple(high).all() && p.max(q).max(r).cmpge(low).all()
}

/// Opacity in 255ths, more than 1 held at 1.
fn quantised(opacity: f32) -> u8 {
    (opacity.min(1.0) * 255.0 + 0.5) as u8
}
