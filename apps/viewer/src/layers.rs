//! Layers: which number of a pixel is shown, by which colours, in which range.

use crate::{
    colour::{Map, encoded},
    engine::{Picture, SidePicture},
};
use egui::Color32;

/// What is shown of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Layer {
    /// Visibility: 1 is open.
    #[default]
    Visibility,
    /// Light from everywhere and a lamp at the eye, the light from everywhere times visibility.
    ShadedAo,
    /// The same without ambient occlusion.
    Shaded,
    /// Expected error of the visibility.
    Error,
    /// Rays traced.
    Rays,
    /// Visibility by cones alone.
    ConeVisibility,
    /// Error of the cones.
    Epsilon,
    /// Weight of the cones in the blend.
    Alpha,
    /// Visibility less the truth's.
    Difference,
}

impl Layer {
    /// All, in the order of the list.
    pub const ALL: [Self; 9] = [
        Self::Visibility,
        Self::ShadedAo,
        Self::Shaded,
        Self::Error,
        Self::Rays,
        Self::ConeVisibility,
        Self::Epsilon,
        Self::Alpha,
        Self::Difference,
    ];

    /// For lists.
    pub fn name(self) -> &'static str {
        match self {
            Self::Visibility => "visibility",
            Self::ShadedAo => "shaded, AO on",
            Self::Shaded => "shaded, AO off",
            Self::Error => "predicted error",
            Self::Rays => "rays spent",
            Self::ConeVisibility => "cone visibility",
            Self::Epsilon => "epsilon (cone error)",
            Self::Alpha => "alpha (weight of cones)",
            Self::Difference => "difference to truth",
        }
    }

    /// The layer of that name, its first word or the whole of it.
    pub fn named(name: &str) -> Option<Self> {
        let first = |layer: &Self| layer.name().split([' ', ',']).next() == Some(name);
        let short = match name {
            "error" => Some(Self::Error),
            "ao" => Some(Self::ShadedAo),
            "cone-visibility" => Some(Self::ConeVisibility),
            _ => None,
        };
        short.or_else(|| Self::ALL.into_iter().find(|l| l.name() == name || first(l)))
    }

    /// Its colours; `None` for a shaded picture, which has no scale.
    pub fn map(self) -> Option<Map> {
        match self {
            Self::Visibility => Some(Map::Grey),
            Self::ShadedAo | Self::Shaded => None,
            Self::Difference => Some(Map::Diverging),
            _ => Some(Map::Sequential),
        }
    }

    /// The range that is always right, for those that have one; the others go by the picture.
    pub fn fixed_range(self) -> Option<Range> {
        match self {
            Self::Visibility | Self::ConeVisibility | Self::Alpha => Some(Range { low: 0.0, high: 1.0 }),
            _ => None,
        }
    }

    /// True where it needs the cones' results.
    pub fn needs_cones(self) -> bool {
        matches!(self, Self::ConeVisibility | Self::Epsilon | Self::Alpha)
    }
}

/// Values at the two ends of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// At the dark or blue end.
    pub low: f32,
    /// At the light or red end.
    pub high: f32,
}

/// Values looked at to find a range.
const LOOKED_AT: usize = 20_000;
/// Share of them that lie within.
const WITHIN: f64 = 0.99;

impl Range {
    /// The range of a layer over values: from 0, or about it, to a round number that most do not exceed.
    pub fn of(layer: Layer, values: &[f32]) -> Self {
        if let Some(range) = layer.fixed_range() {
            return range;
        }
        let stride = values.len().div_ceil(LOOKED_AT).max(1);
        let mut seen: Vec<f32> =
            values.iter().step_by(stride).filter(|v| v.is_finite()).map(|v| v.abs()).collect();
        let rank = (seen.len() as f64 * WITHIN) as usize;
        let most = if rank < seen.len() { *seen.select_nth_unstable_by(rank, f32::total_cmp).1 } else { 0.0 };
        let high = round_up(most);
        Self { low: if layer == Layer::Difference { -high } else { 0.0 }, high }
    }

    /// Where a value lies: 0 at the low end, 1 at the high one.
    #[inline]
    pub fn share(self, value: f32) -> f32 {
        (value - self.low) / (self.high - self.low)
    }
}

/// The next of 1, 2 and 5 times a power of ten that is not below.
fn round_up(value: f32) -> f32 {
    if !(value > 1e-6 && value.is_finite()) {
        return 1e-3;
    }
    let power = 10f32.powf(value.log10().floor());
    let step = [1.0, 2.0, 5.0].into_iter().find(|step| value <= step * power * 1.000_01);
    step.unwrap_or(10.0) * power
}

/// The numbers of a layer; `None` where the side has none.
pub fn values(
    layer: Layer,
    picture: &Picture,
    side: &SidePicture,
    truth: Option<&[f32]>,
) -> Option<Vec<f32>> {
    let cones = side.cones.as_ref();
    match layer {
        Layer::Visibility => Some(side.visibility.to_vec()),
        Layer::Error => Some(side.error.to_vec()),
        Layer::Rays => Some(side.rays.to_vec()),
        Layer::ConeVisibility => cones.map(|c| c.visibility.to_vec()),
        Layer::Epsilon => cones.map(|c| c.error.to_vec()),
        Layer::Alpha => cones.map(|c| c.alpha.to_vec()),
        Layer::Difference => {
            let truth = truth.filter(|truth| truth.len() == side.visibility.len())?;
            Some(side.visibility.iter().zip(truth).map(|(value, truth)| value - truth).collect())
        }
        Layer::Shaded => Some(picture.facing.iter().map(|&facing| shaded(facing, 1.0)).collect()),
        Layer::ShadedAo => {
            let pairs = picture.facing.iter().zip(side.visibility.iter());
            Some(pairs.map(|(&facing, &visibility)| shaded(facing, visibility)).collect())
        }
    }
}

/// The sRGB code in [0, 1] of a matt surface: half of the light from everywhere, half from a lamp at the eye.
fn shaded(facing: f32, visibility: f32) -> f32 {
    if facing.is_nan() { facing } else { encoded(0.85 * (0.5 * visibility + 0.5 * facing)) }
}

/// The colours of a layer's numbers; where the picture sees nothing, that of the ground.
pub fn colours(layer: Layer, values: &[f32], facing: &[f32], range: Range, ground: Color32) -> Vec<Color32> {
    let (map, range) = match layer.map() {
        Some(map) => (map, range),
        None => (Map::Grey, Range { low: 0.0, high: 1.0 }),
    };
    let one = |(&value, &facing): (&f32, &f32)| {
        if facing.is_nan() { ground } else { map.colour(range.share(value)) }
    };
    values.iter().zip(facing).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn picture(values: &[f32]) -> Picture {
        let plane = |v: &[f32]| Arc::new(v.to_vec());
        let side = SidePicture {
            method: conray::Method::Rays,
            visibility: plane(values),
            error: plane(&[0.01, 0.02, f32::NAN]),
            rays: plane(&[16.0, 32.0, f32::NAN]),
            cones: None,
            expected_rmse: 0.02,
            rays_per_pixel: 24.0,
            seconds: 1.0,
            ended: None,
        };
        Picture {
            look: crate::camera::Look {
                eye: [0.0; 3],
                look_at: [1.0; 3],
                up: [0.0, 1.0, 0.0],
                vertical_fov_deg: 40.0,
            },
            scene: 1,
            size: [3, 1],
            wished: [3, 1],
            facing: plane(&[1.0, 0.5, f32::NAN]),
            sides: vec![side],
            seconds: 1.0,
        }
    }

    fn shown(layer: Layer, truth: Option<&[f32]>) -> Option<Vec<Color32>> {
        let picture = picture(&[1.0, 0.25, f32::NAN]);
        let values = values(layer, &picture, &picture.sides[0], truth)?;
        let range = Range::of(layer, &values);
        Some(colours(layer, &values, &picture.facing, range, Color32::RED))
    }

    #[test]
    fn visibility_is_grey_as_in_files_and_nothing_is_the_ground() {
        let colours = shown(Layer::Visibility, None).unwrap();
        assert_eq!(colours, [Color32::WHITE, Color32::from_gray(64), Color32::RED]);
    }

    #[test]
    fn ambient_occlusion_darkens_what_is_shaded() {
        let (with, without) = (shown(Layer::ShadedAo, None).unwrap(), shown(Layer::Shaded, None).unwrap());
        assert_eq!(with[0], without[0], "what is open is as bright");
        assert!(with[1].r() < without[1].r());
    }

    #[test]
    fn what_a_method_does_not_tell_has_no_layer() {
        for layer in Layer::ALL {
            let has = shown(layer, None).is_some();
            assert_eq!(has, !layer.needs_cones() && layer != Layer::Difference, "{layer:?}");
        }
        assert!(shown(Layer::Difference, Some(&[1.0])).is_none(), "a truth of another size");
        let equal = shown(Layer::Difference, Some(&[1.0, 0.25, 0.0])).unwrap();
        assert_eq!(equal[0], Map::Diverging.colour(0.5));
        let too_open = shown(Layer::Difference, Some(&[0.0, 0.25, 0.0])).unwrap();
        assert!(too_open[0].r() > too_open[0].b(), "too open is red");
    }

    #[test]
    fn ranges_end_at_round_numbers_and_outliers_do_not_count() {
        for (value, expected) in
            [(0.013, 0.02), (0.5, 0.5), (3.0, 5.0), (0.0, 1e-3), (f32::NAN, 1e-3), (70.0, 100.0)]
        {
            assert!((round_up(value) / expected - 1.0).abs() < 1e-4, "{value}: {}", round_up(value));
        }
        let mut errors = vec![0.03f32; 1000];
        errors[3] = 7.0;
        let range = Range::of(Layer::Error, &errors);
        assert!((range.high - 0.05).abs() < 1e-6 && range.low == 0.0, "{range:?}");
        let range = Range::of(Layer::Difference, &[-0.4, 0.1]);
        assert_eq!(range.low, -range.high);
    }

    #[test]
    fn layers_are_found_by_name() {
        for layer in Layer::ALL {
            assert_eq!(Layer::named(layer.name()), Some(layer));
        }
        assert_eq!(Layer::named("epsilon"), Some(Layer::Epsilon));
        assert_eq!(Layer::named("error"), Some(Layer::Error));
        assert_eq!(Layer::named("nothing"), None);
    }
}
