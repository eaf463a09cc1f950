//! The outer walls: ashlar below, plaster with pilasters above, doors and windows.

use super::plan::*;
use crate::builtin::assembly::Assembly;
use crate::builtin::faces::Faces;
use crate::builtin::part::{Part, USUAL_CREASE_DEG};
use crate::builtin::random::Random;
use crate::builtin::shapes::{ArchBay, chamfered_block, cuboid, mitred_ring, moulding_round_arch};
use conray_core::{Affine3A, Vec2, Vec3};

/// Adds them.
pub(crate) fn add(assembly: &mut Assembly, masonry: u32) {
    let shell = [(0.0, -0.45), (1.0, -0.45), (1.0, 15.0), (0.0, 15.0)].map(|(x, y)| Vec2::new(x, y));
    let coping = [(-0.08, 14.95), (1.05, 14.95), (1.05, 15.2), (0.5, 15.32), (-0.08, 15.2)]
        .map(|(x, y)| Vec2::new(x, y));
    let mut shells = mitred_ring(INSIDE, &shell);
    shells.extend(&mitred_ring(INSIDE, &coping));
    assembly.add("outer walls", shells.flat(), masonry);

    let (mut ashlar, mut joinery) = (Part::default(), Part::default());
    let (door, window) = (door().smooth(USUAL_CREASE_DEG), window().smooth(USUAL_CREASE_DEG));
    let mut random = Random::new(33);
    for side in Side::all() {
        // Everything on the wall is made about its foot, before the wall.
        let foot = |x: f32, y: f32| side.at(x, y, -side.depth);
        for (i, x) in side.bay_centres().enumerate() {
            let has_door = i % 3 == 1;
            add_ashlar(&mut ashlar, &|dx, y| foot(x + dx, y), 0.5 * BAY - 0.3, has_door, &mut random);
            if has_door {
                joinery.place(&door, &foot(x, 0.0));
            }
            joinery.place(&window, &foot(x, GALLERY));
        }
        // From the last pilaster to the corner of the building.
        let corner = if side.is_long() { INSIDE.x - COURT.x } else { INSIDE.y - COURT.y };
        for x in [-1.0, 1.0].map(|end| end * (side.half_length() + 0.5 * corner)) {
            add_ashlar(&mut ashlar, &|dx, y| foot(x + dx, y), 0.5 * corner - 0.3, true, &mut random);
            joinery.place(&door, &foot(x, 0.0));
            joinery.place(&window, &foot(x, GALLERY));
        }
        let pilaster = pilaster().flat();
        let columns = side.inner_columns(1).chain([-side.half_length(), side.half_length()]);
        for x in columns {
            ashlar.place(&pilaster, &foot(x, 0.0));
            ashlar.place(&gallery_pilaster().flat(), &foot(x, GALLERY));
        }
    }
    assembly.add("ashlar and pilasters", ashlar, masonry);
    assembly.add("doors and windows", joinery, masonry);
}

/// Ashlars over a stretch of wall that reaches `half` to both sides, in courses whose joints are staggered; none where a
/// door stands in the middle.
fn add_ashlar(
    part: &mut Part,
    at: &dyn Fn(f32, f32) -> Affine3A,
    half: f32,
    has_door: bool,
    random: &mut Random,
) {
    let (height, bottom, door_half) = (0.46, 0.44, 0.95);
    let blocks = (2.0 * half / 1.05).round();
    let length = 2.0 * half / blocks;
    for course in 0..8 {
        let y = bottom + height * (course as f32 + 0.5);
        let shift = if course % 2 == 0 { 0.0 } else { 0.5 };
        let free = if has_door && y < 3.4 { door_half } else { 0.0 };
        for block in 0..=blocks as usize {
            let left = (length * (block as f32 - shift) - half).max(-half);
            let right = (length * (block as f32 + 1.0 - shift) - half).min(half);
            // A block before the door's edge keeps the piece beside it.
            let pieces = [(left, right.min(-free)), (left.max(free), right)];
            for (left, right) in if free > 0.0 { pieces } else { [(left, right), (0.0, 0.0)] } {
                if right - left > 0.08 {
                    place_ashlar(part, at, (left, right), y, height, random);
                }
            }
        }
    }
}

fn place_ashlar(
    part: &mut Part,
    at: &dyn Fn(f32, f32) -> Affine3A,
    (left, right): (f32, f32),
    y: f32,
    height: f32,
    random: &mut Random,
) {
    let depth = random.between(0.09, 0.1);
    let block = chamfered_block(right - left - 0.006, height - 0.006, depth, 0.018).flat();
    part.place(&block, &(at(0.5 * (left + right), y) * Affine3A::from_translation(-0.05 * Vec3::Z)));
}

/// A pilaster with base and capital under each transverse arch, about its foot on the wall.
fn pilaster() -> Faces {
    let block = |half: f32, from: f32, to: f32, depth: f32| {
        cuboid(Vec3::new(-half, from, -0.1), Vec3::new(half, to, depth))
    };
    let mut faces = block(0.26, -0.06, LOWER_SPRINGING - 0.1, 0.27);
    faces.extend(&block(0.31, -0.07, 0.5, 0.33));
    faces.extend(&block(0.29, 0.45, 0.6, 0.305));
    faces.extend(&block(0.295, LOWER_SPRINGING - 0.42, LOWER_SPRINGING - 0.34, 0.3));
    faces.extend(&block(0.32, LOWER_SPRINGING - 0.2, LOWER_SPRINGING + 0.03, 0.36));
    faces
}

/// A flat pilaster from the gallery's floor to its ceiling.
fn gallery_pilaster() -> Faces {
    let top = CEILING - GALLERY;
    let mut faces = cuboid(Vec3::new(-0.2, -0.06, -0.1), Vec3::new(0.2, top + 0.06, 0.12));
    faces.extend(&cuboid(Vec3::new(-0.25, -0.07, -0.09), Vec3::new(0.25, 0.3, 0.17)));
    faces.extend(&cuboid(Vec3::new(-0.25, top - 0.5, -0.09), Vec3::new(0.25, top - 0.3, 0.17)));
    faces
}

/// An arched door with two panelled leaves, about its foot on the wall.
fn door() -> Faces {
    let (half, springing) = (0.72, 2.3);
    let mut faces = arched_frame(half, springing, 0.17, -0.05);
    faces.extend(&cuboid(
        Vec3::new(-half - 0.1, springing - 0.06, -0.05),
        Vec3::new(half + 0.1, springing + 0.06, 0.11),
    ));
    // Leaves of four panels each; nails would be too small to matter.
    for side in [-1.0, 1.0] {
        let x = 0.355 * side;
        let leaf = Affine3A::from_translation(Vec3::new(x, 1.12, -0.02));
        faces.extend(&chamfered_block(0.69, 2.3, 0.05, 0.015).transformed(&leaf));
        for (y, height) in [(0.42, 0.56), (1.02, 0.44), (1.52, 0.4), (1.98, 0.36)] {
            let panel = Affine3A::from_translation(Vec3::new(x, y, 0.0));
            faces.extend(&chamfered_block(0.5, height, 0.07, 0.035).transformed(&panel));
        }
    }
    faces.extend(&fanlight(half, springing));
    faces
}

/// Rays of iron in the half-round over a door.
fn fanlight(half: f32, springing: f32) -> Faces {
    let mut faces = Faces::default();
    for i in 1..8 {
        let angle = std::f32::consts::PI * i as f32 / 8.0;
        let bar = cuboid(Vec3::new(0.12, -0.015, -0.02), Vec3::new(half + 0.03, 0.015, 0.045));
        let turn = Affine3A::from_translation(springing * Vec3::Y) * Affine3A::from_rotation_z(angle);
        faces.extend(&bar.transformed(&turn));
    }
    faces
}

/// A pair of jambs and the arch over them, standing `depth` before the wall.
fn arched_frame(half: f32, springing: f32, depth: f32, foot: f32) -> Faces {
    let width = 0.2;
    let mut faces = Faces::default();
    for side in [-1.0, 1.0] {
        let (near, far) = (side * half, side * (half + width));
        let (min, max) = (near.min(far), near.max(far));
        faces.extend(&cuboid(Vec3::new(min, foot, -0.05), Vec3::new(max, springing + 0.01, depth)));
        faces.extend(&cuboid(
            Vec3::new(min - 0.04, springing - 0.12, -0.04),
            Vec3::new(max + 0.04, springing, depth + 0.04),
        ));
    }
    let bay = ArchBay { centre: 0.0, half_width: half + 0.002, rise: half + 0.002 };
    let profile =
        [(0.0, -0.045), (0.0, depth - 0.05), (0.05, depth - 0.005), (width, depth - 0.01), (width, -0.045)]
            .map(|(out, before)| Vec2::new(out, before));
    faces.extend(&moulding_round_arch(bay, springing - 0.005, 0.0, &profile, 18));
    faces
}

/// An arched window of the gallery with louvred shutters, about its foot on the wall.
fn window() -> Faces {
    let (half, sill, springing) = (0.55, 0.95, 2.55);
    let mut faces = arched_frame(half, springing, 0.13, sill);
    let ledge =
        cuboid(Vec3::new(-half - 0.32, sill - 0.03, -0.05), Vec3::new(half + 0.32, sill + 0.11, 0.24));
    faces.extend(&ledge);
    for side in [-1.0, 1.0] {
        let x = 0.275 * side;
        for edge in [-0.235, 0.235] {
            let stile = cuboid(
                Vec3::new(x + edge - 0.035, sill + 0.1, -0.05),
                Vec3::new(x + edge + 0.035, springing - 0.02, 0.06),
            );
            faces.extend(&stile);
        }
        for i in 0..10 {
            let slat = cuboid(Vec3::new(-0.22, -0.072, -0.008), Vec3::new(0.22, 0.072, 0.008));
            let at = Vec3::new(x, sill + 0.2 + 0.142 * i as f32, 0.02);
            let tilted = Affine3A::from_translation(at) * Affine3A::from_rotation_x(0.65);
            faces.extend(&slat.transformed(&tilted));
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::checks::{assert_closed, assert_sound};

    #[test]
    fn doors_windows_and_pilasters_are_closed_and_sound() {
        for (name, faces) in [
            ("door", door()),
            ("window", window()),
            ("pilaster", pilaster()),
            ("gallery pilaster", gallery_pilaster()),
        ] {
            let part = faces.smooth(USUAL_CREASE_DEG);
            assert_closed(&part, name);
            assert_sound(&part, name);
        }
    }

    #[test]
    fn ashlar_leaves_the_door_free() {
        for has_door in [false, true] {
            let mut part = Part::default();
            let at = |x: f32, y: f32| Affine3A::from_translation(Vec3::new(x, y, 0.0));
            add_ashlar(&mut part, &at, 1.4, has_door, &mut Random::new(1));
            assert_sound(&part, "ashlar");
            let in_door = part.positions.iter().filter(|p| p.x.abs() < 0.9 && p.y < 3.0).count();
            assert_eq!(in_door == 0, has_door);
        }
    }
}
