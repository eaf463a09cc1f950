//! Sets of cones marched at surface points.

use crate::tiles;
use conray_core::{Cone, ConeSet, Falloff, HemisphereCones, SurfacePoint};
use conray_voxel::{ConeMarch, ConePoint, ConeResult, MarchOptions, Octree};

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

    /// Sum of the visibilities of some points, each by all cones of the set.
    pub fn visibility(&self, points: &[SurfacePoint]) -> f64 {
        let cones = self.cones.cones();
        let mut results = [ConeResult { visibility: 0.0, error: 0.0 }; TILE_POINTS * MOST_CONES];
        let mut sum = 0.0;
        for points in points.chunks(TILE_POINTS) {
            let results = &mut results[..points.len() * cones.len()];
            let set: Vec<_> = points.iter().map(at).collect();
            self.march.march(&set, results);
            for results in results.chunks(cones.len()) {
                let one = |(cone, result): (&Cone, &ConeResult)| cone.weight * result.visibility;
                sum += f64::from(cones.iter().zip(results).map(one).sum::<f32>());
            }
        }
        sum
    }

    /// Seconds for the sets of all points on all threads, and their mean visibility.
    pub fn time(&self, points: &[SurfacePoint], rounds: usize) -> (f64, f64) {
        let (seconds, sum) = tiles::time(points, TILE_POINTS, rounds, |points| self.visibility(points));
        (seconds, sum / points.len().max(1) as f64)
    }
}

/// The cones of a point, about its geometric normal.
fn at(point: &SurfacePoint) -> ConePoint {
    ConePoint::about(point.geometric_normal, point.position, point.geometric_normal)
}
