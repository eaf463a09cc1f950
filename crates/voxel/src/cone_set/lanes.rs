//! Sixteen cones side by side, and what all cones of a point share.

use conray_core::{Cone, Frame, Vec3};
use fearless_simd::{Simd, f32x16, prelude::*};

/// Cones side by side.
pub(super) use conray_core::LANES;

/// Sixteen values side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Lanes<T>(pub(super) [T; LANES]);

/// The numbers of the lanes whose bits are set.
pub(super) struct Bits(pub(super) u32);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize % LANES;
        let is_any = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        is_any.then_some(lane)
    }
}

/// Some vectors in memory, to be read one by one.
#[inline(always)]
pub(super) fn store<S: Simd, const N: usize>(vectors: &[f32x16<S>; N]) -> [Lanes<f32>; N] {
    let mut lanes = [Lanes([0.0; LANES]); N];
    for k in 0..N {
        vectors[k].store_slice(&mut lanes[k].0);
    }
    lanes
}

/// Three vectors from memory.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, [x, y, z]: &[Lanes<f32>; 3]) -> [f32x16<S>; 3] {
    [f32x16::from_slice(simd, &x.0), f32x16::from_slice(simd, &y.0), f32x16::from_slice(simd, &z.0)]
}

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
    /// For points that are not marched from.
    pub(super) const NOWHERE: Self = Self {
        apex: Vec3::ZERO,
        normal: Vec3::ZERO,
        frame: Frame { x: Vec3::ZERO, y: Vec3::ZERO, z: Vec3::ZERO },
    };

    /// `None` unless the apex is inside a cube of that side and all vectors are unit vectors.
    #[inline]
    pub(super) fn new(apex: Vec3, normal: Vec3, frame: Frame, side: f32) -> Option<Self> {
        let is_unit = |v: Vec3| (v.length_squared() - 1.0).abs() < 1e-3;
        let is_inside = apex.cmpge(Vec3::ZERO).all() && apex.cmple(Vec3::splat(side)).all();
        let are_units = is_unit(normal) && is_unit(frame.x) && is_unit(frame.y) && is_unit(frame.z);
        (is_inside && are_units).then_some(Self { apex, normal, frame })
    }
}
