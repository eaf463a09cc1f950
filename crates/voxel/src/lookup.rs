//! Filtered look-ups: trilinear within a level, linear between two.

use crate::{Octree, level::Level, rows::Rows};
use conray_core::Vec3;
use glam::{IVec3, Vec4};

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
    /// The last step of an interpolation: along x, between mean and SD at the lower and at the upper end of a row, and
    /// between their changes along y and z.
    #[inline(always)]
    pub(crate) fn along_x(at: [f32; 4], by_y: [f32; 4], by_z: [f32; 4], x: f32) -> Self {
        let by_x = at[2] - at[0];
        let sample = Sample { mean: at[0] + by_x * x, sd: at[1] + (at[3] - at[1]) * x };
        let gradient = Vec3::new(by_x, by_y[0] + (by_y[2] - by_y[0]) * x, by_z[0] + (by_z[2] - by_z[0]) * x);
        Self { sample, gradient }
    }

    /// From 65535ths and nodes of a level to opacities and leaves.
    #[inline(always)]
    pub(crate) fn in_leaves(self, level: usize) -> Self {
        let sample = Sample { mean: self.sample.mean * Self::UNIT, sd: self.sample.sd * Self::UNIT };
        Self { sample, gradient: self.gradient * Self::gradient_unit(level) }
    }

    /// What opacities are stored in.
    pub(crate) const UNIT: f32 = 1.0 / 65535.0;

    /// The same by the edge of a level's nodes.
    #[inline(always)]
    pub(crate) fn gradient_unit(level: usize) -> f32 {
        Self::UNIT / (1u32 << level) as f32
    }

    #[inline(always)]
    fn lerp(self, other: Self, share: f32) -> Self {
        let lerp = |a: f32, b: f32| a + share * (b - a);
        let sample = Sample {
            mean: lerp(self.sample.mean, other.sample.mean),
            sd: lerp(self.sample.sd, other.sample.sd),
        };
        Self { sample, gradient: self.gradient + share * (other.gradient - self.gradient) }
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
        // Node centres lie at half-integers: this is the upper node's number where it is whole.
        let place = position * (1.0 / (1u32 << level) as f32) + 0.5;
        if !(place.cmpge(Vec3::ZERO).all() && place.cmplt(Vec3::splat((side + 1) as f32)).all()) {
            return None;
        }
        // Not negative, so truncation is the floor.
        let high = place.as_ivec3();
        Some(Self { low: high - 1, share: place - high.as_vec3() })
    }

    /// Weight of tap `c`: bit k chooses the upper node on axis k.
    #[inline]
    fn weight(&self, c: usize) -> f32 {
        let on = |k: usize, share: f32| if c >> k & 1 == 1 { share } else { 1.0 - share };
        on(0, self.share.x) * on(1, self.share.y) * on(2, self.share.z)
    }

    #[inline]
    fn cell(&self, c: usize) -> IVec3 {
        self.low + IVec3::new(c as i32 & 1, c as i32 >> 1 & 1, c as i32 >> 2)
    }

    /// True where no triangle touches any of the eight.
    #[inline]
    pub(crate) fn is_vacant(&self, level: &Level) -> bool {
        level.is_vacant(self.low + 1)
    }

    /// Mean and SD of the eight, interpolated, and the change of the mean along each axis per node; all in 65535ths.
    #[inline]
    fn interpolate(&self, level: &Level) -> Slope {
        let rows = Rows::new(level, (self.low + 1).as_uvec3()).0.map(|row| Vec4::from(row.map(f32::from)));
        let [x, y, z] = self.share.to_array();
        // Along z, then y, for both ends of the rows at once; each keeps the differences.
        let (low_by_z, high_by_z) = (rows[2] - rows[0], rows[3] - rows[1]);
        let (low, high) = (rows[0] + low_by_z * z, rows[1] + high_by_z * z);
        let by_y = high - low;
        let (at, by_z) = (low + by_y * y, low_by_z + (high_by_z - low_by_z) * y);
        Slope::along_x(at.to_array(), by_y.to_array(), by_z.to_array(), x)
    }

    /// Calls `visit` with brick number, index and number of each tap in a stored brick.
    #[inline]
    fn for_each(&self, level: &Level, mut visit: impl FnMut(u32, usize, usize)) {
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
        let (level, share) = self.split_level(level);
        self.slope_leaf_units(level, share, self.leaf_units(position)).sample
    }

    /// The same for a position in leaf units, with weight `share` on the level above.
    #[inline]
    pub(crate) fn slope_leaf_units(&self, level: usize, share: f32, position: Vec3) -> Slope {
        let fine = self.trilinear(level, position);
        if share > 0.0 { fine.lerp(self.trilinear(level + 1, position), share) } else { fine }
    }

    /// Opacity across x, y and z about a world position, filtered as in [`Octree::sample`]; zero unless the octree was built
    /// with [`crate::OctreeOptions::directional`].
    pub fn sample_axes(&self, level: f32, position: Vec3) -> Vec3 {
        let (level, share) = self.split_level(level);
        self.axes_leaf_units(level, share, self.leaf_units(position))
    }

    /// The same for a position in leaf units.
    pub(crate) fn axes_leaf_units(&self, level: usize, share: f32, position: Vec3) -> Vec3 {
        if !self.is_directional() {
            return Vec3::ZERO;
        }
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

    #[inline]
    fn trilinear(&self, level: usize, position: Vec3) -> Slope {
        let nodes = &self.levels[level];
        let Some(taps) = Taps::new(position, level, nodes.side) else { return Slope::default() };
        taps.interpolate(nodes).in_leaves(level)
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
