//! The hierarchy itself and what it says about itself.

use crate::blas::TriangleTree;
use crate::build::{self, BvhError};
use crate::top::TopLevel;
use conray_core::{Bounds, Geometry};
use fearless_simd::Level;
use std::sync::Arc;

/// Two-level bounding volume hierarchy over a [`Geometry`].
///
/// Meshes that are placed once (and small ones) lie flattened in one world-space tree; meshes placed several times
/// have a tree of their own in the mesh's space, under a top level over their placements. Queries see no difference:
/// triangles are always tested by their world-space corners, which are the same bits either way.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) flat: TriangleTree,
    /// Trees of instanced meshes.
    pub(crate) trees: Vec<TriangleTree>,
    pub(crate) top: TopLevel,
    /// Which SIMD instructions the queries use.
    pub(crate) level: Level,
    /// A length that no distance within the scene exceeds by much.
    pub(crate) reach: f32,
    stats: BvhStats,
}

/// What a hierarchy consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BvhStats {
    /// Nodes of all trees.
    pub nodes: u64,
    /// Levels of nodes on the longest way down, through the top level where there is one.
    pub levels: u32,
    /// Triangles stored, without those of fewer than three different corners or of no opacity.
    pub triangles: u64,
    /// Triangles that rays meet, counted in each placement.
    pub placed_triangles: u64,
    /// Packets of up to sixteen triangles.
    pub packets: u64,
    /// Placements that are not flattened.
    pub instances: u64,
    /// Bytes held, without the geometry.
    pub memory_bytes: u64,
}

impl Bvh {
    /// Builds the hierarchy, on rayon's current thread pool. The result does not depend on the number of threads.
    ///
    /// Triangles with two equal corners and those of materials without opacity are left out: they occlude nothing. An empty
    /// geometry makes an empty hierarchy, which blocks no ray.
    ///
    /// # Errors
    /// [`BvhError::TooMany`] above about 267 million triangles or instances, [`BvhError::Overflow`] where a transform
    /// takes a vertex beyond single precision.
    pub fn build(geometry: Arc<Geometry>) -> Result<Self, BvhError> {
        build::build(geometry)
    }

    pub(crate) fn from_levels(
        geometry: Arc<Geometry>,
        flat: TriangleTree,
        trees: Vec<TriangleTree>,
        top: TopLevel,
    ) -> Self {
        let mut stats = BvhStats {
            nodes: top.tree.nodes.len() as u64,
            levels: flat.tree.levels,
            instances: top.placed.len() as u64,
            memory_bytes: top.memory_bytes(),
            ..BvhStats::default()
        };
        for tree in trees.iter().chain([&flat]) {
            stats.nodes += tree.tree.nodes.len() as u64;
            stats.triangles += tree.triangles;
            stats.packets += tree.packets.len() as u64;
            stats.memory_bytes += tree.memory_bytes();
        }
        stats.placed_triangles = flat.triangles;
        for placed in &top.placed {
            let tree = &trees[placed.tree as usize];
            stats.placed_triangles += tree.triangles;
            stats.levels = stats.levels.max(top.tree.levels + tree.tree.levels);
        }
        let reach = flat.tree.bounds.union(top.tree.bounds).diagonal();
        Self { reach, geometry, flat, trees, top, level: Level::new(), stats }
    }

    /// The same hierarchy with queries at a level of SIMD of the caller's choice; at first it is the processor's best.
    /// Answers are the same bits at every level.
    pub fn at_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// The level of SIMD of the queries.
    pub fn level(&self) -> Level {
        self.level
    }

    /// What is searched.
    pub fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    /// Counts of nodes, triangles and bytes.
    pub fn stats(&self) -> BvhStats {
        self.stats
    }

    /// Bytes held, without the geometry.
    pub fn memory_bytes(&self) -> u64 {
        self.stats.memory_bytes
    }

    /// World box of everything that occludes; empty where nothing does. Around instanced meshes it may be a little
    /// larger than need be.
    pub fn bounds(&self) -> Bounds {
        self.flat.tree.bounds.union(self.top.tree.bounds)
    }
}
