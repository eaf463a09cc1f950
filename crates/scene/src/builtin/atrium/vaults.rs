//! The ceilings of the lower arcade: groin vaults between transverse arches.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::{Faces, corner};
use crate::builtin::part::{Part, USUAL_CREASE_DEG};
use crate::builtin::shapes::{ArchBay, arcade_outline, extruded_wall};
use conray_core::{Affine3A, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Height of the vaults' crowns above the springing.
const RISE: f32 = 1.32;
/// Half the thickness of the transverse arches.
const RIB: f32 = 0.2;
/// Height above the springing at which vaults and arches end inside the gallery's floor.
const TOP: f32 = GALLERY - 0.45 - LOWER_SPRINGING;

/// Adds a vault for every bay and corner, and an arch between each two.
pub(crate) fn add(assembly: &mut Assembly, stone: u32) {
    let (mut vaults, mut ribs) = (Part::default(), Part::default());
    // Vaults run two centimetres into the arches and walls around them.
    let overlap = 0.02;
    for side in Side::all() {
        let (from, to) = (LOWER_HALF_THICKNESS - overlap, side.depth + overlap);
        let half = Vec2::new(0.5 * BAY - RIB + overlap, 0.5 * (to - from));
        let vault = groin_vault(half, RISE, TOP, 7).smooth(USUAL_CREASE_DEG);
        for x in side.bay_centres() {
            vaults.place(&vault, &side.at(x, LOWER_SPRINGING, -0.5 * (from + to)));
        }
        let rib = transverse_arch(side.depth).smooth(USUAL_CREASE_DEG);
        let columns = side.inner_columns(1).chain([-side.half_length(), side.half_length()]);
        columns.for_each(|x| ribs.place(&rib, &side.at(x, 0.0, 0.0)));
    }
    let half = 0.5 * (INSIDE - COURT - RIB) + overlap;
    let vault = groin_vault(half, RISE, TOP, 9).smooth(USUAL_CREASE_DEG);
    for signs in corners().map(Vec3::signum) {
        let middle = 0.5 * (INSIDE + COURT + RIB);
        let centre = Vec3::new(signs.x * middle.x, LOWER_SPRINGING, signs.z * middle.y);
        vaults.place(&vault, &Affine3A::from_translation(centre));
    }
    assembly.add("vaults", vaults, stone);
    assembly.add("transverse arches", ribs, stone);
}

/// An arch across the arcade at x = 0 of a side, from the back of the columns to the outer wall.
fn transverse_arch(depth: f32) -> Faces {
    // Between the abacus of the column and the pilaster at the wall.
    let (near, far) = (0.40, depth - 0.34);
    let bay = ArchBay { centre: 0.5 * (near + far), half_width: 0.5 * (far - near), rise: RISE - 0.16 };
    let outline = arcade_outline(0.15, depth + 0.05, LOWER_SPRINGING, &[bay], 22);
    let wall = extruded_wall(&outline, LOWER_SPRINGING + TOP - 0.03, Vec2::new(-RIB, RIB));
    // The wall runs along +x: turn it so that it runs along -z.
    wall.transformed(&Affine3A::from_rotation_y(FRAC_PI_2))
}

/// The solid between two crossing half-elliptic barrels below and the plane y = `top` above, over a rectangle that
/// reaches to plus and minus `half` in x and z. The corners are at y = 0 and the crown at `rise`.
///
/// Each of its four webs is part of one barrel: with s the larger and t s the smaller of |x| and |z| over their halves, the
/// barrel along the larger has height sqrt(1 - (t s)^2).
fn groin_vault(half: Vec2, rise: f32, top: f32, steps: usize) -> Faces {
    // Sines make the steps even along the ellipses; their ends are exact, so that neighbouring webs share their groins.
    let sine = |i: usize| match i {
        0 => 0.0,
        _ if i == steps => 1.0,
        _ => (FRAC_PI_2 * i as f32 / steps as f32).sin(),
    };
    let across: Vec<f32> =
        (0..=2 * steps).map(|i| if i < steps { -sine(steps - i) } else { sine(i - steps) }).collect();
    let mut faces = Faces::default();
    for [x, z] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
        // The web towards (x, z); positive t lies towards (z, -x), left of it seen from above.
        let point = |s: f32, t: f32| {
            let (along, beside) = (Vec2::new(x, z), Vec2::new(z, -x) * t);
            let plan = half * ((along + beside) * s);
            let y = rise * (1.0 - (t * s) * (t * s)).max(0.0).sqrt();
            corner(Vec3::new(plan.x, y, plan.y), plan.x, plan.y)
        };
        let raised = |c: crate::builtin::faces::Corner| corner(Vec3 { y: top, ..c.position }, c.uv.x, c.uv.y);
        for (t, next) in across.iter().zip(&across[1..]).map(|(&t, &next)| (t, next)) {
            for i in 0..steps {
                let (s, outer) = (sine(i), sine(i + 1));
                faces.quad(point(s, t), point(s, next), point(outer, next), point(outer, t));
            }
            let (a, b) = (point(1.0, t), point(1.0, next));
            faces.quad(a, b, raised(b), raised(a));
            faces.triangle(raised(a), raised(b), corner(Vec3::Y * top, 0.0, 0.0));
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound, volume};

    #[test]
    fn vaults_and_ribs_are_closed() {
        let vault = groin_vault(Vec2::new(1.4, 2.6), 1.3, 1.7, 24);
        assert_closed(&vault.smooth(USUAL_CREASE_DEG), "vault");
        assert_sound(&vault.smooth(USUAL_CREASE_DEG), "vault");
        let below = unit_volume() * 1.4 * 2.6 * 1.3;
        let expected = 2.8 * 5.2 * 1.7 - below;
        assert!((volume(&vault) - expected).abs() < 2e-3 * expected, "{} against {expected}", volume(&vault));
        let rib = transverse_arch(5.6).smooth(USUAL_CREASE_DEG);
        assert_closed(&rib, "rib");
        assert!(rib.positions.iter().all(|p| p.z < 0.0), "ribs run back from the columns");
    }

    /// Volume under max(sqrt(1 - x^2), sqrt(1 - z^2)) over the square of half side 1.
    ///
    /// Both barrels have pi / 2 times 2 = pi, their common part is half Steinmetz's solid, 8 / 3 (the smaller of the two).
    fn unit_volume() -> f32 {
        2.0 * std::f32::consts::PI - 8.0 / 3.0
    }
}
