//! Trees: limbs with a skin of wood, and leaf cards on the outermost of them.

use super::growth::{GOLDEN_ANGLE, Habit, Limb};
use super::species::{Foliage, Species};
use crate::builtin::faces::Faces;
use crate::builtin::part::Part;
use crate::builtin::random::Random;
use crate::builtin::shapes::{Card, tube};
use conray_core::{Quat, Vec3};

/// A plant in two parts with different materials.
pub(crate) struct Plant {
    pub(crate) wood: Part,
    pub(crate) leaves: Part,
}

/// One tree of a kind, about its foot on the ground; the seed makes the individual.
pub(crate) fn tree(species: &Species, seed: u32) -> Plant {
    let random = &mut Random::new(seed);
    let habit = Habit { orders: &species.orders, crown: species.crown };
    // The trunk starts below the ground, which is not level.
    let foot = Vec3::new(0.0, -0.5, 0.0);
    let mut limbs = habit.grow(foot, species.height + 0.5, species.trunk_radius, random);
    // Roots: the trunk widens at its foot.
    for point in &mut limbs[0].points {
        point.1 += 0.55 * species.trunk_radius * (-(point.0.y.max(0.0)) / 0.5).exp();
    }
    let mut wood = Faces::default();
    for limb in &limbs {
        wood.extend(&tube(&limb.points, [12, 6, 4][limb.order]));
    }
    Plant { wood: wood.smooth(75.0), leaves: foliage(&limbs, &species.leaves, random).smooth(70.0) }
}

/// Cards on the outer parts of the limbs of the last order.
pub(crate) fn foliage(limbs: &[Limb], foliage: &Foliage, random: &mut Random) -> Faces {
    let last = limbs.iter().map(|limb| limb.order).max().unwrap_or(0);
    let mut faces = Faces::default();
    for limb in limbs.iter().filter(|limb| limb.order == last) {
        let start = 10.0 * random.unit();
        for k in 0..foliage.per_limb {
            let t = 0.12 + 0.88 * (k as f32 + random.unit()) / foliage.per_limb as f32;
            let (point, along, _) = limb.at(t);
            let azimuth = GOLDEN_ANGLE * (k as f32 + start);
            let side = Quat::from_axis_angle(along, azimuth) * along.any_orthonormal_vector();
            let lean = random.between(0.3, 1.0) * foliage.spread;
            let direction = along * (1.0 - 0.6 * lean) + side * lean
                - (foliage.droop * random.unit()) * Vec3::Y
                + 0.25 * random.direction();
            let direction = direction.normalize_or(along);
            // Leaves turn their faces to the sky, more or less.
            let facing = (Vec3::Y + 0.8 * random.direction()).reject_from_normalized(direction);
            let facing = facing.try_normalize().unwrap_or(direction.any_orthonormal_vector());
            let length = random.between(foliage.length[0], foliage.length[1]);
            let card = Card {
                base: point - 0.03 * direction,
                along: length * direction,
                right: 0.5 * foliage.width * length * direction.cross(facing),
                fold: 0.1 * length,
            };
            card.add_to(&mut faces);
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn trees_are_sound_and_their_wood_is_closed() {
        for (seed, species) in Species::all().iter().enumerate() {
            let plant = tree(species, seed as u32);
            assert_closed(&plant.wood, species.name);
            assert_sound(&plant.wood, species.name);
            assert_sound(&plant.leaves, species.name);
            let top = plant.leaves.positions.iter().map(|p| p.y).fold(0.0, f32::max);
            assert!((0.8..1.4).contains(&(top / species.height)), "{} is {top} high", species.name);
        }
    }
}
