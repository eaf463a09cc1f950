//! Sixteen numbers side by side: what nodes, packets and bundles are made of, and how they come into registers.

use fearless_simd::{Simd, f32x16, prelude::*};

/// Children of a node, triangles of a packet, rays of a group.
pub(crate) const WIDTH: usize = conray_core::LANES;

/// Sixteen values, a cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Lanes(pub(crate) [f32; WIDTH]);

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; WIDTH]);

    /// Into a register.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::simd_from(simd, self.0)
    }

    /// Out of a register.
    #[inline(always)]
    pub(crate) fn of<S: Simd>(value: f32x16<S>) -> Self {
        Self(value.into())
    }
}

/// The lanes of a mask as bits.
#[inline(always)]
pub(crate) fn bits<S: Simd>(mask: fearless_simd::mask32x16<S>) -> u32 {
    mask.to_bitmask() as u32
}
