//! Vases with plants, and ivy: leaves that are masked cards.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::masks;
use crate::builtin::part::Part;
use crate::builtin::random::{Random, value_noise};
use crate::builtin::shapes::{Card, Profile, frond, lathe, tube};
use conray_core::{Affine3A, Vec2, Vec3};
use std::f32::consts::TAU;

/// Adds vases along the court, their plants, and ivy on columns, walls and balustrade.
pub(crate) fn add(assembly: &mut Assembly) {
    let earthenware = assembly.opaque("earthenware");
    let fern = assembly.masked("fern leaves", masks::fern_frond());
    let broad = assembly.masked("broad leaves", masks::broad_leaf());
    let ivy = assembly.masked("ivy leaves", masks::ivy());
    let (mut ferns, mut shrubs, mut stems, mut climbers) =
        (Faces::default(), Faces::default(), Faces::default(), Faces::default());
    let mut random = Random::new(40);
    let (tall, low) = (tall_vase(), low_vase());
    let mut vases = Part::default();
    for (index, side) in Side::all().into_iter().filter(Side::is_long).enumerate() {
        for (i, x) in side.inner_columns(1).enumerate() {
            let at = side.at(x, -0.16, 0.98);
            if (i + index) % 2 == 0 {
                vases.place(&tall, &at);
                ferns.extend(
                    &fern_plant(&mut random).transformed(&(at * Affine3A::from_translation(0.86 * Vec3::Y))),
                );
            } else if i % 4 == 1 {
                vases.place(&low, &at);
                let (leaves, twigs) = shrub(&mut random);
                let top = at * Affine3A::from_translation(0.5 * Vec3::Y);
                shrubs.extend(&leaves.transformed(&top));
                stems.extend(&twigs.transformed(&top));
            }
        }
        for (column, cards) in [(1, 900), (2, 600), (5, 800)] {
            let x = (column as f32 + 1.0 - 4.0) * BAY;
            climbers.extend(&climbing_ivy(cards, &mut random).transformed(&side.at(x, 0.0, 0.0)));
        }
        for x in [-0.75 * BAY, 2.25 * BAY] {
            climbers.extend(&hanging_ivy(&mut random).transformed(&side.at(x, GALLERY, 0.0)));
        }
    }
    assembly.add("vases", vases, earthenware);
    assembly.add("ferns", ferns.smooth(60.0), fern);
    assembly.add("shrub leaves", shrubs.smooth(60.0), broad);
    assembly.add("shrub stems", stems.smooth(60.0), earthenware);
    assembly.add("ivy", climbers.smooth(60.0), ivy);
}

/// A vase 0.9 high with earth in it, about its foot.
fn tall_vase() -> Part {
    let profile = Profile::from_disc(0.24, -0.02)
        .to(0.24, 0.05)
        .torus(0.025, 0.11, 4)
        .spline(&[(0.15, 0.17), (0.28, 0.36), (0.38, 0.6), (0.3, 0.78), (0.29, 0.82)], 3)
        .flare(0.37, 0.9, 3)
        .to(0.37, 0.93)
        .to(0.33, 0.93)
        .to(0.28, 0.84)
        .ending_on_axis();
    lathe(&profile, 22).smooth(45.0)
}

/// A wide pot 0.55 high with earth in it, about its foot.
fn low_vase() -> Part {
    let profile = Profile::from_disc(0.3, -0.02)
        .to(0.3, 0.06)
        .spline(&[(0.36, 0.2), (0.42, 0.42)], 4)
        .to(0.46, 0.43)
        .to(0.47, 0.54)
        .to(0.41, 0.54)
        .to(0.39, 0.47)
        .ending_on_axis();
    lathe(&profile, 22).smooth(45.0)
}

/// Fronds that rise from the origin and bow over all round.
fn fern_plant(random: &mut Random) -> Faces {
    let mut faces = Faces::default();
    let count = 30;
    for i in 0..count {
        let t = i as f32 / count as f32;
        // By the golden angle, the inner ones steeper.
        let azimuth = 2.399_963 * i as f32 + random.about_zero(0.2);
        let outward = Vec3::new(azimuth.cos(), 0.0, azimuth.sin());
        let length = random.between(0.85, 1.2) * (1.0 - 0.2 * t);
        let base = outward * 0.07 + Vec3::Y * random.between(-0.02, 0.03);
        let bend = [0.85 + 0.65 * t + random.about_zero(0.12), 1.75 - 0.6 * t + random.about_zero(0.25)];
        faces.extend(&frond(base, outward, [length, 0.17 + 0.05 * random.unit()], bend, 0.3, 7));
    }
    faces
}

/// A small tree in a pot: forking stems with broad leaves; leaves first, then stems.
fn shrub(random: &mut Random) -> (Faces, Faces) {
    let (mut leaves, mut stems) = (Faces::default(), Faces::default());
    for i in 0..9 {
        let azimuth = TAU * i as f32 / 9.0 + random.about_zero(0.3);
        let outward = Vec3::new(azimuth.cos(), 0.0, azimuth.sin());
        let (height, spread) = (random.between(0.9, 1.5), random.between(0.2, 0.62));
        let at = |t: f32| outward * (0.06 + spread * t * t) + Vec3::Y * (height * t - 0.06);
        let points: Vec<(Vec3, f32)> =
            (0..5).map(|k| (at(k as f32 / 4.0), 0.018 - 0.003 * k as f32)).collect();
        stems.extend(&tube(&points, 6));
        for k in 0..22 {
            let t = 0.3 + 0.7 * (k as f32 + random.unit()) / 22.0;
            let turn = 2.399_963 * k as f32 + azimuth;
            let side = Vec3::new(turn.cos(), random.between(-0.1, 0.7), turn.sin()).normalize();
            let right = side.cross(Vec3::Y).normalize() + random.about_zero(0.5) * Vec3::Y;
            let length = random.between(0.2, 0.3);
            let card = Card {
                base: at(t) + 0.01 * side,
                along: length * side,
                right: 0.25 * length * right.reject_from(side).normalize(),
                fold: 0.05 * length,
            };
            card.add_to(&mut leaves);
        }
    }
    (leaves, stems)
}

/// Ivy that climbs a lower column and spreads over the wall above it, about the column's foot.
fn climbing_ivy(cards: usize, random: &mut Random) -> Faces {
    let mut faces = Faces::default();
    let seed = random.bits();
    let mut placed = 0;
    for _ in 0..20 * cards {
        if placed == cards {
            break;
        }
        let (angle, height) = (random.about_zero(2.0), random.between(0.3, GALLERY + 0.4));
        let on_wall = height > LOWER_SPRINGING - 0.1;
        // Dense in streaks that run upwards, thinner towards the top.
        let density = 0.75 + 0.9 * value_noise(Vec2::new(2.2 * angle, 0.55 * height), seed) - 0.09 * height;
        let across = angle * (0.45 + 0.1 * height);
        let in_opening = on_wall && height < LOWER_SPRINGING + 1.2 && {
            let dx = 0.5 * BAY - across.abs();
            dx.hypot(height - LOWER_SPRINGING) < super::arcades::LOWER_RADIUS + 0.05
        };
        if random.unit() > density || in_opening {
            continue;
        }
        let (foot, normal) = if on_wall {
            let out = if height > GALLERY - 0.6 { 0.68 } else { 0.42 };
            (Vec3::new(across, height, out), Vec3::Z)
        } else {
            let outward = Vec3::new(angle.sin(), 0.0, angle.cos());
            (outward * 0.38 + height * Vec3::Y, outward)
        };
        ivy_card(&mut faces, foot, normal, random);
        placed += 1;
    }
    faces
}

/// One card that hugs a surface and leans a little any way.
fn ivy_card(faces: &mut Faces, foot: Vec3, normal: Vec3, random: &mut Random) {
    let facing = (normal + 0.45 * random.direction() + 0.15 * Vec3::Y).normalize();
    let hang = (Vec3::NEG_Y + 1.1 * random.direction()).reject_from_normalized(facing).normalize_or(Vec3::Y);
    let size = random.between(0.14, 0.25);
    let base = foot + random.between(0.0, 0.09) * normal - 0.5 * size * hang;
    Card { base, along: size * hang, right: 0.5 * size * hang.cross(facing), fold: 0.0 }.add_to(faces);
}

/// Strands of ivy that hang over the balustrade into the court, about the gallery's floor.
fn hanging_ivy(random: &mut Random) -> Faces {
    let mut faces = Faces::default();
    for _ in 0..26 {
        let (x, length) = (random.about_zero(0.72), random.between(0.5, 1.0) * random.between(0.8, 2.3));
        let steps = (length / 0.11) as usize;
        let mut at = Vec3::new(x, 0.95, random.between(0.2, 0.3));
        for step in 0..steps {
            at.y -= 0.11;
            at.x += random.about_zero(0.03);
            // Out over the cornice, then straight down.
            at.z = if at.y < 0.05 { at.z.max(0.7) } else { at.z + 0.035 };
            if step % 2 == 0 || random.unit() < 0.6 {
                ivy_card(&mut faces, at, Vec3::Z, random);
            }
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn vases_are_closed_and_leaves_are_sound() {
        for (name, vase) in [("tall vase", tall_vase()), ("low vase", low_vase())] {
            assert_closed(&vase, name);
            assert_sound(&vase, name);
        }
        for seed in 0..6 {
            let random = &mut Random::new(seed);
            assert_sound(&fern_plant(random).smooth(60.0), "fern");
            let (leaves, stems) = shrub(random);
            assert_sound(&leaves.smooth(60.0), "shrub leaves");
            assert_closed(&stems.smooth(60.0), "shrub stems");
            let ivy = climbing_ivy(300, random);
            assert_eq!(ivy.triangles.len(), 600, "all cards found a place");
            assert_sound(&ivy.smooth(60.0), "ivy");
            assert_sound(&hanging_ivy(random).smooth(60.0), "hanging ivy");
        }
    }
}
