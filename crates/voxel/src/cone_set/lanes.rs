//! Sixteen cones side by side, and what all cones of a point share.

use conray_core::{Cone, Frame, Vec3};

/// Cones side by side.
pub(super) use conray_core::LANES;

/// Sixteen values side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Lanes<T>(pub(super) [T; LANES]);

/// Axes of up to sixteen cones about z, by axis of space.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalAxes {
    pub(super) components: [Lanes<f32>; 3],
    /// Bits of the cones that there are.
    pub(super) all: u32,
}

impl LocalAxes {
    /// The axes of 1 to 16 cones.
    pub(super) fn new(cones: &[Cone]) -> Self {
        let component =
            |k: usize| Lanes(std::array::from_fn(|lane| cones.get(lane).map_or(0.0, |c| c.axis[k])));
        Self { components: [0, 1, 2].map(component), all: u32::MAX >> (32 - cones.len()) }
    }

    /// The axis of one cone.
    pub(super) fn axis(&self, lane: usize) -> Vec3 {
        Vec3::from(std::array::from_fn(|k| self.components[k].0[lane]))
    }
}

/// What the cones of a point share.
pub(super) struct Fan {
    /// In leaves from the cube's corner.
    pub(super) apex: Vec3,
    pub(super) normal: Vec3,
    pub(super) frame: Frame,
}

impl Fan {
    /// `None` unless the apex is inside a cube of that side and all vectors are unit vectors.
    #[inline]
    pub(super) fn new(apex: Vec3, normal: Vec3, frame: Frame, side: f32) -> Option<Self> {
        let is_unit = |v: Vec3| (v.length_squared() - 1.0).abs() < 1e-3;
        let is_inside = apex.cmpge(Vec3::ZERO).all() && apex.cmple(Vec3::splat(side)).all();
        let are_units = is_unit(normal) && is_unit(frame.x) && is_unit(frame.y) && is_unit(frame.z);
        (is_inside && are_units).then_some(Self { apex, normal, frame })
    }
}
