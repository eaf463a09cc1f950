//! Two colour maps with even steps to the eye.
//!
//! Both are straight or evenly wound paths in Oklab, where equal distances look about equally different: Björn Ottosson,
//! "A perceptual color space for image processing", 2020. The sequential map is a helix as in Dave Green, "A colour scheme
//! for the display of astronomical intensity images", 2011, but wound in Oklab at constant chroma, half a turn. Its
//! lightness only rises, so it also reads in grey and with any colour blindness.

/// Lightness, green to red, blue to yellow.
type Oklab = [f32; 3];

/// From 0, dark violet, over red to 1, yellow.
pub(super) fn sequential(t: f32) -> [u8; 3] {
    srgb(sequential_path(t))
}

/// From -1, blue, over 0, white, to 1, red.
pub(super) fn diverging(t: f32) -> [u8; 3] {
    srgb(diverging_path(t))
}

fn sequential_path(t: f32) -> Oklab {
    polar(0.25 + 0.67 * t, 0.13, 295.0 + 170.0 * t)
}

fn diverging_path(t: f32) -> Oklab {
    let hue_deg = if t < 0.0 { 260.0 } else { 27.0 };
    polar(1.0 - 0.5 * t.abs(), 0.17 * t.abs(), hue_deg)
}

fn polar(lightness: f32, chroma: f32, hue_deg: f32) -> Oklab {
    let (sin, cos) = hue_deg.to_radians().sin_cos();
    [lightness, chroma * cos, chroma * sin]
}

fn srgb(colour: Oklab) -> [u8; 3] {
    linear(colour).map(|v| (encode(v.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// Linear sRGB of an Oklab colour, by the matrices of Ottosson's article.
fn linear([lightness, a, b]: Oklab) -> [f32; 3] {
    let long = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let middle = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let short = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    [
        4.076_741_7 * long - 3.307_711_6 * middle + 0.230_969_94 * short,
        -1.268_438 * long + 2.609_757_4 * middle - 0.341_319_38 * short,
        -0.004_196_086 * long - 0.703_418_6 * middle + 1.707_614_7 * short,
    ]
}

/// The transfer curve of IEC 61966-2-1 (sRGB).
fn encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: usize = 64;

    fn distance(a: Oklab, b: Oklab) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
    }

    /// Oklab of a linear sRGB colour, by the article's matrices for that direction.
    fn oklab([r, g, b]: [f32; 3]) -> Oklab {
        let long = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).cbrt();
        let middle = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
        let short = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).cbrt();
        [
            0.210_454_26 * long + 0.793_617_8 * middle - 0.004_072_047 * short,
            1.977_998_5 * long - 2.428_592_2 * middle + 0.450_593_7 * short,
            0.025_904_037 * long + 0.782_771_77 * middle - 0.808_675_77 * short,
        ]
    }

    fn decode(byte: u8) -> f32 {
        let v = f32::from(byte) / 255.0;
        if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    }

    /// Longest over shortest step between colours that were read back from their bytes.
    fn unevenness(map: impl Fn(f32) -> [u8; 3]) -> f32 {
        let colours: Vec<Oklab> =
            (0..=STEPS).map(|i| oklab(map(i as f32 / STEPS as f32).map(decode))).collect();
        // Three steps at a time, so that rounding to bytes counts for little.
        let steps: Vec<f32> = colours.windows(4).map(|w| distance(w[0], w[3])).collect();
        steps.iter().copied().fold(0.0, f32::max) / steps.iter().copied().fold(f32::INFINITY, f32::min)
    }

    #[test]
    fn steps_look_even_and_those_of_a_ramp_in_srgb_do_not() {
        let ramp = |t: f32| [(255.0 * t) as u8, (255.0 * t) as u8, (255.0 * (1.0 - t)) as u8];
        let maps: [(&str, f32); 3] = [
            ("sequential", unevenness(sequential)),
            ("too open", unevenness(diverging)),
            ("too closed", unevenness(|t| diverging(-t))),
        ];
        for (name, uneven) in maps {
            assert!(uneven < 1.2, "{name}: {uneven}");
        }
        assert!(unevenness(ramp) > 1.5, "the negative control: {}", unevenness(ramp));
    }

    #[test]
    fn every_colour_can_be_shown() {
        for i in 0..=STEPS {
            let t = i as f32 / STEPS as f32;
            for colour in [sequential_path(t), diverging_path(t), diverging_path(-t)] {
                assert!(
                    linear(colour).iter().all(|v| (-0.006..=1.006).contains(v)),
                    "{t}: {:?}",
                    linear(colour)
                );
            }
        }
        let too_strong = linear(polar(0.5, 0.4, 150.0));
        assert!(too_strong.iter().any(|v| *v < -0.006), "a colour beyond sRGB must be noticed");
    }

    #[test]
    fn the_sequential_map_only_gets_lighter() {
        let luminance = |t: f32| {
            let [r, g, b] = sequential(t).map(decode);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((0..STEPS).all(|i| luminance(i as f32 / 64.0) < luminance((i + 1) as f32 / 64.0)));
    }

    #[test]
    fn the_ends_say_what_they_mean() {
        let [r, _, b] = diverging(1.0);
        assert!(r > 2 * b, "too open is red");
        let [r, _, b] = diverging(-1.0);
        assert!(b > 2 * r, "too closed is blue");
        assert_eq!(diverging(0.0), [255; 3]);
    }
}
