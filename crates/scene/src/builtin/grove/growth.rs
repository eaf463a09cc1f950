//! How woody plants branch: limbs that fork to a given depth.
//!
//! A plain recursive model after Weber and Penn, "Creation and Rendering of Realistic Trees", 1995, with fewer parameters:
//! children leave their parent by a downward angle, turned round it by the golden angle, and each step of a limb bends
//! towards the sky and wavers.

use crate::builtin::random::Random;
use conray_core::{Quat, Vec3};

/// The golden angle in radians: successive children never stand above each other.
pub(crate) const GOLDEN_ANGLE: f32 = 2.399_963;

/// How limbs of one order grow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
    /// Limbs on each parent (1 for the trunk).
    pub(crate) count: usize,
    /// Length over the parent's length, before the crown's shape.
    pub(crate) length: f32,
    /// Radius at its foot over the parent's radius there.
    pub(crate) radius: f32,
    /// Angle from the parent's direction, at the parent's foot and at its tip.
    pub(crate) angle_rad: [f32; 2],
    /// Where along the parent the first limb stands, in [0, 1].
    pub(crate) first: f32,
    /// Bend towards the sky (or, negative, the ground) over the whole limb, as a share of its direction.
    pub(crate) rise: f32,
    /// Wavering of each step.
    pub(crate) waver: f32,
    /// Straight pieces of the limb.
    pub(crate) steps: usize,
}

/// One limb: points with the wood's radius there.
#[derive(Clone, Debug)]
pub(crate) struct Limb {
    /// 0 for the trunk.
    pub(crate) order: usize,
    pub(crate) points: Vec<(Vec3, f32)>,
}

impl Limb {
    /// Point, direction and radius at a share `t` in [0, 1] of the limb.
    pub(crate) fn at(&self, t: f32) -> (Vec3, Vec3, f32) {
        let spans = self.points.len() - 1;
        let position = t.clamp(0.0, 1.0) * spans as f32;
        let i = (position as usize).min(spans - 1);
        let ((a, from), (b, to)) = (self.points[i], self.points[i + 1]);
        let share = position - i as f32;
        (a.lerp(b, share), (b - a).normalize_or(Vec3::Y), from + (to - from) * share)
    }
}

/// A plan of growth: the orders, and how long first-order limbs are by their place on the trunk.
pub(crate) struct Habit<'a> {
    pub(crate) orders: &'a [Order],
    /// Length factor of a bough by its place in the crown, 0 at the crown's foot and 1 at its top.
    pub(crate) crown: fn(f32) -> f32,
}

impl Habit<'_> {
    /// All limbs of a plant whose trunk starts at `foot` with that length and radius, parents before their children.
    pub(crate) fn grow(&self, foot: Vec3, length: f32, radius: f32, random: &mut Random) -> Vec<Limb> {
        let mut limbs = Vec::new();
        self.limb(0, foot, Vec3::Y, length, radius, random, &mut limbs);
        limbs
    }

    #[expect(clippy::too_many_arguments, reason = "what a limb is made of, and where it goes")]
    fn limb(
        &self,
        order: usize,
        foot: Vec3,
        direction: Vec3,
        length: f32,
        radius: f32,
        random: &mut Random,
        limbs: &mut Vec<Limb>,
    ) {
        let rule = self.orders[order];
        let limb = Limb { order, points: wander(foot, direction, length, radius, rule, random) };
        let Some(child) = self.orders.get(order + 1).copied() else {
            limbs.push(limb);
            return;
        };
        let start = random.unit();
        limbs.push(limb.clone());
        for k in 0..child.count {
            let share = (k as f32 + random.unit()) / child.count as f32;
            let t = child.first + (0.98 - child.first) * share;
            let (point, along, thickness) = limb.at(t);
            let angle = child.angle_rad[0]
                + (child.angle_rad[1] - child.angle_rad[0]) * share
                + random.about_zero(0.12);
            let azimuth = GOLDEN_ANGLE * (k as f32 + start * 7.0) + random.about_zero(0.3);
            let side = Quat::from_axis_angle(along, azimuth) * along.any_orthonormal_vector();
            let outward = (along * angle.cos() + side * angle.sin()).normalize();
            let shape = if order == 0 { (self.crown)(share) } else { 1.0 - 0.55 * share };
            let child_length = length * child.length * shape * random.between(0.85, 1.15);
            let child_radius = (thickness * child.radius * (0.5 + 0.5 * shape)).max(0.004);
            self.limb(order + 1, point, outward, child_length, child_radius, random, limbs);
        }
    }
}

/// The points of one limb, with radii that shrink to a fifth.
fn wander(
    foot: Vec3,
    direction: Vec3,
    length: f32,
    radius: f32,
    rule: Order,
    random: &mut Random,
) -> Vec<(Vec3, f32)> {
    let (mut at, mut along) = (foot, direction);
    let mut points = vec![(foot, radius)];
    for i in 1..=rule.steps {
        let bend = rule.rise / rule.steps as f32 * Vec3::Y + rule.waver * random.direction();
        along = (along + bend).normalize_or(direction);
        at += along * (length / rule.steps as f32);
        points.push((at, radius * (1.0 - 0.8 * i as f32 / rule.steps as f32)));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(count: usize, length: f32) -> Order {
        Order {
            count,
            length,
            radius: 0.5,
            angle_rad: [1.0, 0.5],
            first: 0.3,
            rise: 0.2,
            waver: 0.05,
            steps: 4,
        }
    }

    #[test]
    fn limbs_have_their_numbers_and_start_on_their_parents() {
        let habit = Habit { orders: &[order(1, 1.0), order(5, 0.4), order(3, 0.5)], crown: |_| 1.0 };
        let limbs = habit.grow(Vec3::ZERO, 8.0, 0.2, &mut Random::new(4));
        let count = |o: usize| limbs.iter().filter(|l| l.order == o).count();
        assert_eq!([count(0), count(1), count(2)], [1, 5, 15]);
        for limb in limbs.iter().filter(|l| l.order > 0) {
            let foot = limb.points[0].0;
            let near =
                |parent: &Limb| (0..=1000).any(|i| parent.at(i as f32 / 1000.0).0.distance(foot) < 0.01);
            assert!(limbs.iter().any(|p| p.order + 1 == limb.order && near(p)), "a limb grows from nothing");
        }
    }

    #[test]
    fn limbs_have_their_length_and_taper() {
        let limb = Limb {
            order: 0,
            points: wander(Vec3::ONE, Vec3::X, 3.0, 0.5, order(1, 1.0), &mut Random::new(1)),
        };
        let length: f32 = limb.points.windows(2).map(|w| w[0].0.distance(w[1].0)).sum();
        assert!((length - 3.0).abs() < 1e-4);
        assert!(limb.points.windows(2).all(|w| w[1].1 < w[0].1 && w[1].1 > 0.0));
        assert_eq!(limb.at(0.0).0, Vec3::ONE);
        assert_eq!(limb.at(1.0).0, limb.points[4].0);
    }
}
