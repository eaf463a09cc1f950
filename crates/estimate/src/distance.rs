//! The AO distance as a person says it.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::{fmt, str::FromStr};

/// Share of the diagonal of the scene's bounds that [`Distance::Auto`] stands for.
///
/// A tenth of the diagonal is about a sixth of the width of a cubic room: occlusion by furniture and corners counts
/// and that by the far wall does not.
pub const AUTO_DISTANCE_SHARE: f32 = 0.1;

/// How far an occluder still counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Distance {
    /// [`AUTO_DISTANCE_SHARE`] of the diagonal of the scene's bounds.
    #[default]
    Auto,
    /// World units, above 0.
    World(f32),
    /// Without end.
    Infinite,
}

impl Distance {
    /// In world units, for a scene with bounds of that diagonal.
    pub fn in_world(self, diagonal: f32) -> f32 {
        match self {
            Self::Auto => AUTO_DISTANCE_SHARE * diagonal,
            Self::World(distance) => distance,
            Self::Infinite => f32::INFINITY,
        }
    }
}

impl From<f32> for Distance {
    fn from(distance: f32) -> Self {
        if distance == f32::INFINITY { Self::Infinite } else { Self::World(distance) }
    }
}

impl fmt::Display for Distance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::World(distance) => distance.fmt(f),
            Self::Infinite => f.write_str("inf"),
        }
    }
}

impl FromStr for Distance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "inf" | "infinite" | "infinity" => Ok(Self::Infinite),
            _ => match text.parse::<f32>() {
                Ok(distance) if distance > 0.0 => Ok(distance.into()),
                _ => Err("expected a number above 0, inf or auto".into()),
            },
        }
    }
}

impl Serialize for Distance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::World(distance) => serializer.serialize_f32(*distance),
            _ => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Distance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Form {
            Number(f32),
            Word(String),
        }
        match Form::deserialize(deserializer)? {
            Form::Number(distance) => distance.to_string().parse(),
            Form::Word(word) => word.parse(),
        }
        .map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::Distance;

    #[test]
    fn words_and_numbers_are_read_and_nonsense_is_refused() {
        assert_eq!("inf".parse(), Ok(Distance::Infinite));
        assert_eq!("auto".parse(), Ok(Distance::Auto));
        assert_eq!("2.5".parse(), Ok(Distance::World(2.5)));
        for bad in ["0", "-1", "nan", "", "far"] {
            assert!(bad.parse::<Distance>().is_err(), "{bad}");
        }
    }

    #[test]
    fn auto_is_a_share_of_the_diagonal() {
        assert_eq!(Distance::Auto.in_world(20.0), 2.0);
        assert_eq!(Distance::Infinite.in_world(20.0), f32::INFINITY);
        assert_eq!(Distance::World(3.0).in_world(20.0), 3.0);
    }
}
