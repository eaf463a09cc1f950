//! Orthonormal frames.

use crate::Vec3;

/// A right-handed orthonormal frame whose third axis is a normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// The normal.
    pub z: Vec3,
}

impl Frame {
    /// A frame about a unit normal, without branches on its direction.
    ///
    /// Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin, "Building an Orthonormal Basis, Revisited", 2017.
    #[inline]
    pub fn from_normal(z: Vec3) -> Self {
        let sign = 1.0_f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// Takes a direction from the frame's coordinates to world space.
    #[inline]
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }

    /// Takes a direction from world space to the frame's coordinates.
    #[inline]
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(world), self.y.dot(world), self.z.dot(world))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn frames_are_orthonormal_and_right_handed(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0) {
            prop_assume!(Vec3::new(x, y, z).length() > 1e-3);
            let f = Frame::from_normal(Vec3::new(x, y, z).normalize());
            for (a, b) in [(f.x, f.y), (f.y, f.z), (f.z, f.x)] {
                prop_assert!(a.dot(b).abs() < 1e-5);
            }
            prop_assert!((f.x.cross(f.y) - f.z).length() < 1e-5);
            let v = Vec3::new(0.3, -0.5, 0.7);
            prop_assert!((f.to_local(f.to_world(v)) - v).length() < 1e-5);
        }
    }

    #[test]
    fn poles_have_frames_too() {
        for z in [Vec3::Z, Vec3::NEG_Z, Vec3::new(-0.0, 0.0, -1.0)] {
            let f = Frame::from_normal(z);
            assert!((f.x.cross(f.y) - z).length() < 1e-6);
        }
    }
}
