//! The march of sixteen cones that share their steps.

use super::{
    lanes::{Fan, LANES, Lanes, LocalAxes},
    passage::Passage,
    places::{Places, StoredPlaces},
    slopes::Slopes,
};
use crate::{ConeResult, Octree, filter_bits::BLOCK_WORDS, level::Level, steps::Step};
use conray_core::Vec3;
use fearless_simd::{Simd, f32x16, prelude::*, u32x16};
use std::hint::black_box;

/// Marches the cones; lanes without a cone are open.
#[inline(always)]
pub(super) fn march<S: Simd>(
    simd: S,
    octree: &Octree,
    steps: &[Step],
    fan: &Fan,
    axes: &LocalAxes,
) -> [ConeResult; LANES] {
    let paths = Paths::new(simd, fan, axes);
    let mut passage = Passage::open(simd);
    let mut active = axes.all;
    for (index, step) in steps.iter().enumerate() {
        let at = paths.at(simd, step);
        let coarse = step.coarse();
        let nodes = &octree.levels[coarse];
        let places = Places::new(simd, &at, coarse, nodes.side);
        let reachable = places.inside & active;
        if reachable == 0 {
            continue;
        }
        let met = met(simd, nodes, &places.place) & reachable;
        if met == 0 {
            continue;
        }
        let finer = &octree.levels[step.level];
        let fine_places = Places::new(simd, &at, step.level, finer.side).stored();
        // Where only the coarser filter meets something, the finer one has nothing to read.
        let met_by_finer = if step.share > 0.0 { fine_places.met_of(finer, met) } else { met };
        let mut slope = look_up(simd, &fine_places, finer, met_by_finer).in_leaves(simd, step.level);
        if step.share > 0.0 {
            let coarser = look_up(simd, &places.stored(), nodes, met).in_leaves(simd, coarse);
            slope = slope.lerp(simd, coarser, step.share);
        }
        active &= !passage.add(simd, index, step, &slope, &paths.axis, met);
        if active == 0 {
            break;
        }
    }
    passage.results(simd)
}

/// What the filters of some cones find on a level.
#[inline(always)]
fn look_up<S: Simd>(simd: S, places: &StoredPlaces, nodes: &Level, mut met: u32) -> Slopes {
    let mut slopes = Slopes::new();
    while met != 0 {
        let lane = met.trailing_zeros() as usize % LANES;
        met &= met - 1;
        slopes.set(lane, &places.slope(simd, lane, nodes));
    }
    slopes
}

/// The lines on which sixteen cones are sampled, in leaves.
struct Paths<S: Simd> {
    apex: [f32x16<S>; 3],
    normal: [f32x16<S>; 3],
    axis: [f32x16<S>; 3],
    /// Height over the tangent plane gained per length.
    rise: f32x16<S>,
}

impl<S: Simd> Paths<S> {
    #[inline(always)]
    fn new(simd: S, fan: &Fan, axes: &LocalAxes) -> Self {
        let apex = splat(simd, fan.apex);
        let normal = splat(simd, fan.normal);
        let (fx, fy, fz) = (splat(simd, fan.frame.x), splat(simd, fan.frame.y), splat(simd, fan.frame.z));
        let x = f32x16::from_slice(simd, &axes.components[0].0);
        let y = f32x16::from_slice(simd, &axes.components[1].0);
        let z = f32x16::from_slice(simd, &axes.components[2].0);
        // Products and sums apart, never fused, in the order of `Frame::to_world`: the same bits at every level.
        let axis_x = fx[0] * x + fy[0] * y + fz[0] * z;
        let axis_y = fx[1] * x + fy[1] * y + fz[1] * z;
        let axis_z = fx[2] * x + fy[2] * y + fz[2] * z;
        let rise = normal[0] * axis_x + normal[1] * axis_y + normal[2] * axis_z;
        Self { apex, normal, axis: [axis_x, axis_y, axis_z], rise }
    }

    /// Where the cones are sampled at a step: [`Step::position`], sixteen times.
    #[inline(always)]
    fn at(&self, simd: S, step: &Step) -> [f32x16<S>; 3] {
        let middle = f32x16::splat(simd, step.middle);
        let lift = (f32x16::splat(simd, step.lift) - middle * self.rise).max(f32x16::splat(simd, 0.0));
        [
            self.apex[0] + self.axis[0] * middle + self.normal[0] * lift,
            self.apex[1] + self.axis[1] * middle + self.normal[1] * lift,
            self.apex[2] + self.axis[2] * middle + self.normal[2] * lift,
        ]
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: Vec3) -> [f32x16<S>; 3] {
    [f32x16::splat(simd, v.x), f32x16::splat(simd, v.y), f32x16::splat(simd, v.z)]
}

/// Bits of the places at which the filter meets an occupied node.
#[inline(always)]
fn met<S: Simd>(simd: S, level: &Level, place: &[u32x16<S>; 3]) -> u32 {
    // Rounding may put a position just inside the cube one place too far; what is there is not missed by stepping back.
    let side = u32x16::splat(simd, level.side);
    let (x, y, z) = (place[0].min(side), place[1].min(side), place[2].min(side));
    let across = u32x16::splat(simd, level.table.across);
    let (one, three) = (u32x16::splat(simd, 1), u32x16::splat(simd, 3));
    let seven = u32x16::splat(simd, 7);
    let index = (((z >> 3) + one) * across + (y >> 3) + one) * across + (x >> 3) + one;
    let word = ((z & seven) << 1) + ((y >> 2) & one);
    let bit = ((y & three) << 3) | (x & seven);
    let (mut blocks, mut words) = (Lanes([0u32; LANES]), Lanes([0u32; LANES]));
    index.store_slice(&mut blocks.0);
    word.store_slice(&mut words.0);
    // Through memory, where sixteen reads find their places and leave their words at once: the compiler would take the
    // registers apart and put them together lane by lane, at more than twice the time.
    let (blocks, words) = (black_box(&blocks), black_box(&words));
    let mut found = Lanes([0u32; LANES]);
    for lane in 0..LANES {
        let number = level.table.numbers[blocks.0[lane] as usize] as usize;
        found.0[lane] = level.filter.blocks[number][words.0[lane] as usize % BLOCK_WORDS];
    }
    let set = (u32x16::from_slice(simd, &black_box(&found).0) >> bit) & one;
    set.simd_eq(one).to_bitmask() as u32
}
