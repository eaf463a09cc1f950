//! Sets of cones marched at surface points.

use crate::tiles;
use conray_core::{ConeSet, Falloff, Frame, HemisphereCones, SurfacePoint};
use conray_voxel::{ConeMarch, ConeResult, MarchOptions, Octree};

/// Points of a tile: some tenths of a millisecond.
const TILE_POINTS: usize = 16;

/// Cones of the largest set.
const MOST_CONES: usize = 25;

/// A set of cones, prepared for an octree.
pub struct ConeSets<'a> {
    march: ConeMarch<'a>,
    cones: HemisphereCones,
}

impl<'a> ConeSets<'a> {
    /// Cones of that length in world units.
    pub fn new(octree: &'a Octree, set: ConeSet, distance: f32) -> Self {
        let cones = HemisphereCones::new(set);
        let march = octree.cone_march(&cones, distance, Falloff::None, &MarchOptions::default());
        Self { march, cones }
    }

    /// Visibility of a point by all cones of the set.
    pub fn visibility(&self, point: &SurfacePoint) -> f32 {
        let frame = Frame::from_normal(point.geometric_normal);
        let cones = self.cones.cones();
        let mut results = [ConeResult { visibility: 0.0, error: 0.0 }; MOST_CONES];
        self.march.march(point.position, point.geometric_normal, &frame, &mut results[..cones.len()]);
        cones.iter().zip(results).map(|(cone, result)| cone.weight * result.visibility).sum()
    }

    /// Seconds for the sets of all points on all threads, and their mean visibility.
    pub fn time(&self, points: &[SurfacePoint], rounds: usize) -> (f64, f64) {
        let tile = |points: &[SurfacePoint]| points.iter().map(|p| f64::from(self.visibility(p))).sum();
        let (seconds, sum) = tiles::time(points, TILE_POINTS, rounds, tile);
        (seconds, sum / points.len().max(1) as f64)
    }
}
