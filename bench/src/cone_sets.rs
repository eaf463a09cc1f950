//! Sets of cones marched at surface points.

use crate::tiles;
use conray_core::{ConeSet, Falloff, Frame, HemisphereCones, SurfacePoint};
use conray_voxel::{ConeQuery, Octree};

/// Points of a tile: some tenths of a millisecond.
const TILE_POINTS: usize = 16;

/// The set of 16 cones, in an octree.
pub struct ConeSets<'a> {
    octree: &'a Octree,
    cones: HemisphereCones,
    distance: f32,
}

impl<'a> ConeSets<'a> {
    /// Cones of that length in world units.
    pub fn new(octree: &'a Octree, distance: f32) -> Self {
        Self { octree, cones: HemisphereCones::new(ConeSet::Sixteen), distance }
    }

    /// Visibility of a point by all cones of the set.
    pub fn visibility(&self, point: &SurfacePoint) -> f32 {
        let frame = Frame::from_normal(point.geometric_normal);
        let march = |cone: &conray_core::Cone| {
            let query = ConeQuery {
                apex: point.position,
                axis: frame.to_world(cone.axis),
                half_angle_rad: cone.half_angle_rad,
                normal: point.geometric_normal,
                distance: self.distance,
                falloff: Falloff::None,
            };
            cone.weight * self.octree.march(&query).visibility
        };
        self.cones.cones().iter().map(march).sum()
    }

    /// Seconds for the sets of all points on all threads, and their mean visibility.
    pub fn time(&self, points: &[SurfacePoint], rounds: usize) -> (f64, f64) {
        let tile = |points: &[SurfacePoint]| points.iter().map(|p| f64::from(self.visibility(p))).sum();
        let (seconds, sum) = tiles::time(points, TILE_POINTS, rounds, tile);
        (seconds, sum / points.len().max(1) as f64)
    }
}
