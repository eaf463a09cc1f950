//! Hanging cloth: single sheets with folds.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::part::Part;
use crate::builtin::random::Random;
use crate::builtin::shapes::tube;
use conray_core::Vec3;
use std::f32::consts::{PI, TAU};

/// Edges of cloth never show.
const CREASE_DEG: f32 = 75.0;

/// Adds curtains between the lower columns, banners over the balustrade and cloths between the upper columns.
pub(crate) fn add(assembly: &mut Assembly, fabric: u32) {
    let (mut cloth, mut rods) = (Part::default(), Part::default());
    let mut random = Random::new(8);
    for (index, side) in Side::all().into_iter().enumerate().filter(|(_, side)| side.is_long()) {
        // Which bays have what differs between the two sides, so that the court is not its own mirror image.
        let lower = ["pair", "", "left", "full", "", "pair", "right", ""];
        let count = lower.len();
        for (i, x) in side.bay_centres().enumerate() {
            let kind = lower[(i + 3 * index) % count];
            if !kind.is_empty() {
                curtains(kind, &mut random)
                    .iter()
                    .for_each(|c| cloth.place(&c.smooth(CREASE_DEG), &side.at(x, 0.0, 0.0)));
                rods.place(&rod(1.5, 4.02), &side.at(x, 0.0, 0.0));
            }
            if (i + index) % 2 == 0 {
                cloth.place(&banner(&mut random).smooth(CREASE_DEG), &side.at(x + 0.5 * BAY, GALLERY, 0.0));
            }
            if (i + index) % 3 != 2 {
                let half_bay = x + if i % 2 == 0 { 0.25 * BAY } else { -0.25 * BAY };
                cloth.place(&gallery_cloth(&mut random).smooth(CREASE_DEG), &side.at(half_bay, 0.0, 0.0));
                rods.place(&rod(0.75, UPPER_SPRINGING - 0.12), &side.at(half_bay, 0.0, 0.0));
            }
        }
    }
    assembly.add("cloth", cloth, fabric);
    assembly.add("rods", rods, fabric);
}

/// A round rod along x from minus to plus `half_length`.
fn rod(half_length: f32, height: f32) -> Part {
    let end = |x: f32| (Vec3::new(x, height, 0.0), 0.025);
    tube(&[end(-half_length), end(half_length)], 8).smooth(50.0)
}

/// The curtains of one lower bay about its middle on the ground.
fn curtains(kind: &str, random: &mut Random) -> Vec<Faces> {
    let mut drape = |from: f32, to: f32, tied: f32| {
        Drape { from, to, top: 4.05, bottom: 0.1, tied, folds: 5.0 * (to - from).abs().max(0.8) }.hang(random)
    };
    match kind {
        // Drawn apart and tied back to both columns.
        "pair" => vec![drape(-1.22, -0.04, 0.30), drape(1.22, 0.04, 0.30)],
        "left" => vec![drape(-1.22, 0.35, 0.26)],
        "right" => vec![drape(1.22, -0.35, 0.26)],
        _ => vec![drape(-1.2, 1.2, 1.0)],
    }
}

/// A curtain that hangs along x between two places and may be tied back to the first.
struct Drape {
    from: f32,
    to: f32,
    top: f32,
    bottom: f32,
    /// Width where it is tied, over its width at the top; 1 hangs free.
    tied: f32,
    folds: f32,
}

impl Drape {
    fn hang(&self, random: &mut Random) -> Faces {
        let width = self.to - self.from;
        let (phase, wobble) = (TAU * random.unit(), TAU * random.unit());
        let (tie, height) = (0.36, self.top - self.bottom);
        let columns = (24.0 * width.abs()).ceil().max(28.0) as usize;
        let sheet = Faces::sheet(columns, 20, |u, v| {
            // Narrowest at the tie, with a rounded belly above it and a slight flare below.
            let pull = if v > tie {
                let t = (v - tie) / (1.0 - tie);
                self.tied + (1.0 - self.tied) * (1.0 - (1.0 - t).powf(2.2)).powf(1.2)
            } else {
                let t = (tie - v) / tie;
                self.tied + (1.0 - self.tied) * 0.32 * t.powf(0.8)
            };
            // Cloth drawn together folds deeper; at the rod it is held.
            let fullness = (0.055 + 0.055 * (1.0 - pull)) * (1.0 - 0.55 * v.powi(6));
            let angle = TAU * self.folds * u + phase + 0.9 * (TAU * 0.5 * v + wobble).sin() * (1.0 - v);
            let sway = 0.25 * (2.3 * angle + wobble).sin() * (1.0 - v);
            let free = if self.tied < 1.0 { u } else { u + 0.004 * (angle * 2.0).sin() };
            // The free edge of a tied curtain sweeps up to the rod: its lower hem rises with u.
            let hem = if self.tied < 1.0 {
                0.12 * u * u * (1.0 - v).powi(3)
            } else {
                0.02 * angle.sin() * (1.0 - v).powi(8)
            };
            Vec3::new(
                self.from + width * pull * free,
                self.bottom + height * (v + hem * 0.3),
                fullness * (angle.sin() + sway),
            )
        });
        // A curtain drawn from the right to the left would show its back.
        if width < 0.0 { sheet.flipped() } else { sheet }
    }
}

/// A banner hung over the balustrade before a pedestal, about the gallery's floor on the columns' axis.
fn banner(random: &mut Random) -> Faces {
    let (half_width, drop) = (0.5, 2.7);
    let (phase, turn) = (TAU * random.unit(), TAU * random.unit());
    let top = 0.99;
    Faces::sheet(14, 28, |u, v| {
        let x = half_width * (2.0 * u - 1.0);
        // From the hem in the court (v = 0) up to the rail and over it.
        let over_rail = 0.9;
        let point_down = 0.45 * (1.0 - (2.0 * u - 1.0).abs()) * (1.0 - v / over_rail).max(0.0).powi(2);
        let wave = 0.05 * (1.0 - v) * (TAU * 1.4 * u + phase + 2.0 * v).sin()
            + 0.035 * (1.0 - v) * (TAU * 0.8 * (1.0 - v) + turn).sin();
        if v < over_rail {
            let t = 1.0 - v / over_rail;
            Vec3::new(
                x * (1.0 - 0.06 * (PI * t).sin()),
                top - 0.28 - drop * t - point_down,
                0.80 - 0.52 * (1.0 - t).powi(8) + wave,
            )
        } else {
            let t = (v - over_rail) / (1.0 - over_rail);
            Vec3::new(x, top - 0.28 * (1.0 - t).powi(2) + 0.02 * t, 0.28 - 0.35 * t + wave * (1.0 - t))
        }
    })
}

/// A cloth between two upper columns, gathered at the rod, about the middle of their bay on the ground.
fn gallery_cloth(random: &mut Random) -> Faces {
    let (phase, wind) = (TAU * random.unit(), random.between(0.12, 0.3));
    let (top, bottom) = (UPPER_SPRINGING - 0.1, GALLERY + 1.05);
    Faces::sheet(28, 14, |u, v| {
        let down = 1.0 - v;
        let scallop = 0.1 * (PI * 3.0 * u).sin().abs() * down.powi(4);
        let angle = TAU * 4.5 * u + phase;
        let billow = wind * (PI * u).sin() * (0.85 * PI * down).sin();
        let z = (0.03 + 0.035 * down) * (angle + 0.8 * (3.0 * down).sin()).sin() + billow + 0.3 * down * down;
        Vec3::new(
            1.24 * (u - 0.5) * (1.0 - 0.08 * (PI * down).sin()),
            bottom + (top - bottom) * v + scallop,
            z,
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_sound, open_edges};

    #[test]
    fn cloth_is_sound_and_hangs_between_its_columns() {
        for seed in 0..8 {
            let mut random = Random::new(seed);
            let mut sheets = vec![banner(&mut random), gallery_cloth(&mut random)];
            for kind in ["pair", "left", "right", "full"] {
                sheets.extend(curtains(kind, &mut random));
            }
            for sheet in sheets {
                let part = sheet.smooth(CREASE_DEG);
                assert_sound(&part, "cloth");
                assert!(open_edges(&part) > 0, "cloth is a sheet");
                let reach = part.positions.iter().map(|p| p.x.abs()).fold(0.0, f32::max);
                assert!(reach < 1.4, "cloth reaches {reach} and meets the columns");
            }
        }
    }

    #[test]
    fn curtains_face_the_court() {
        let mut random = Random::new(1);
        for curtain in curtains("pair", &mut random) {
            let facing = curtain.smooth(CREASE_DEG).normals.iter().map(|n| n.z).sum::<f32>();
            assert!(facing > 0.0);
        }
    }
}
