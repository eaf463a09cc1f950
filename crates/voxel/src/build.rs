//! Building an octree within a limit of memory.

use crate::{
    Octree, OctreeOptions, VoxelError,
    clusters::Clusters,
    coverage::MaskMeans,
    filter_bits::FilterBits,
    grid::Grid,
    level::{BrickTable, Bricks, LeafBrick, Level, NodeBrick},
    marks::BrickMarks,
    plain::PlainNodes,
    upward::{SUMS_BYTES, build_upper_levels, parent_codes},
    voxelise::{AxisBrick, CHUNK_BYTES, list_bytes, voxelise},
};
use conray_core::Geometry;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;

/// Threads that the estimate of memory allows for. A constant, so that a limit gives the same octree everywhere.
const THREADS: u64 = 16;

impl Octree {
    /// Builds the octree of a geometry, on the threads of rayon's current pool.
    ///
    /// Where a limit of memory is set, the resolution is halved until the build's peak fits; [`Octree::resolution`]
    /// tells the one used. Materials of constant opacity 0 are left out.
    ///
    /// # Errors
    /// A resolution outside its range, no triangles or all in one point, coordinates too large for single precision,
    /// or a limit that not even 16 voxels fit.
    pub fn build(geometry: &Geometry, options: &OctreeOptions) -> Result<Self, VoxelError> {
        options.validate()?;
        let clusters = Clusters::new(geometry);
        let mut resolution = options.resolution;
        loop {
            let plan = Plan::new(geometry, &clusters, resolution, options.directional)?;
            match options.max_memory_bytes {
                Some(limit) if plan.peak_bytes > limit => {
                    if resolution == OctreeOptions::MIN_RESOLUTION {
                        return Err(VoxelError::MemoryLimit { resolution, needed: plan.peak_bytes, limit });
                    }
                    resolution /= 2;
                }
                _ => return Ok(plan.carry_out(geometry, clusters, options.directional)),
            }
        }
    }

    /// Bytes that building at a resolution would hold at its peak, without the geometry itself; 0 where
    /// [`Octree::build`] would fail.
    ///
    /// Counts what is allocated: bricks, tables, sums and lists, exactly, with room for 16 threads; neither rounding by the
    /// allocator nor the stacks of threads. It costs a pass over all triangles, a fraction of the build.
    pub fn estimate_memory(geometry: &Geometry, resolution: u32) -> u64 {
        let options = OctreeOptions { resolution, ..Default::default() };
        let plan = options
            .validate()
            .and_then(|()| Plan::new(geometry, &Clusters::new(geometry), resolution, options.directional));
        plan.map_or(0, |plan| plan.peak_bytes)
    }
}

/// What will be built.
struct Plan {
    grid: Grid,
    marks: BrickMarks,
    /// Morton codes of the bricks of leaves.
    codes: Vec<u32>,
    peak_bytes: u64,
}

impl Plan {
    fn new(
        geometry: &Geometry,
        clusters: &Clusters,
        resolution: u32,
        directional: bool,
    ) -> Result<Self, VoxelError> {
        let (min, max) = bounds(geometry, clusters);
        let grid = Grid::around(min, max, resolution)?;
        let marks = BrickMarks::new(geometry, clusters, &grid);
        let codes = marks.codes();
        let peak_bytes = peak_bytes(geometry, clusters, &marks, &codes, resolution, directional);
        Ok(Self { grid, marks, codes, peak_bytes })
    }

    fn carry_out(self, geometry: &Geometry, clusters: Clusters, directional: bool) -> Octree {
        let Self { grid, marks, codes, peak_bytes } = self;
        let mut leaves = vec![LeafBrick::EMPTY; codes.len() + 1];
        let mut axes: Vec<AxisBrick> = vec![[[0; 3]; 512]; if directional { codes.len() } else { 0 }];
        voxelise(geometry, &clusters, &grid, &marks, &mut leaves[1..], &mut axes);
        drop((clusters, marks));
        let side = grid.resolution;
        let mut levels = vec![Level::new(side, codes, Bricks::Leaves(leaves), axes)];
        build_upper_levels(&mut levels);
        Octree { grid, levels, peak_bytes }
    }
}

/// World bounds of all that can occlude, in double precision.
fn bounds(geometry: &Geometry, clusters: &Clusters) -> (DVec3, DVec3) {
    let of_instance = |i: &conray_core::Instance| {
        let m = &i.world_from_mesh;
        let m = DAffine3 {
            matrix3: glam::DMat3::from_cols(
                m.matrix3.x_axis.as_dvec3(),
                m.matrix3.y_axis.as_dvec3(),
                m.matrix3.z_axis.as_dvec3(),
            ),
            translation: m.translation.as_dvec3(),
        };
        clusters.of_mesh(i.mesh).transformed_bounds(&m)
    };
    let nothing = || (DVec3::INFINITY, DVec3::NEG_INFINITY);
    // Minimum and maximum do not depend on the order.
    geometry.instances().par_iter().map(of_instance).reduce(nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The most that any stage of the build holds.
fn peak_bytes(
    geometry: &Geometry,
    clusters: &Clusters,
    marks: &BrickMarks,
    codes: &[u32],
    resolution: u32,
    directional: bool,
) -> u64 {
    let axes = if directional { size_of::<AxisBrick>() as u64 } else { 0 };
    let leaf_bricks = codes.len() as u64;
    // One brick more: the empty one.
    let leaves = (leaf_bricks + 1) * (size_of::<LeafBrick>() as u64 + axes);
    let chunks = (leaf_bricks * CHUNK_BYTES / 64).min(THREADS * CHUNK_BYTES);
    let shared = clusters.memory_bytes() + size_of_val(marks.words()) as u64 + 4 * leaf_bricks;
    let voxelise = shared + leaves + chunks + list_bytes(geometry) + MaskMeans::bytes_for(geometry);

    let (mut held, mut sums) = (leaves, 0);
    let (mut side, mut codes) = (resolution, codes.to_vec());
    for level in 0u32.. {
        held += 4 * codes.len() as u64 + BrickTable::bytes_for(side);
        held += FilterBits::bytes_for(side, &codes) + PlainNodes::bytes_for(side);
        if level > 0 {
            held += (codes.len() as u64 + 1) * (size_of::<NodeBrick>() as u64 + axes);
        }
        if level > 0 && level % 3 == 0 {
            sums += codes.len() as u64 * SUMS_BYTES;
        }
        if side == 1 {
            break;
        }
        (side, codes) = (side / 2, parent_codes(&codes));
    }
    // Sorting triangles holds a key beside each index.
    let sorting = 12 * geometry.stored_triangle_count() + clusters.memory_bytes();
    voxelise.max(held + sums).max(sorting)
}
