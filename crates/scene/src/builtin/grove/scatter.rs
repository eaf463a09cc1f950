//! Where plants and stones stand.

use super::terrain::{REACH, height, path_distance};
use crate::builtin::random::{Random, value_noise};
use conray_core::{Vec2, Vec3};
use std::f32::consts::TAU;

/// How one kind of thing is strewn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    /// How many; fewer where there is no room.
    pub(crate) count: usize,
    /// Least distance between two, in metres; 0 for any.
    pub(crate) spacing: f32,
    /// Least distance from the middle of the path.
    pub(crate) path: f32,
    /// Strength of clustering, from 0 (even) to 1 (in patches only).
    pub(crate) patches: f32,
    /// Least and greatest uniform scale.
    pub(crate) scale: [f32; 2],
}

impl Rule {
    pub(crate) const TREES: Self =
        Self { count: 340, spacing: 4.8, path: 3.0, patches: 0.0, scale: [0.75, 1.25] };
    pub(crate) const BUSHES: Self =
        Self { count: 420, spacing: 2.2, path: 2.0, patches: 0.6, scale: [0.6, 1.2] };
    pub(crate) const FERNS: Self =
        Self { count: 1600, spacing: 0.7, path: 1.3, patches: 0.8, scale: [0.6, 1.3] };
    pub(crate) const STONES: Self =
        Self { count: 260, spacing: 1.0, path: 0.9, patches: 0.5, scale: [0.25, 1.5] };
    pub(crate) const GRASS: Self =
        Self { count: 17_000, spacing: 0.0, path: 0.85, patches: 0.45, scale: [0.6, 1.3] };
}

/// One place: on the ground, turned about the vertical, scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) position: Vec3,
    pub(crate) turn_rad: f32,
    pub(crate) scale: f32,
}

/// Places by a rule, by throwing darts: a dart too near to an earlier one, to the path or outside a patch is dropped.
pub(crate) fn scatter(rule: &Rule, random: &mut Random) -> Vec<Place> {
    let seed = random.bits();
    let mut places: Vec<Place> = Vec::with_capacity(rule.count);
    // Within the ground, so that crowns may lean over its edge but feet do not.
    let reach = REACH - 1.5;
    for _ in 0..40 * rule.count {
        if places.len() == rule.count {
            break;
        }
        let (x, z) = (random.about_zero(reach), random.about_zero(reach));
        let (turn_rad, scale, keep) =
            (TAU * random.unit(), random.between(rule.scale[0], rule.scale[1]), random.unit());
        let density = 1.0 - rule.patches * (0.5 - 1.1 * value_noise(Vec2::new(x, z) / 6.0, seed));
        if path_distance(x, z) < rule.path || keep > density {
            continue;
        }
        let near = |p: &Place| Vec2::new(p.position.x - x, p.position.z - z).length() < rule.spacing;
        if rule.spacing > 0.0 && places.iter().any(near) {
            continue;
        }
        places.push(Place { position: Vec3::new(x, height(x, z), z), turn_rad, scale });
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_keep_their_distances() {
        for rule in [Rule::TREES, Rule::BUSHES, Rule::STONES] {
            let places = scatter(&rule, &mut Random::new(5));
            assert_eq!(places.len(), rule.count);
            for (i, a) in places.iter().enumerate() {
                assert!(path_distance(a.position.x, a.position.z) >= rule.path);
                assert!(a.position.x.abs() < REACH && a.position.z.abs() < REACH);
                assert!((rule.scale[0]..rule.scale[1]).contains(&a.scale));
                for b in &places[..i] {
                    let apart = Vec2::new(a.position.x - b.position.x, a.position.z - b.position.z).length();
                    assert!(apart >= rule.spacing);
                }
            }
        }
    }
}
