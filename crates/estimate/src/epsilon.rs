//! The error of a cone: as published, and with that of marching itself.
//!
//! The published epsilon tells how mixed the voxels are that a cone met. What it leaves out is that a cone is sampled along its axis
//! alone: one that an edge divides is answered as one voxel after the other has it, and what is smeared over the cone, lifted off
//! the tangent plane or met twice comes out partly open too. A cone whose march says `C` is right where `C` is 0 or 1, and like a
//! toss with that mean in between; so the error of marching is the standard deviation of such a toss, `sqrt(C (1 - C))`.

use conray_voxel::ConeResult;
use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// Root mean square error of cones over their epsilon with that of marching, taken as of one sign at a point: 0.13 to 0.36 on the
/// built-in scenes, a factor of less than two either way.
const ERROR_SHARE: f32 = 0.25;

/// Which error of a cone decides between it and rays in method `paper`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Epsilon {
    /// The standard deviations that the march met: Podee, Dobashi, Yamamoto.
    #[default]
    Published,
    /// With the error of marching itself added: cones that are partly open get rays.
    Marching,
}

impl Epsilon {
    /// Every choice.
    pub const ALL: [Self; 2] = [Self::Published, Self::Marching];

    /// Epsilon of a cone whose march says that visibility, in [0, 1], and met those standard deviations.
    pub fn of(self, visibility: f32, deviations: f32) -> f32 {
        match self {
            Self::Published => deviations,
            Self::Marching => deviations + (visibility * (1.0 - visibility)).max(0.0).sqrt(),
        }
    }
}

/// Expected error of a cone that is trusted.
pub(crate) fn expected_error(cone: &ConeResult) -> f32 {
    ERROR_SHARE * Epsilon::Marching.of(cone.visibility, cone.error)
}

impl fmt::Display for Epsilon {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Published => "published",
            Self::Marching => "marching",
        })
    }
}

impl FromStr for Epsilon {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|epsilon| epsilon.to_string() == text)
            .ok_or_else(|| "expected published or marching".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_open_or_closed_is_marched_right_and_what_is_in_between_is_not() {
        for deviations in [0.0, 0.3, f32::INFINITY] {
            for visibility in [0.0, 1.0] {
                assert_eq!(Epsilon::Marching.of(visibility, deviations), deviations);
            }
            assert_eq!(Epsilon::Published.of(0.5, deviations), deviations);
            assert_eq!(Epsilon::Marching.of(0.5, deviations), 0.5 + deviations);
        }
        // Rounding leaves no root of what is below 0.
        assert_eq!(Epsilon::Marching.of(1.0 + f32::EPSILON, 0.0), 0.0);
    }

    #[test]
    fn names_are_read_back() {
        for epsilon in Epsilon::ALL {
            assert_eq!(epsilon.to_string().parse(), Ok(epsilon));
        }
        assert!("".parse::<Epsilon>().is_err());
    }
}
