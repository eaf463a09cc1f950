//! Where the filters of sixteen samples lie on a level.

use super::lanes::{LANES, Lanes};
use crate::{level::Level, lookup::Slope, rows::Rows};
use fearless_simd::{Simd, f32x4, f32x16, prelude::*, u16x16, u32x16};
use glam::UVec3;

/// Sixteen filters, each over the nodes `place - 1` and `place` on every axis.
pub(super) struct Places<S: Simd> {
    /// By axis; from 0 to one more than the level's side.
    pub(super) place: [u32x16<S>; 3],
    /// How near the position is to the upper nodes, by axis.
    share: [f32x16<S>; 3],
    /// Bits of the positions whose filter reaches into the cube.
    pub(super) inside: u32,
}

impl<S: Simd> Places<S> {
    /// For positions in leaves, on level number `level`.
    #[inline(always)]
    pub(super) fn new(simd: S, at: &[f32x16<S>; 3], level: usize, side: u32) -> Self {
        let inverse = f32x16::splat(simd, 1.0 / (1u32 << level) as f32);
        let half = f32x16::splat(simd, 0.5);
        let (one, zero) = (f32x16::splat(simd, 1.0), f32x16::splat(simd, 0.0));
        let side = f32x16::splat(simd, side as f32);
        let (x, y, z) = (at[0] * inverse - half, at[1] * inverse - half, at[2] * inverse - half);
        let least = x.min(y).min(z).simd_ge(f32x16::splat(simd, -1.0)).to_bitmask();
        let most = x.max(y).max(z).simd_lt(side).to_bitmask();
        let last = side + one;
        let low_x = (x + one).max(zero).min(last).to_int::<u32x16<S>>();
        let low_y = (y + one).max(zero).min(last).to_int::<u32x16<S>>();
        let low_z = (z + one).max(zero).min(last).to_int::<u32x16<S>>();
        let share_x = x - (low_x.to_float::<f32x16<S>>() - one);
        let share_y = y - (low_y.to_float::<f32x16<S>>() - one);
        let share_z = z - (low_z.to_float::<f32x16<S>>() - one);
        Self {
            place: [low_x, low_y, low_z],
            share: [share_x, share_y, share_z],
            inside: (least & most) as u32,
        }
    }

    #[inline(always)]
    pub(super) fn stored(self) -> StoredPlaces {
        let mut stored = StoredPlaces {
            place: [Lanes([0; LANES]); 3],
            share: [Lanes([0.0; LANES]); 3],
            inside: self.inside,
        };
        self.place[0].store_slice(&mut stored.place[0].0);
        self.place[1].store_slice(&mut stored.place[1].0);
        self.place[2].store_slice(&mut stored.place[2].0);
        self.share[0].store_slice(&mut stored.share[0].0);
        self.share[1].store_slice(&mut stored.share[1].0);
        self.share[2].store_slice(&mut stored.share[2].0);
        stored
    }
}

/// The same, to be read one by one.
pub(super) struct StoredPlaces {
    place: [Lanes<u32>; 3],
    share: [Lanes<f32>; 3],
    inside: u32,
}

impl StoredPlaces {
    /// Those of some filters that meet an occupied node.
    #[inline(always)]
    pub(super) fn met_of(&self, nodes: &Level, filters: u32) -> u32 {
        let (mut met, mut left) = (0, filters & self.inside);
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let place = UVec3::new(self.place[0].0[lane], self.place[1].0[lane], self.place[2].0[lane]);
            met |= u32::from(!nodes.is_vacant(place.min(UVec3::splat(nodes.side)).as_ivec3())) << lane;
        }
        met
    }

    /// What one filter finds, in 65535ths and nodes: `Taps::interpolate`, in the same order.
    #[inline(always)]
    pub(super) fn slope<S: Simd>(&self, simd: S, lane: usize, nodes: &Level) -> Slope {
        if self.inside >> lane & 1 == 0 {
            return Slope::default();
        }
        let place = UVec3::new(self.place[0].0[lane], self.place[1].0[lane], self.place[2].0[lane]);
        let (x, y, z) = (self.share[0].0[lane], self.share[1].0[lane], self.share[2].0[lane]);
        let rows = Rows::new(nodes, place);
        let rows = u16x16::from_slice(simd, rows.0.as_flattened());
        let (low_z, high_z) = simd.widen_u16x16(rows);
        let (low_z, high_z) = (simd.cvt_f32_u32x8(low_z), simd.cvt_f32_u32x8(high_z));
        let by_z = high_z - low_z;
        let (low, high) = (low_z + by_z * z).split();
        let (low_by_z, high_by_z) = by_z.split();
        let by_y = high - low;
        let at = low + by_y * y;
        let by_z = low_by_z + (high_by_z - low_by_z) * y;
        Slope::along_x(array(at), array(by_y), array(by_z), x)
    }
}

#[inline(always)]
fn array<S: Simd>(v: f32x4<S>) -> [f32; 4] {
    v.into()
}
