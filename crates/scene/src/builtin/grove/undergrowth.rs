//! Bushes, ferns, grass and stones.

use super::growth::{GOLDEN_ANGLE, Habit, Order};
use super::species::Foliage;
use super::tree::{Plant, foliage};
use crate::builtin::faces::{Faces, corner};
use crate::builtin::part::Part;
use crate::builtin::random::Random;
use crate::builtin::shapes::{Card, frond, icosphere, tube};
use conray_core::{Vec2, Vec3};

/// A bush about 1.5 high and wide: many stems from one foot, without a trunk.
pub(crate) fn bush(seed: u32) -> Plant {
    let random = &mut Random::new(seed);
    let stump = Order {
        count: 1,
        length: 1.0,
        radius: 1.0,
        angle_rad: [0.0; 2],
        first: 0.0,
        rise: 0.0,
        waver: 0.02,
        steps: 2,
    };
    let stems = Order {
        count: 26,
        length: 2.3,
        radius: 0.7,
        angle_rad: [1.15, 0.1],
        first: 0.3,
        rise: 0.45,
        waver: 0.2,
        steps: 5,
    };
    let twigs = Order {
        count: 6,
        length: 0.42,
        radius: 0.6,
        angle_rad: [0.9, 0.6],
        first: 0.3,
        rise: 0.1,
        waver: 0.2,
        steps: 3,
    };
    let habit = Habit { orders: &[stump, stems, twigs], crown: |s| 0.75 + 0.25 * s };
    let limbs = habit.grow(Vec3::new(0.0, -0.15, 0.0), 0.5, 0.035, random);
    let mut wood = Faces::default();
    limbs.iter().for_each(|limb| wood.extend(&tube(&limb.points, [6, 4, 3][limb.order])));
    let leaves = Foliage { per_limb: 14, length: [0.16, 0.26], width: 0.9, spread: 0.9, droop: 0.2 };
    Plant { wood: wood.smooth(75.0), leaves: foliage(&limbs, &leaves, random).smooth(70.0) }
}

/// A fern about a metre across.
pub(crate) fn fern(seed: u32) -> Part {
    let random = &mut Random::new(seed);
    let mut faces = Faces::default();
    let count = 16;
    for i in 0..count {
        let t = i as f32 / count as f32;
        let azimuth = GOLDEN_ANGLE * i as f32 + random.about_zero(0.25);
        let outward = Vec3::new(azimuth.cos(), 0.0, azimuth.sin());
        let size = [random.between(0.55, 0.85) * (1.0 - 0.2 * t), random.between(0.11, 0.16)];
        let bend = [0.8 + 0.6 * t + random.about_zero(0.15), 1.5 + random.about_zero(0.3)];
        faces.extend(&frond(outward * 0.03 - 0.05 * Vec3::Y, outward, size, bend, 0.25, 6));
    }
    faces.smooth(60.0)
}

/// A patch of grass about 1.4 m wide: upright cards that stand any way and bow over.
pub(crate) fn grass(seed: u32) -> Part {
    let random = &mut Random::new(seed);
    let mut faces = Faces::default();
    for _ in 0..46 {
        let (azimuth, away) = (std::f32::consts::TAU * random.unit(), 0.7 * random.unit().sqrt());
        let foot = away * Vec3::new(azimuth.cos(), 0.0, azimuth.sin()) - 0.06 * Vec3::Y;
        let turn = std::f32::consts::TAU * random.unit();
        let across = Vec3::new(turn.cos(), 0.0, turn.sin());
        let front = across.cross(Vec3::Y);
        let (width, height) = (random.between(0.24, 0.36), random.between(0.2, 0.42) * (1.15 - 0.5 * away));
        let lean = front * random.between(0.0, 0.35) * height;
        // Two quadrilaterals: the lower one upright, the upper one leaning.
        let middle = foot + 0.5 * height * Vec3::Y + 0.25 * lean;
        let top = foot + height * Vec3::Y + lean;
        let row = |p: Vec3, v: f32| {
            [corner(p - 0.5 * width * across, 0.0, v), corner(p + 0.5 * width * across, 1.0, v)]
        };
        for ([a, b], [d, c]) in [(row(foot, 0.0), row(middle, 0.5)), (row(middle, 0.5), row(top, 1.0))] {
            faces.quad(a, b, c, d);
        }
    }
    // A few seed heads that stand out.
    for _ in 0..4 {
        let base = Vec3::new(random.about_zero(0.5), -0.05, random.about_zero(0.5));
        let along = 0.5 * (Vec3::Y + 0.3 * random.direction()).normalize();
        let right = 0.12 * along.cross(random.direction()).normalize_or(Vec3::X);
        Card { base, along, right, fold: 0.0 }.add_to(&mut faces);
    }
    faces.smooth(60.0)
}

/// A stone about a metre wide, half sunk into the ground.
pub(crate) fn stone(seed: u32) -> Part {
    let random = &mut Random::new(seed);
    // A ball cut by planes, as frost breaks stones, then worn.
    let cuts: Vec<(Vec3, f32)> = (0..14).map(|_| (random.direction(), random.between(0.62, 0.9))).collect();
    let ball = icosphere(4);
    let shape = |p: Vec3| {
        let reach =
            cuts.iter().map(|&(normal, distance)| distance / p.dot(normal).max(0.05)).fold(1.0, f32::min);
        // A soft minimum rounds the edges.
        let soft: f32 =
            cuts.iter().map(|&(n, d)| (-26.0 * (d / p.dot(n).max(0.05) - reach).min(3.0)).exp()).sum::<f32>()
                + 1e-3;
        let radius = reach - soft.ln() / 26.0;
        radius * p * Vec3::new(0.62, 0.4, 0.5) + 0.06 * Vec3::Y
    };
    let mut faces = Faces::default();
    for t in &ball.triangles {
        let [a, b, c] = t.map(|v| {
            let p = shape(ball.positions[v as usize]);
            let uv: Vec2 = ball.uvs[v as usize];
            corner(p, uv.x, uv.y)
        });
        faces.triangle(a, b, c);
    }
    faces.smooth(50.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn undergrowth_is_sound() {
        for seed in 0..4 {
            let bush = bush(seed);
            assert_closed(&bush.wood, "bush twigs");
            assert_sound(&bush.wood, "bush twigs");
            assert_sound(&bush.leaves, "bush leaves");
            assert_sound(&fern(seed), "fern");
            assert_sound(&grass(seed), "grass");
            assert_sound(&stone(seed), "stone");
            assert_closed(&stone(seed), "stone");
            let width = bush.leaves.positions.iter().map(|p| p.x.hypot(p.z)).fold(0.0, f32::max);
            assert!((0.6..2.2).contains(&width), "the bush reaches {width}");
        }
    }
}
