//! The rays of a bundle, prepared for triangles and for boxes.

use super::directions::{Directions, GROUPS};
use crate::lanes::{Lanes, WIDTH, bits};
use conray_core::Vec3;
use fearless_simd::{Select, Simd, f32x16, prelude::*};

/// Direction components are held at least this far from zero, so that reciprocals are finite. Over any distance within a
/// scene it moves a ray by less than the rounding of a coordinate.
const LEAST_COMPONENT: f32 = 1e-18;

/// Scenes and distances within these lengths: products of any three neither overflow nor vanish.
const LENGTHS: std::ops::RangeInclusive<f32> = 1e-9..=1e9;

/// Grows squared distances: more than they are rounded.
const ROUNDING: f32 = 1e-5;

/// Up to 64 rays of one origin.
pub(super) struct Rays<'a> {
    pub(super) origin: Vec3,
    pub(super) t_max: f32,
    /// By group, then axis.
    pub(super) directions: &'a [[Lanes; 3]],
    /// The rays that there are.
    pub(super) all: u64,
    /// Rays that do not lead above the surface.
    pub(super) below: u64,
    /// For boxes in world space.
    pub(super) boxes: BoxRays,
}

/// The rays as boxes see them, in the space of the boxes.
pub(super) struct BoxRays {
    /// What lowest and highest planes are seen from. Apart where the origin is uncertain: then boxes grow.
    pub(super) low_origin: Vec3,
    pub(super) high_origin: Vec3,
    /// Of the surface that the rays leave; zero for none.
    pub(super) normal: Vec3,
    /// Boxes farther than the root of this are out of reach; finite.
    pub(super) farthest_squared: f32,
    pub(super) t_max: f32,
    /// One over the direction, by group, then axis.
    pub(super) inverse: [[Lanes; 3]; GROUPS],
    /// Rays of negative direction, by axis.
    pub(super) negative: [u64; 3],
}

impl<'a> Rays<'a> {
    /// `None` where the rays are not of the kind that bundles are for: members that are not finite, directions off unit
    /// length, nothing to reach. Single rays know what to make of those.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        simd: S,
        origin: Vec3,
        normal: Vec3,
        directions: &'a Directions,
        t_max: f32,
        reach: f32,
    ) -> Option<Self> {
        let longest = t_max.min(reach);
        let usable = origin.is_finite()
            && (normal.length_squared() - 1.0 < 1e-3)
            && t_max > 0.0
            && LENGTHS.contains(&longest)
            && origin.abs().max_element() <= *LENGTHS.end();
        if !usable {
            return None;
        }
        let (all, groups) = (directions.all(), &directions.groups[..directions.group_count()]);
        let (mut usual, mut above) = (0, 0);
        for (group, [x, y, z]) in groups.iter().enumerate() {
            let (x, y, z) = (x.load(simd), y.load(simd), z.load(simd));
            let off = (x * x + y * y + z * z - f32x16::splat(simd, 1.0)).abs();
            usual |= u64::from(bits(off.simd_lt(f32x16::splat(simd, 1e-3)))) << (WIDTH * group);
            // As `Vec3::dot` rounds it.
            let height = x * f32x16::splat(simd, normal.x)
                + y * f32x16::splat(simd, normal.y)
                + z * f32x16::splat(simd, normal.z);
            above |= u64::from(bits(height.simd_gt(f32x16::splat(simd, 0.0)))) << (WIDTH * group);
        }
        if all & !usual != 0 {
            return None;
        }
        let farthest_squared = (t_max * t_max * (1.0 + ROUNDING)).min(f32::MAX);
        Some(Self {
            origin,
            t_max,
            directions: groups,
            all,
            below: if normal == Vec3::ZERO { 0 } else { all & !above },
            boxes: BoxRays::new(simd, groups, [origin; 2], normal, farthest_squared, t_max),
        })
    }

    /// One of the directions.
    #[inline(always)]
    pub(super) fn direction(&self, index: usize) -> Vec3 {
        let group = &self.directions[index / WIDTH];
        Vec3::new(group[0].0[index % WIDTH], group[1].0[index % WIDTH], group[2].0[index % WIDTH])
    }
}

impl BoxRays {
    /// Rays from `[low, high]` origins; see the members.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        simd: S,
        directions: &[[Lanes; 3]],
        [low_origin, high_origin]: [Vec3; 2],
        normal: Vec3,
        farthest_squared: f32,
        t_max: f32,
    ) -> Self {
        let mut inverse = [[Lanes::ZERO; 3]; GROUPS];
        let mut negative = [0; 3];
        let least = f32x16::splat(simd, LEAST_COMPONENT);
        for (group, direction) in directions.iter().enumerate() {
            for axis in 0..3 {
                let d = direction[axis].load(simd);
                let kept = d.abs().simd_lt(least).select(least.copysign(d), d);
                inverse[group][axis] = Lanes::of(f32x16::splat(simd, 1.0) / kept);
                let below = kept.simd_lt(f32x16::splat(simd, 0.0));
                negative[axis] |= u64::from(bits(below)) << (WIDTH * group);
            }
        }
        Self { low_origin, high_origin, normal, farthest_squared, t_max, inverse, negative }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn odd_rays_are_left_to_others() {
        let make = |d: Vec3, t_max: f32| {
            let mut directions = Directions::new();
            directions.push(d);
            dispatch!(Level::new(), simd =>
                Rays::new(simd, Vec3::ZERO, Vec3::Z, &directions, t_max, 10.0).map(|r| (r.all, r.below)))
        };
        assert_eq!(make(Vec3::Z, 1.0), Some((1, 0)));
        assert_eq!(make(Vec3::X, f32::INFINITY), Some((1, 1)));
        for d in [Vec3::ZERO, Vec3::NAN, Vec3::splat(2.0)] {
            assert!(make(d, 1.0).is_none());
        }
        assert!(make(Vec3::Z, 0.0).is_none() && make(Vec3::Z, f32::NAN).is_none());
    }
}
