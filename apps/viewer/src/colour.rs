//! Colour maps of even lightness, made in Oklab.
//!
//! Equal steps of a value are equal steps of lightness, so that no edge is seen where the values have none (Borland, Taylor, "Rainbow Color Map
//! (Still) Considered Harmful", 2007). The maps are paths through Oklab (Ottosson, "A perceptual color space for image processing", 2020);
//! where a path leaves what a screen can show, its chroma is lowered and its lightness kept.

use egui::Color32;
use std::sync::LazyLock;

/// Steps of a table.
const STEPS: usize = 256;

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// Black to white, as the files are.
    Grey,
    /// Dark violet over green to light yellow.
    Sequential,
    /// Blue over white to red: white is zero.
    Diverging,
}

impl Map {
    /// The colour of a value in [0, 1]; values outside are held within, NaN is the colour of what is not known.
    #[inline]
    pub fn colour(self, value: f32) -> Color32 {
        if value.is_nan() {
            return UNKNOWN;
        }
        let step = (value.clamp(0.0, 1.0) * (STEPS - 1) as f32).round() as usize;
        match self {
            Self::Grey => Color32::from_gray(step as u8),
            Self::Sequential => SEQUENTIAL[step],
            Self::Diverging => DIVERGING[step],
        }
    }
}

/// What is not known: a brown that no map has.
pub const UNKNOWN: Color32 = Color32::from_rgb(92, 62, 48);

static SEQUENTIAL: LazyLock<[Color32; STEPS]> = LazyLock::new(|| {
    table(|t| Lch { lightness: 0.24 + 0.70 * t, chroma: 0.13 + 0.03 * t, hue_deg: 305.0 - 200.0 * t })
});

static DIVERGING: LazyLock<[Color32; STEPS]> = LazyLock::new(|| {
    table(|t| {
        let away = (2.0 * t - 1.0).abs();
        let hue_deg = if t < 0.5 { 255.0 } else { 32.0 };
        Lch { lightness: 0.96 - 0.56 * away, chroma: 0.19 * away, hue_deg }
    })
});

fn table(path: impl Fn(f32) -> Lch) -> [Color32; STEPS] {
    std::array::from_fn(|step| path(step as f32 / (STEPS - 1) as f32).colour())
}

/// Oklab in polar form.
#[derive(Clone, Copy)]
struct Lch {
    lightness: f32,
    chroma: f32,
    hue_deg: f32,
}

impl Lch {
    /// The nearest colour of the same lightness and hue that a screen can show.
    fn colour(self) -> Color32 {
        let shown = |chroma: f32| Self { chroma, ..self }.linear();
        let inside = |rgb: [f32; 3]| rgb.iter().all(|c| (-1e-4..=1.0 + 1e-4).contains(c));
        let (mut low, mut high) = (0.0, self.chroma);
        if !inside(shown(high)) {
            for _ in 0..24 {
                let middle = 0.5 * (low + high);
                if inside(shown(middle)) { low = middle } else { high = middle }
            }
            high = low;
        }
        let [r, g, b] = shown(high).map(|c| (encoded(c) * 255.0).round() as u8);
        Color32::from_rgb(r, g, b)
    }

    /// Linear sRGB, by the matrices of Ottosson.
    fn linear(self) -> [f32; 3] {
        let (sin, cos) = self.hue_deg.to_radians().sin_cos();
        let (a, b) = (self.chroma * cos, self.chroma * sin);
        let l = (self.lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
        let m = (self.lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
        let s = (self.lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
        [
            4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
            -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
            -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
        ]
    }
}

/// The sRGB code in [0, 1] of a linear value: what a screen is sent.
pub fn encoded(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness, by another way than the maps are made: from the luminance of the sRGB codes.
    fn cie_lightness(colour: Color32) -> f32 {
        let linear = |code: u8| {
            let c = f32::from(code) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b());
        if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    /// Smallest and largest step of lightness between values a sixteenth apart.
    fn steps(map: Map, from: f32, to: f32) -> (f32, f32) {
        let at = |i: usize| cie_lightness(map.colour(from + (to - from) * i as f32 / 16.0));
        let steps: Vec<f32> = (0..16).map(|i| at(i + 1) - at(i)).collect();
        (steps.iter().copied().fold(f32::MAX, f32::min), steps.iter().copied().fold(f32::MIN, f32::max))
    }

    #[test]
    fn lightness_rises_evenly() {
        for (map, from, to) in [
            (Map::Sequential, 0.0, 1.0),
            (Map::Grey, 0.0, 1.0),
            (Map::Diverging, 0.0, 0.5),
            (Map::Diverging, 1.0, 0.5),
        ] {
            let (least, most) = steps(map, from, to);
            assert!(least > 1.5 && most < 2.6 * least, "{map:?}: {least} to {most}");
        }
    }

    #[test]
    fn the_middle_of_the_diverging_map_is_neutral_and_its_ends_are_not() {
        let spread =
            |c: Color32| i32::from(c.r().max(c.g()).max(c.b())) - i32::from(c.r().min(c.g()).min(c.b()));
        assert!(spread(Map::Diverging.colour(0.5)) < 12);
        assert!(spread(Map::Diverging.colour(0.0)) > 90 && spread(Map::Diverging.colour(1.0)) > 90);
    }

    #[test]
    fn values_outside_are_held_within_and_unknown_ones_are_seen() {
        assert_eq!(Map::Sequential.colour(-3.0), Map::Sequential.colour(0.0));
        assert_eq!(Map::Sequential.colour(f32::INFINITY), Map::Sequential.colour(1.0));
        assert_eq!(Map::Grey.colour(f32::NAN), UNKNOWN);
        assert_eq!(Map::Grey.colour(0.5), Color32::from_gray(128));
    }
}
