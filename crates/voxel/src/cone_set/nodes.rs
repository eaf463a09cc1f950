//! The nodes about sixteen positions, and what lies between them.

use super::lanes::{Bits, LANES, Lanes, load};
use crate::{
    level::{Bricks, Level},
    lookup::Slope,
    rows::Rows,
};
use fearless_simd::{Simd, f32x16, prelude::*, u16x32, u32x16};
use glam::UVec3;

/// Slopes of sixteen samples, in opacities and leaves.
#[derive(Clone, Copy)]
pub(super) struct Slopes<S: Simd> {
    pub(super) mean: f32x16<S>,
    pub(super) sd: f32x16<S>,
    pub(super) gradient: [f32x16<S>; 3],
}

impl<S: Simd> Slopes<S> {
    /// [`Slope::lerp`], sixteen times.
    #[inline(always)]
    pub(super) fn lerp(self, other: Self, share: f32x16<S>) -> Self {
        let (a, b) = (&self.gradient, &other.gradient);
        Self {
            mean: self.mean + share * (other.mean - self.mean),
            sd: self.sd + share * (other.sd - self.sd),
            gradient: [
                a[0] + share * (b[0] - a[0]),
                a[1] + share * (b[1] - a[1]),
                a[2] + share * (b[2] - a[2]),
            ],
        }
    }
}

/// Sixteen filters on a level, each over the nodes `place - 1` and `place` on each axis.
///
/// Used in three passes, between which other filters take their turn: so no vector is read while its members are still on
/// their way to memory.
pub(super) struct Filters {
    /// From 0 to one more than the level's side, where there is nothing; by axis.
    place: [Lanes<u32>; 3],
    /// How near the position is to the upper nodes, by axis.
    share: [Lanes<f32>; 3],
    /// Where the brick's number is in the level's table, unless all nodes of the level are in one array.
    index: Lanes<u32>,
    /// Which node is the first, in its brick or in the array; meaningless for filters that reach into a second brick.
    first: Lanes<u32>,
    /// Bits of the filters that do.
    across: u32,
    /// The nodes, by row.
    rows: [Lanes<[u16; 4]>; 4],
}

impl Filters {
    pub(super) const fn new() -> Self {
        let zero = Lanes([0; LANES]);
        Self {
            place: [zero; 3],
            share: [Lanes([0.0; LANES]); 3],
            index: zero,
            first: zero,
            across: 0,
            rows: [Lanes([[0; 4]; LANES]); 4],
        }
    }

    /// First pass: where the nodes are. As [`crate::lookup::Taps::new`]; a position too far outside the cube gets a place where
    /// there is nothing. Positions are in nodes of the level that is `above` this one.
    #[inline(always)]
    pub(super) fn place<S: Simd>(&mut self, simd: S, level: &Level, at: &[f32x16<S>; 3], above: usize) {
        let nodes = f32x16::splat(simd, (1u32 << above) as f32);
        let half = f32x16::splat(simd, 0.5);
        let (x, y, z) = (at[0] * nodes + half, at[1] * nodes + half, at[2] * nodes + half);
        let last = f32x16::splat(simd, (level.side + 1) as f32);
        let least = x.min(y).min(z).simd_ge(f32x16::splat(simd, 0.0));
        let most = x.max(y).max(z).simd_lt(last);
        let outside = u32x16::splat(simd, level.side + 1);
        let px = (least & most).select(x.to_int::<u32x16<S>>(), outside).min(outside);
        let py = y.to_int::<u32x16<S>>().min(outside);
        let pz = z.to_int::<u32x16<S>>().min(outside);
        (x - px.to_float::<f32x16<S>>()).store_slice(&mut self.share[0].0);
        (y - py.to_float::<f32x16<S>>()).store_slice(&mut self.share[1].0);
        (z - pz.to_float::<f32x16<S>>()).store_slice(&mut self.share[2].0);
        if let Some(plain) = &level.plain {
            let across = u32x16::splat(simd, plain.across);
            ((pz * across + py) * across + px).store_slice(&mut self.first.0);
            return;
        }
        let (zero, seven) = (u32x16::splat(simd, 0), u32x16::splat(simd, 7));
        let across = u32x16::splat(simd, level.table.across);
        let first = u32x16::splat(simd, level.table.index(UVec3::ZERO) as u32);
        let index = ((pz >> 3) * across + (py >> 3)) * across + (px >> 3) + first;
        index.store_slice(&mut self.index.0);
        let (local_x, local_y, local_z) = (px & seven, py & seven, pz & seven);
        let first = (((local_z << 3) + local_y) << 3) + local_x - u32x16::splat(simd, 1 + 8 + 64);
        first.store_slice(&mut self.first.0);
        self.across = local_x.min(local_y).min(local_z).simd_eq(zero).to_bitmask() as u32;
        px.store_slice(&mut self.place[0].0);
        py.store_slice(&mut self.place[1].0);
        pz.store_slice(&mut self.place[2].0);
    }

    /// Second pass: reads the nodes of the first `count` filters.
    #[inline(always)]
    pub(super) fn read(&mut self, level: &Level, count: usize) {
        if let Some(plain) = &level.plain {
            for lane in 0..count.min(LANES) {
                self.set(lane, plain.rows(self.first.0[lane] as usize));
            }
            return;
        }
        // One loop for each kind of filter, in place of a branch that nobody can foresee.
        let all = (1 << count) - 1;
        match &level.bricks {
            Bricks::Leaves(leaves) => {
                for lane in Bits(!self.across & all) {
                    let brick = level.stored(self.index.0[lane] as usize);
                    self.set(lane, Rows::of_leaves(&leaves[brick].means, self.first.0[lane] as usize));
                }
            }
            Bricks::Nodes(nodes) => {
                for lane in Bits(!self.across & all) {
                    let brick = level.stored(self.index.0[lane] as usize);
                    self.set(lane, Rows::of_nodes(&nodes[brick].moments, self.first.0[lane] as usize));
                }
            }
        }
        for lane in Bits(self.across & all) {
            let [x, y, z] = &self.place;
            self.set(lane, Rows::across(level, UVec3::new(x.0[lane], y.0[lane], z.0[lane])));
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, Rows(rows): Rows) {
        for (all, row) in self.rows.iter_mut().zip(rows) {
            all.0[lane] = row;
        }
    }

    /// Third pass: what lies between the nodes; [`crate::lookup::Taps::interpolate`] and [`Slope::in_leaves`], sixteen times and
    /// in the same order.
    #[inline(always)]
    pub(super) fn slopes<S: Simd>(&self, simd: S, number: usize) -> Slopes<S> {
        let [x, y, z] = load(simd, &self.share);
        let (m0, s0, m1, s1) = self.ends(simd, 0);
        let (m2, s2, m3, s3) = self.ends(simd, 1);
        let (m4, s4, m5, s5) = self.ends(simd, 2);
        let (m6, s6, m7, s7) = self.ends(simd, 3);
        let (m0, m1) = (Face::new([m0, m2, m4, m6], y, z), Face::new([m1, m3, m5, m7], y, z));
        let (s0, s1) = (Face::new([s0, s2, s4, s6], y, z), Face::new([s1, s3, s5, s7], y, z));
        let by_x = m1.at - m0.at;
        let unit = f32x16::splat(simd, Slope::UNIT);
        let gradient_unit = f32x16::splat(simd, Slope::gradient_unit(number));
        Slopes {
            mean: (m0.at + by_x * x) * unit,
            sd: (s0.at + (s1.at - s0.at) * x) * unit,
            gradient: [
                by_x * gradient_unit,
                (m0.by_y + (m1.by_y - m0.by_y) * x) * gradient_unit,
                (m0.by_z + (m1.by_z - m0.by_z) * x) * gradient_unit,
            ],
        }
    }

    /// Mean and SD at the lower end of a row, and at the upper end.
    #[inline(always)]
    fn ends<S: Simd>(&self, simd: S, row: usize) -> (f32x16<S>, f32x16<S>, f32x16<S>, f32x16<S>) {
        let (first, last) = self.rows[row].0.as_flattened().split_at(2 * LANES);
        let first: u32x16<S> = u16x32::from_slice(simd, first).bitcast();
        let last: u32x16<S> = u16x32::from_slice(simd, last).bitcast();
        let (low, high) = first.deinterleave(last);
        let low_half = u32x16::splat(simd, 0xffff);
        let (low_mean, low_sd) =
            ((low & low_half).to_float::<f32x16<S>>(), (low >> 16).to_float::<f32x16<S>>());
        let (high_mean, high_sd) =
            ((high & low_half).to_float::<f32x16<S>>(), (high >> 16).to_float::<f32x16<S>>());
        (low_mean, low_sd, high_mean, high_sd)
    }
}

/// A value on one face across x of the eight nodes, and its changes.
struct Face<S: Simd> {
    at: f32x16<S>,
    by_y: f32x16<S>,
    by_z: f32x16<S>,
}

impl<S: Simd> Face<S> {
    /// From the four nodes, y fastest: along z, then y.
    #[inline(always)]
    fn new(nodes: [f32x16<S>; 4], y: f32x16<S>, z: f32x16<S>) -> Self {
        let (low_by_z, high_by_z) = (nodes[2] - nodes[0], nodes[3] - nodes[1]);
        let (low, high) = (nodes[0] + low_by_z * z, nodes[1] + high_by_z * z);
        let by_y = high - low;
        Self { at: low + by_y * y, by_y, by_z: low_by_z + (high_by_z - low_by_z) * y }
    }
}
