//! Leaving out look-ups in empty space.

use crate::{Octree, lookup::Taps};
use conray_core::Vec3;

/// How many levels coarser than the samples empty space is looked for.
const COARSER: usize = 3;

/// A box in leaf units that no triangle touches.
pub(crate) struct EmptyBlock {
    low: Vec3,
    high: Vec3,
}

impl EmptyBlock {
    /// Holds nothing.
    pub(crate) const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// True where a sample's filter lies in the box: it reaches 1.5 nodes of the coarser of its two levels.
    #[inline]
    pub(crate) fn holds(&self, position: Vec3, level: f32) -> bool {
        let reach = Vec3::splat(1.5 * (1u32 << (level.ceil() as u32)) as f32);
        (position - reach).cmpge(self.low).all() && (position + reach).cmple(self.high).all()
    }
}

impl Octree {
    /// The eight nodes nearest to a position some levels above `level`, if no triangle touches them.
    pub(crate) fn empty_block(&self, position: Vec3, level: f32) -> EmptyBlock {
        let level = (level.ceil() as usize + COARSER).min(self.levels.len() - 1);
        let nodes = &self.levels[level];
        let Some(taps) = Taps::new(position, level, nodes.side) else { return EmptyBlock::NONE };
        if !taps.is_empty(nodes) {
            return EmptyBlock::NONE;
        }
        let edge = (1u32 << level) as f32;
        let low = taps.low().as_vec3() * edge;
        EmptyBlock { low, high: low + 2.0 * edge }
    }
}

#[cfg(test)]
mod tests {
    use crate::{ConeQuery, MarchOptions, Octree, OctreeOptions};
    use conray_core::{Affine3A, Falloff, Geometry, TriangleMesh, Vec3, hash_u32};

    fn random(i: u32) -> f32 {
        hash_u32(i) as f32 / u32::MAX as f32
    }

    fn vector(i: u32) -> Vec3 {
        Vec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2))
    }

    #[test]
    fn skipping_changes_no_bit() {
        // A few small triangles far apart: mostly empty space.
        let corners = (0..60).map(|i| vector(i / 3) + 0.03 * vector(100 + i)).collect();
        let triangles = (0..20).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(TriangleMesh::new(corners, triangles).unwrap()).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        let octree =
            Octree::build(&geometry, &OctreeOptions { resolution: 128, ..Default::default() }).unwrap();
        let (mut open, mut closed) = (0, 0);
        for i in 0..2000 {
            let axis = (vector(1000 + 3 * i) - 0.5).normalize();
            let query = ConeQuery {
                apex: vector(1001 + 3 * i),
                axis,
                half_angle_rad: 0.5 * random(5000 + i),
                normal: axis,
                distance: f32::INFINITY,
                falloff: Falloff::None,
            };
            let options = MarchOptions::default();
            let (with, without) =
                (octree.march_by(&query, &options, true), octree.march_by(&query, &options, false));
            assert_eq!(with, without, "{query:?}");
            if with.visibility == 1.0 {
                open += 1;
            } else {
                closed += 1;
            }
        }
        assert!(open > 100 && closed > 100, "{open} open, {closed} not");
    }
}
