//! How an occluder's weight fades with its distance.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Weight of an occluder at a given share of the AO distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Falloff {
    /// Every occluder within the AO distance counts fully.
    #[default]
    None,
    /// Weight `1 - x`.
    Linear,
    /// Weight `1 - x^2 (3 - 2 x)`: flat at both ends.
    Smooth,
}

impl Falloff {
    /// Weight in [0, 1] of an occluder at `x` = its distance over the AO distance.
    #[inline]
    pub fn weight(self, x: f32) -> f32 {
        let x = x.clamp(0.0, 1.0);
        match self {
            Self::None => 1.0,
            Self::Linear => 1.0 - x,
            Self::Smooth => 1.0 - x * x * (3.0 - 2.0 * x),
        }
    }
}

impl fmt::Display for Falloff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Linear => "linear",
            Self::Smooth => "smooth",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Falloff;

    #[test]
    fn weights_start_at_one_end_at_zero_and_never_rise() {
        for falloff in [Falloff::Linear, Falloff::Smooth] {
            assert_eq!(falloff.weight(0.0), 1.0);
            assert_eq!(falloff.weight(1.0), 0.0);
            for i in 0..100 {
                assert!(falloff.weight(i as f32 / 100.0) >= falloff.weight((i + 1) as f32 / 100.0));
            }
        }
        assert_eq!(Falloff::None.weight(0.7), 1.0);
    }
}
