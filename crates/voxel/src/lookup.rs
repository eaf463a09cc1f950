//! Filtered look-ups: trilinear within a level, linear between two.

use crate::{Octree, level::Level};
use conray_core::Vec3;
use glam::IVec3;

/// Opacity about a position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Mean opacity in [0, 1].
    pub mean: f32,
    /// Standard deviation of opacity in [0, 1/2].
    pub sd: f32,
}

/// A sample and how its mean changes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Slope {
    pub(crate) sample: Sample,
    /// Change of the mean along each axis, per leaf.
    pub(crate) gradient: Vec3,
}

impl Slope {
    fn lerp(self, other: Self, share: f32) -> Self {
        let lerp = |a: f32, b: f32| a + share * (b - a);
        let sample = Sample {
            mean: lerp(self.sample.mean, other.sample.mean),
            sd: lerp(self.sample.sd, other.sample.sd),
        };
        Self { sample, gradient: self.gradient.lerp(other.gradient, share) }
    }
}

/// The eight nodes about a position and how near it is to the upper ones, by axis.
pub(crate) struct Taps {
    low: IVec3,
    share: Vec3,
}

impl Taps {
    /// `position` in units of leaves; `None` where all eight lie outside the cube, or the position is NaN.
    #[inline]
    pub(crate) fn new(position: Vec3, level: usize, side: u32) -> Option<Self> {
        // Node centres lie at half-integers.
        let at = position * (1.0 / (1u32 << level) as f32) - 0.5;
        if !(at.cmpge(Vec3::NEG_ONE).all() && at.cmplt(Vec3::splat(side as f32)).all()) {
            return None;
        }
        // Not negative after adding 1, so truncation is the floor.
        let low = (at + 1.0).as_ivec3() - 1;
        Some(Self { low, share: at - low.as_vec3() })
    }

    /// True where all eight lie in one brick.
    #[inline]
    fn is_in_one_brick(&self, side: u32) -> bool {
        let last = IVec3::splat(side as i32 - 1);
        self.low.cmpge(IVec3::ZERO).all()
            && self.low.cmplt(last).all()
            && (self.low & 7).cmplt(IVec3::splat(7)).all()
    }

    /// Weight of tap `c`: bit k chooses the upper node on axis k.
    #[inline]
    fn weight(&self, c: usize) -> f32 {
        let on = |k: usize, share: f32| if c >> k & 1 == 1 { share } else { 1.0 - share };
        on(0, self.share.x) * on(1, self.share.y) * on(2, self.share.z)
    }

    /// Derivative of [`Taps::weight`] along each axis, per node.
    #[inline]
    fn slope(&self, c: usize) -> Vec3 {
        let on = |k: usize, share: f32| if c >> k & 1 == 1 { (share, 1.0) } else { (1.0 - share, -1.0) };
        let ((x, dx), (y, dy), (z, dz)) = (on(0, self.share.x), on(1, self.share.y), on(2, self.share.z));
        Vec3::new(dx * y * z, x * dy * z, x * y * dz)
    }

    #[inline]
    fn cell(&self, c: usize) -> IVec3 {
        self.low + IVec3::new(c as i32 & 1, c as i32 >> 1 & 1, c as i32 >> 2)
    }

    /// The lowest of the eight.
    pub(crate) fn low(&self) -> IVec3 {
        self.low
    }

    /// True where no triangle touches any of the eight.
    pub(crate) fn is_empty(&self, level: &Level) -> bool {
        let mut empty = true;
        self.for_each(level, |brick, index, _| empty &= !level.is_occupied(brick, index));
        empty
    }

    /// Calls `visit` with brick, index and number of each tap in a stored brick.
    #[inline]
    fn for_each(&self, level: &Level, mut visit: impl FnMut(u32, usize, usize)) {
        if self.is_in_one_brick(level.side) {
            let Some((brick, index)) = level.find(self.low.as_uvec3()) else { return };
            for c in 0..8 {
                visit(brick, index + (c & 1) + (c >> 1 & 1) * 8 + (c >> 2) * 64, c);
            }
            return;
        }
        let inside = IVec3::splat(level.side as i32);
        for c in 0..8 {
            let cell = self.cell(c);
            if cell.cmpge(IVec3::ZERO).all()
                && cell.cmplt(inside).all()
                && let Some((brick, index)) = level.find(cell.as_uvec3())
            {
                visit(brick, index, c);
            }
        }
    }
}

impl Octree {
    /// Opacity about a world position, with a filter about as wide as two nodes of `level`.
    ///
    /// `level` is held within the octree's levels and may be fractional; NaN counts as 0. The result at whole levels
    /// is trilinear between the centres of the eight nearest nodes, and linear between levels. A position that is
    /// not finite, or more than half a node outside the cube, gives zero.
    pub fn sample(&self, level: f32, position: Vec3) -> Sample {
        self.slope_leaf_units(level, self.leaf_units(position)).unwrap_or_default().sample
    }

    /// The same for a position in leaf units; `None` where no triangle touches any node in the filter's reach.
    #[inline]
    pub(crate) fn slope_leaf_units(&self, level: f32, position: Vec3) -> Option<Slope> {
        let (level, share) = self.split_level(level);
        if share > 0.0 {
            // The coarser filter holds the finer one: where it finds nothing, nothing is there.
            let coarse = self.trilinear(level + 1, position)?;
            Some(self.trilinear(level, position).unwrap_or_default().lerp(coarse, share))
        } else {
            self.trilinear(level, position)
        }
    }

    /// Opacity across x, y and z about a world position, filtered as in [`Octree::sample`]; zero unless the octree was built
    /// with [`crate::OctreeOptions::directional`].
    pub fn sample_axes(&self, level: f32, position: Vec3) -> Vec3 {
        self.axes_leaf_units(level, self.leaf_units(position))
    }

    /// The same for a position in leaf units.
    pub(crate) fn axes_leaf_units(&self, level: f32, position: Vec3) -> Vec3 {
        if !self.is_directional() {
            return Vec3::ZERO;
        }
        let (level, share) = self.split_level(level);
        let fine = self.trilinear_axes(level, position);
        if share > 0.0 { fine.lerp(self.trilinear_axes(level + 1, position), share) } else { fine }
    }

    /// Whole level and share of the next; the next exists where the share is above 0.
    #[inline]
    fn split_level(&self, level: f32) -> (usize, f32) {
        let level = level.max(0.0).min((self.levels.len() - 1) as f32);
        (level as usize, level.fract())
    }

    /// A world position in units of leaves from the cube's corner.
    #[inline]
    pub(crate) fn leaf_units(&self, position: Vec3) -> Vec3 {
        (position - self.grid.origin) / self.grid.voxel_size
    }

    /// `None` where no triangle touches any of the eight nodes.
    fn trilinear(&self, level: usize, position: Vec3) -> Option<Slope> {
        let nodes = &self.levels[level];
        let taps = Taps::new(position, level, nodes.side)?;
        let (mut slope, mut touched) = (Slope::default(), false);
        taps.for_each(nodes, |brick, index, c| {
            let (mean, sd) = nodes.mean_sd(brick, index);
            let weight = taps.weight(c);
            slope.sample.mean += weight * mean;
            slope.sample.sd += weight * sd;
            slope.gradient += taps.slope(c) * mean;
            touched |= nodes.is_occupied(brick, index);
        });
        slope.gradient *= 1.0 / (1u32 << level) as f32;
        touched.then_some(slope)
    }

    fn trilinear_axes(&self, level: usize, position: Vec3) -> Vec3 {
        let nodes = &self.levels[level];
        let mut opacities = Vec3::ZERO;
        if let Some(taps) = Taps::new(position, level, nodes.side) {
            taps.for_each(nodes, |brick, index, c| {
                opacities += taps.weight(c) * nodes.axis_opacities(brick, index);
            });
        }
        opacities
    }
}
