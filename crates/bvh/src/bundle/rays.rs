//! The rays of a bundle, member by member.

use super::BUNDLE_RAYS;
use conray_core::Vec3;

/// Direction components are held at least this far from zero, so that reciprocals are finite. Over any distance within a
/// scene it moves a ray by less than the rounding of a coordinate.
const LEAST_COMPONENT: f32 = 1e-18;

/// Sixteen values side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f32; 16]);

/// Groups of sixteen rays in a bundle.
pub(crate) const GROUPS: usize = BUNDLE_RAYS / 16;

/// Up to 64 rays of one origin.
#[derive(Clone, Debug)]
pub(crate) struct Rays {
    pub(crate) origin: Vec3,
    /// Of the surface that the rays leave; zero for none.
    pub(crate) normal: Vec3,
    pub(crate) t_max: f32,
    /// A power of two that brings distances along the rays near 1; the triangle test multiplies lengths by it.
    pub(crate) unit: f32,
    /// By group, then axis.
    pub(crate) direction: [[Lanes; 3]; GROUPS],
    /// One over the direction.
    pub(crate) inverse: [[Lanes; 3]; GROUPS],
    /// The rays that there are.
    pub(crate) all: u64,
}

impl Rays {
    /// `None` where the rays are not of the kind that bundles are for: members that are not finite, directions off unit
    /// length, nothing to reach. Single rays know what to make of those.
    pub(crate) fn new(
        origin: Vec3,
        normal: Vec3,
        directions: &[Vec3],
        t_max: f32,
        reach: f32,
    ) -> Option<Self> {
        let usual = |d: &Vec3| (d.length_squared() - 1.0).abs() < 1e-3;
        let longest = t_max.min(reach);
        let usable = origin.is_finite()
            && normal.is_finite()
            && t_max > 0.0
            && (1e-30..=1e30).contains(&longest)
            && origin.abs().max_element() < 1e30
            && directions.iter().all(usual);
        if !usable {
            return None;
        }
        let zero = Lanes([0.0; 16]);
        let mut rays = Self {
            origin,
            normal,
            t_max,
            unit: power_of_two_below(1.0 / longest),
            direction: [[zero; 3]; GROUPS],
            inverse: [[zero; 3]; GROUPS],
            all: if directions.len() == 64 { !0 } else { (1 << directions.len()) - 1 },
        };
        for (index, direction) in directions.iter().enumerate() {
            let (group, lane) = (index / 16, index % 16);
            for axis in 0..3 {
                let d = direction[axis];
                let kept = if d.abs() < LEAST_COMPONENT { LEAST_COMPONENT.copysign(d) } else { d };
                rays.direction[group][axis].0[lane] = d;
                rays.inverse[group][axis].0[lane] = 1.0 / kept;
            }
        }
        Some(rays)
    }
}

/// The power of two at or below a positive normal number.
fn power_of_two_below(value: f32) -> f32 {
    f32::from_bits(value.to_bits() & 0x7f80_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_found() {
        for (value, expected) in [(1.0, 1.0), (3.9, 2.0), (0.3, 0.25), (1e-20, 2f32.powi(-67))] {
            assert_eq!(power_of_two_below(value), expected);
        }
    }

    #[test]
    fn odd_rays_are_left_to_others() {
        let make = |d: Vec3, t_max| Rays::new(Vec3::ZERO, Vec3::Z, &[d], t_max, 10.0);
        assert!(make(Vec3::Z, 1.0).is_some() && make(Vec3::Z, f32::INFINITY).is_some());
        for d in [Vec3::ZERO, Vec3::NAN, Vec3::splat(2.0)] {
            assert!(make(d, 1.0).is_none());
        }
        assert!(make(Vec3::Z, 0.0).is_none() && make(Vec3::Z, f32::NAN).is_none());
        assert_eq!(make(Vec3::Z, 1.0).unwrap().all, 1);
    }
}
