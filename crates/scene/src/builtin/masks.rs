//! Alpha masks of leaves, drawn from formulas.
//!
//! Each is a signed distance (positive inside, in texture widths) turned into a ramp one texel wide about one half, so that bilinear
//! look-ups with a cutoff of one half give smooth outlines. v = 0 is the stalk, v = 1 the tip.

use super::random::Random;
use conray_core::{AlphaTexture, Vec2};
use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};

/// One blade: a lens along a straight midrib.
#[derive(Clone, Copy, Debug)]
struct Blade {
    base: Vec2,
    tip: Vec2,
    /// Half the width over the length, at the widest place.
    slimness: f32,
    /// Where the widest place lies between base (0) and tip (1).
    widest: f32,
    /// Depth of the teeth of its edge over its half width.
    teeth: f32,
}

impl Blade {
    /// Signed distance to the outline, about: exact on the midrib and near the edge at its widest.
    fn distance(&self, p: Vec2) -> f32 {
        let axis = self.tip - self.base;
        let length = axis.length();
        let along = (p - self.base).dot(axis) / (length * length);
        let across = (p - self.base).perp_dot(axis).abs() / length;
        if !(0.0..=1.0).contains(&along) {
            return -p.distance(if along < 0.0 { self.base } else { self.tip });
        }
        // Moves the widest place to the middle, where the sine has it.
        let t = along.powf(0.5f32.ln() / self.widest.ln());
        let edge = 1.0 - self.teeth * (0.5 + 0.5 * (9.0 * TAU * along).cos());
        self.slimness * length * (PI * t).sin().powf(0.8) * edge - across
    }
}

/// Signed distance to a straight stroke of that half width.
fn stroke(p: Vec2, from: Vec2, to: Vec2, half_width: f32) -> f32 {
    let axis = to - from;
    let along = ((p - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    half_width - p.distance(from + along * axis)
}

/// The mask of a signed distance over [0, 1] x [0, height / width].
fn draw(width: u32, height: u32, distance: impl Fn(Vec2) -> f32) -> AlphaTexture {
    let texel = |i: u32| {
        let p = (Vec2::new((i % width) as f32, (i / width) as f32) + 0.5) / width as f32;
        (255.0 * (0.5 + 0.5 * width as f32 * distance(p)).clamp(0.0, 1.0)).round() as u8
    };
    AlphaTexture::new(width, height, (0..width * height).map(texel).collect())
        .expect("one texel per pixel of a texture that is not empty")
}

fn union(blades: &[Blade], p: Vec2) -> f32 {
    blades.iter().map(|blade| blade.distance(p)).fold(f32::NEG_INFINITY, f32::max)
}

/// One broad leaf.
pub(crate) fn broad_leaf() -> AlphaTexture {
    let blade = Blade {
        base: Vec2::new(0.5, 0.04),
        tip: Vec2::new(0.5, 1.96),
        slimness: 0.25,
        widest: 0.4,
        teeth: 0.06,
    };
    draw(64, 128, |p| blade.distance(p).max(stroke(p, Vec2::new(0.5, 0.0), Vec2::new(0.5, 0.2), 0.03)))
}

/// A twig with leaves to both sides and one at its end.
pub(crate) fn leafy_twig() -> AlphaTexture {
    let mut random = Random::new(11);
    let mut blades = Vec::new();
    for i in 0..8 {
        let (side, height) = (if i % 2 == 0 { 1.0 } else { -1.0 }, 0.1 + 0.083 * i as f32);
        let angle = 0.4 + 0.4 * i as f32 / 8.0 + random.about_zero(0.1);
        let length = 0.43 - 0.08 * i as f32 / 8.0 + random.about_zero(0.04);
        // A short stalk between twig and blade.
        let outward = Vec2::new(side * angle.cos(), angle.sin());
        let base = Vec2::new(0.5, height) + 0.05 * outward;
        blades.push(Blade { base, tip: base + length * outward, slimness: 0.19, widest: 0.42, teeth: 0.1 });
    }
    let (base, tip) = (Vec2::new(0.5, 0.7), Vec2::new(0.5, 0.99));
    blades.push(Blade { base, tip, slimness: 0.2, widest: 0.42, teeth: 0.1 });
    draw(128, 128, |p| union(&blades, p).max(stroke(p, Vec2::new(0.5, 0.0), base, 0.012)))
}

/// A fern's frond: narrow leaflets in pairs along a midrib, twice as long as wide.
pub(crate) fn fern_frond() -> AlphaTexture {
    let mut blades = Vec::new();
    let pairs = 17;
    for i in 0..pairs {
        let t = (i as f32 + 0.6) / pairs as f32;
        // Longest a third of the way up.
        let length = 0.05 + 0.46 * (PI * t.powf(0.65)).sin().max(0.0).powf(0.7);
        for side in [1.0, -1.0] {
            let base = Vec2::new(0.5, 2.0 * (0.08 + 0.88 * t) - 0.02);
            let tip = base + length * Vec2::new(0.96 * side, 0.36);
            blades.push(Blade {
                base,
                tip: tip.min(Vec2::new(0.99, 1.99)),
                slimness: 0.052 / length.max(0.2),
                widest: 0.35,
                teeth: 0.0,
            });
        }
    }
    draw(128, 256, |p| union(&blades, p).max(stroke(p, Vec2::new(0.5, 0.0), Vec2::new(0.5, 1.95), 0.014)))
}

/// A spray of five-lobed ivy leaves.
pub(crate) fn ivy() -> AlphaTexture {
    // Where the stalk meets the leaf, direction and size.
    let leaves = [
        (Vec2::new(0.34, 0.17), Vec2::new(-0.5, 1.0), 0.34),
        (Vec2::new(0.66, 0.26), Vec2::new(0.55, 1.0), 0.36),
        (Vec2::new(0.36, 0.60), Vec2::new(-0.35, 1.0), 0.31),
        (Vec2::new(0.66, 0.70), Vec2::new(0.3, 1.0), 0.26),
    ];
    let mut blades = Vec::new();
    for (foot, direction, size) in leaves {
        // The lobes: angle from the middle one, and length over its length.
        for (angle, length) in [(0.0, 1.0), (0.95, 0.82), (-0.95, 0.82), (1.95, 0.55), (-1.95, 0.55)] {
            let lobe = Vec2::from_angle(angle).rotate(direction.normalize());
            let tip = foot + size * length * lobe;
            blades.push(Blade {
                base: foot - 0.08 * size * lobe,
                tip,
                slimness: 0.3,
                widest: 0.45,
                teeth: 0.0,
            });
        }
    }
    let stem = [Vec2::new(0.5, 0.0), Vec2::new(0.48, 0.4), Vec2::new(0.52, 0.75)];
    let stalks = leaves.map(|(foot, ..)| (foot, Vec2::new(0.5, foot.y - 0.1)));
    draw(128, 128, |p| {
        let stalk = stalks.iter().map(|&(from, to)| stroke(p, from, to, 0.012)).fold(-1.0, f32::max);
        let stem = stroke(p, stem[0], stem[1], 0.014).max(stroke(p, stem[1], stem[2], 0.012));
        union(&blades, p).max(stem).max(stalk)
    })
}

/// Blades of grass that start side by side and bow apart.
pub(crate) fn grass() -> AlphaTexture {
    let mut random = Random::new(5);
    let blades: Vec<(f32, f32, f32, f32)> = (0..9)
        .map(|i| {
            let start = 0.14 + 0.09 * i as f32 + random.about_zero(0.03);
            (
                start,
                (start - 0.5) * 0.5 + random.about_zero(0.15),
                random.between(0.6, 0.99),
                random.between(0.026, 0.04),
            )
        })
        .collect();
    draw(128, 128, |p| {
        let blade = |&(start, lean, height, half_width): &(f32, f32, f32, f32)| {
            let t = p.y / height;
            let middle = (start + lean * t * t).clamp(0.03, 0.97);
            if t > 1.0 { -1.0 } else { half_width * (1.0 - t * t).max(0.0).sqrt() - (p.x - middle).abs() }
        };
        blades.iter().map(blade).fold(-1.0, f32::max)
    })
}

/// A twig of conifer needles.
pub(crate) fn needles() -> AlphaTexture {
    draw(64, 128, |p| {
        let rib = stroke(p, Vec2::new(0.5, 0.0), Vec2::new(0.5, 1.9), 0.022);
        let away = (p.x - 0.5).abs();
        // Needles leave the rib at 45 degrees, every 0.09 widths, and shorten towards the tip.
        let reach = 0.46 * (1.0 - ((p.y - 0.9).abs() / 1.08).powi(4));
        let phase = ((p.y - away) / 0.09).rem_euclid(1.0) - 0.5;
        let needle = 0.021 - phase.abs() * 0.09 * FRAC_1_SQRT_2;
        rib.max(needle.min(reach - away))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_are_partly_open_and_sharp() {
        let masks = [
            ("broad leaf", broad_leaf()),
            ("leafy twig", leafy_twig()),
            ("fern frond", fern_frond()),
            ("ivy", ivy()),
            ("grass", grass()),
            ("needles", needles()),
        ];
        for (name, mask) in &masks {
            let texels = mask.texels();
            let mean = texels.iter().map(|&t| f32::from(t)).sum::<f32>() / (255.0 * texels.len() as f32);
            assert!((0.2..=0.8).contains(&mean), "{name} covers {mean}");
            let covered = texels.iter().filter(|&&t| t >= 128).count() as f32 / texels.len() as f32;
            assert!((covered - mean).abs() < 0.06, "{name}: the cutoff shifts {mean} to {covered}");
            let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| {
                texels[((mask.height() - 1) * y * mask.width() + (mask.width() - 1) * x) as usize]
            });
            assert_eq!(corners, [0; 4], "{name} is cut by its corners");
        }
    }

    #[test]
    fn a_blade_is_inside_on_its_midrib_and_outside_beyond_its_ends() {
        let blade = Blade { base: Vec2::ZERO, tip: Vec2::Y, slimness: 0.25, widest: 0.5, teeth: 0.0 };
        assert!((blade.distance(Vec2::new(0.0, 0.5)) - 0.25).abs() < 1e-6);
        assert!(blade.distance(Vec2::new(0.25, 0.5)).abs() < 1e-6);
        assert!(blade.distance(Vec2::new(0.0, 1.1)) < 0.0 && blade.distance(Vec2::new(0.0, -0.1)) < 0.0);
    }
}
