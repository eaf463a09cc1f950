//! Lion heads in relief, and the basins below them.

use super::plan::Side;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::{Faces, corner};
use crate::builtin::part::{Part, USUAL_CREASE_DEG};
use crate::builtin::shapes::{Profile, lathe, tube};
use conray_core::{Affine3A, Vec2, Vec3};
use std::f32::consts::TAU;

/// Adds one to the closed bay at either end of the court.
pub(crate) fn add(assembly: &mut Assembly, stone: u32) {
    let (head, frame) = (lion_head(), frame());
    let (basin, spout) = (basin(), spout());
    let mut part = Part::default();
    for side in Side::all().iter().filter(|side| !side.is_long()) {
        for piece in [&head, &frame] {
            part.place(piece, &(side.at(0.0, 2.45, 0.165) * Affine3A::from_scale(Vec3::splat(0.88))));
        }
        part.place(&spout, &side.at(0.0, 2.075, 0.3));
        part.place(&basin, &side.at(0.0, -0.16, 1.15));
    }
    assembly.add("lion heads", part, stone);
}

/// Height over the disc of radius 1, y up: mane, face, brow, eyes, muzzle, nose, jaws, ears.
fn lion_height(p: Vec2) -> f32 {
    let bump = |x: f32, y: f32, rx: f32, ry: f32, height: f32| {
        let d = ((p.x - x) / rx).powi(2) + ((p.y - y) / ry).powi(2);
        height * (1.0 - d).max(0.0).powi(2)
    };
    let twins = |x: f32, y: f32, rx: f32, ry: f32, height: f32| {
        bump(x, y, rx, ry, height) + bump(-x, y, rx, ry, height)
    };
    let (radius, angle) = (p.length(), p.x.atan2(p.y));
    // Two rings of locks, each lock a ridge that tapers outwards and leans.
    let ring = |count: f32, lean: f32, from: f32, to: f32, height: f32| {
        let t = (radius - from) / (to - from);
        if !(0.0..1.0).contains(&t) {
            return 0.0;
        }
        let ridge = (0.5 * count * angle + lean * (4.0 * t).sin()).cos().abs();
        height * ridge.powf(0.7) * (t * (1.0 - t) * 4.0).powf(0.6)
    };
    let mane = ring(18.0, 0.35, 0.58, 0.98, 0.16).max(ring(15.0, -0.35, 0.5, 0.86, 0.27));
    let face = bump(0.0, 0.0, 0.9, 1.0, 0.42);
    let brow = twins(0.2, 0.3, 0.28, 0.15, 0.17)
        + bump(0.0, 0.44, 0.24, 0.34, 0.1)
        + bump(0.0, 0.33, 0.05, 0.2, -0.06);
    let eyes = twins(0.21, 0.14, 0.2, 0.14, -0.2) + twins(0.21, 0.13, 0.115, 0.085, 0.13);
    let nose = bump(0.0, 0.05, 0.17, 0.46, 0.22)
        + bump(0.0, -0.13, 0.19, 0.13, 0.17)
        + twins(0.075, -0.17, 0.06, 0.05, -0.12);
    let muzzle = twins(0.16, -0.27, 0.3, 0.22, 0.26) + bump(0.0, -0.3, 0.05, 0.16, -0.12);
    let jaws = bump(0.0, -0.43, 0.27, 0.12, -0.34) + bump(0.0, -0.58, 0.26, 0.17, 0.2);
    let cheeks = twins(0.42, -0.1, 0.24, 0.36, 0.14);
    let ears = twins(0.46, 0.55, 0.2, 0.22, 0.3) + twins(0.45, 0.53, 0.11, 0.13, -0.2);
    mane + face + brow + eyes + nose + muzzle + jaws + cheeks + ears
}

/// The relief over the unit disc, facing +z; its rim lies at z = 0, where the wall hides it.
fn lion_head() -> Part {
    let (rings, spokes) = (38, 88);
    let at = |ring: usize, spoke: usize| {
        let angle = TAU * (spoke % spokes) as f32 / spokes as f32;
        let radius = ring as f32 / rings as f32;
        let p = if ring == 0 { Vec2::ZERO } else { radius * Vec2::new(angle.cos(), angle.sin()) };
        let z = if ring == rings { 0.0 } else { 0.02 + lion_height(p) };
        corner(p.extend(z), 0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y)
    };
    let mut faces = Faces::default();
    for ring in 0..rings {
        for spoke in 0..spokes {
            faces.quad(at(ring, spoke), at(ring + 1, spoke), at(ring + 1, spoke + 1), at(ring, spoke + 1));
        }
    }
    faces.smooth(75.0)
}

/// A turned rim round the relief, facing +z.
fn frame() -> Part {
    let ring =
        [(0.97, -0.04), (1.14, -0.04), (1.14, 0.05), (1.10, 0.1), (1.05, 0.1), (1.03, 0.07), (0.99, 0.06)];
    let section: Vec<Vec2> = ring.iter().map(|&(r, y)| Vec2::new(r, y)).collect();
    let rings: Vec<Vec<Vec3>> = (0..48)
        .map(|i| {
            let turn = Affine3A::from_rotation_z(TAU * i as f32 / 48.0);
            // Against the order of the section, so that it is right-handed about the path.
            section.iter().rev().map(|p| turn.transform_point3(Vec3::new(p.x, 0.0, p.y))).collect()
        })
        .collect();
    let faces = crate::builtin::shapes::loft(&rings, crate::builtin::shapes::Ends::Joined);
    faces.smooth(USUAL_CREASE_DEG)
}

/// The pipe in the lion's mouth.
fn spout() -> Part {
    tube(&[(Vec3::new(0.0, 0.02, -0.1), 0.035), (Vec3::new(0.0, 0.0, 0.45), 0.03)], 12).smooth(50.0)
}

/// A round basin on a foot, hollow, about the ground.
fn basin() -> Part {
    let profile = Profile::from_disc(0.62, -0.03)
        .to(0.62, 0.1)
        .torus(0.04, 0.2, 4)
        .spline(&[(0.34, 0.34), (0.4, 0.48), (0.78, 0.66), (0.86, 0.78)], 4)
        .to(0.9, 0.8)
        .torus(0.03, 0.9, 5)
        .to(0.8, 0.9)
        .spline(&[(0.77, 0.84), (0.62, 0.7), (0.2, 0.62)], 4)
        .ending_on_axis();
    lathe(&profile, 32).smooth(50.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound, open_edges};

    #[test]
    fn the_lion_is_sound_and_its_rim_is_one_circle() {
        let head = lion_head();
        assert_sound(&head, "lion head");
        assert_eq!(open_edges(&head), 88);
        let highest = head.positions.iter().map(|p| p.z).fold(0.0, f32::max);
        assert!((0.4..1.0).contains(&highest), "the lion stands out by {highest}");
    }

    #[test]
    fn frame_spout_and_basin_are_closed() {
        for (name, part) in [("frame", frame()), ("spout", spout()), ("basin", basin())] {
            assert_closed(&part, name);
            assert_sound(&part, name);
        }
    }
}
