//! Which bricks of leaves a geometry touches: one bit a brick, found before anything is allocated.

use crate::{
    cells::TriangleCells,
    clusters::{Clusters, placement_error},
    grid::Grid,
    morton,
};
use conray_core::Geometry;
use glam::{DAffine3, DVec3, IVec3, UVec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bricks of leaves that triangles touch, as bits in Morton order; a word is a cube of 4 x 4 x 4 bricks.
pub(crate) struct BrickMarks {
    words: Vec<u64>,
}

/// An instance's place on the grid, in leaf units.
pub(crate) struct PlacedInstance {
    pub(crate) mesh: u32,
    pub(crate) cells_from_mesh: DAffine3,
    /// How far cells are widened so that the rounding of other crates' positions cannot miss them.
    pub(crate) pad: f64,
}

/// Cells are widened by no more than this, wherever the scene lies.
const MOST_PAD: f64 = 0.5;

impl PlacedInstance {
    pub(crate) fn new(geometry: &Geometry, clusters: &Clusters, grid: &Grid, instance: usize) -> Self {
        let placement = &geometry.instances()[instance];
        let bounds = clusters.of_mesh(placement.mesh).bounds();
        let error = placement_error(&bounds, &placement.world_from_mesh) / f64::from(grid.voxel_size);
        Self {
            mesh: placement.mesh,
            cells_from_mesh: grid.cells_from_mesh(&placement.world_from_mesh),
            pad: error.min(MOST_PAD),
        }
    }

    /// A triangle's corners in leaf units.
    #[inline]
    pub(crate) fn corners(&self, geometry: &Geometry, triangle: u32) -> [DVec3; 3] {
        let corners = geometry.meshes()[self.mesh as usize].corners(triangle as usize);
        corners.map(|c| self.cells_from_mesh.transform_point3(c.as_dvec3()))
    }
}

impl BrickMarks {
    /// Marks every brick that a triangle touches, in parallel.
    pub(crate) fn new(geometry: &Geometry, clusters: &Clusters, grid: &Grid) -> Self {
        let side = grid.resolution / 8;
        let words: Vec<AtomicU64> =
            (0..side.pow(3).div_ceil(64)).into_par_iter().map(|_| AtomicU64::new(0)).collect();
        (0..geometry.instances().len()).into_par_iter().for_each(|i| {
            let placed = PlacedInstance::new(geometry, clusters, grid, i);
            clusters.of_mesh(placed.mesh).groups().for_each(|group| {
                group.iter().for_each(|&t| mark(placed.corners(geometry, t), placed.pad, side, &words));
            });
        });
        Self { words: words.into_iter().map(AtomicU64::into_inner).collect() }
    }

    /// The words, each of 64 bricks.
    pub(crate) fn words(&self) -> &[u64] {
        &self.words
    }

    /// Morton codes of the marked bricks, ascending.
    pub(crate) fn codes(&self) -> Vec<u32> {
        let bits = |(w, &word): (usize, &u64)| {
            (0..64).filter(move |b| word >> b & 1 == 1).map(move |b| w as u32 * 64 + b)
        };
        self.words.iter().enumerate().flat_map(bits).collect()
    }
}

fn mark(corners: [DVec3; 3], pad: f64, side: u32, words: &[AtomicU64]) {
    // Twice the leaves' own padding, so that rounding cannot put a leaf outside its brick.
    let cells = TriangleCells::new(corners.map(|c| c / 8.0), 2.0 * (pad + 1e-6) / 8.0);
    cells.for_each(IVec3::ZERO, IVec3::splat(side as i32 - 1), |brick| {
        let code = morton::encode(UVec3::new(brick.x as u32, brick.y as u32, brick.z as u32));
        let (word, bit) = (&words[code as usize / 64], 1u64 << (code % 64));
        // Most triangles find their bit set: a read is cheaper than a write that others wait for.
        if word.load(Ordering::Relaxed) & bit == 0 {
            word.fetch_or(bit, Ordering::Relaxed);
        }
    });
}
