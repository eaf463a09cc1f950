//! What holds for every built-in scene.

use super::checks::{assert_sound, defects, open_edges};
use super::part::{Part, USUAL_CREASE_DEG};
use super::shapes::{ArchBay, Profile, arcade_outline, cuboid, extruded_wall, icosphere, lathe, tube};
use super::{BUILTIN_NAMES, builtin};
use crate::Scene;
use conray_core::{Affine3A, Opacity, Vec2, Vec3};
use proptest::prelude::*;
use std::collections::HashSet;

fn scenes() -> Vec<Scene> {
    BUILTIN_NAMES.iter().map(|name| builtin(name).unwrap()).collect()
}

/// A stored mesh as a part.
fn part_of(mesh: &conray_core::TriangleMesh) -> Part {
    Part {
        positions: mesh.positions().to_vec(),
        normals: mesh.normals().to_vec(),
        uvs: mesh.uv_sets()[0].clone(),
        triangles: mesh.triangles().to_vec(),
    }
}

#[test]
fn names_are_known_and_others_are_not() {
    for scene in scenes() {
        assert!(BUILTIN_NAMES.contains(&scene.name.as_str()));
        assert!(scene.warnings.is_empty());
    }
    for unknown in ["", "Cornell", "sponza", "atrium "] {
        assert!(builtin(unknown).is_none());
    }
}

#[test]
fn all_meshes_are_sound_and_used() {
    for scene in scenes() {
        let used: HashSet<u32> = scene.geometry.instances().iter().map(|i| i.mesh).collect();
        assert_eq!(used.len(), scene.geometry.meshes().len());
        for mesh in scene.geometry.meshes() {
            assert_sound(&part_of(mesh), &format!("{}: {}", scene.name, mesh.name));
            let used_vertices: HashSet<u32> = mesh.triangles().iter().flatten().copied().collect();
            assert_eq!(used_vertices.len(), mesh.positions().len(), "{} has unused vertices", mesh.name);
        }
    }
}

#[test]
fn everything_is_closed_but_sheets() {
    // Leaves, cloth, tiles, reliefs and terrain are sheets, and so are walls and blocks of the Cornell box.
    let sheets = [
        ("cornell", &["white walls", "right wall", "left wall", "tall block"][..]),
        ("cornell-blocks", &["white walls", "right wall", "left wall", "tall block", "short block"]),
        ("atrium", &["lower columns", "lion heads", "tiles", "cloth", "ferns", "shrub leaves", "ivy"]),
        ("grove", &["ground", "leaves", "fern", "grass"]),
    ];
    for (scene, (name, sheets)) in scenes().iter().zip(sheets) {
        assert_eq!(scene.name, name);
        for mesh in scene.geometry.meshes() {
            let is_sheet = sheets.iter().any(|sheet| mesh.name.contains(sheet));
            let open = open_edges(&part_of(mesh));
            assert_eq!(open > 0, is_sheet, "{name}: {} has {open} open edges", mesh.name);
        }
    }
}

#[test]
fn no_triangle_of_the_atrium_is_there_twice() {
    let scene = builtin("atrium").unwrap();
    let mut all = Part::default();
    for instance in scene.geometry.instances() {
        assert_eq!(instance.world_from_mesh, Affine3A::IDENTITY);
        all.add(&part_of(&scene.geometry.meshes()[instance.mesh as usize]));
    }
    assert_sound(&all, "the whole atrium");
    all.triangles.push(all.triangles[1000]);
    assert_eq!(defects(&all).len(), 1);
}

#[test]
fn views_look_into_the_scene_from_within_its_bounds() {
    for scene in scenes() {
        assert!(scene.views.len() >= 2);
        let names: HashSet<&str> = scene.views.iter().map(|v| v.name.as_str()).collect();
        assert_eq!(names.len(), scene.views.len(), "names differ");
        let bounds = scene.geometry.bounds();
        for view in &scene.views {
            assert!(view.vertical_fov_deg > 20.0 && view.vertical_fov_deg < 80.0);
            let inside =
                |p: Vec3, slack: Vec3| p.cmpge(bounds.min - slack).all() && p.cmple(bounds.max + slack).all();
            assert!(inside(view.look_at, Vec3::ZERO), "{} of {}", view.name, scene.name);
            // The Cornell box is seen through its open front.
            let slack =
                if scene.name.starts_with("cornell") { Vec3::new(0.0, 0.0, 0.81) } else { Vec3::ZERO };
            assert!(inside(view.eye, slack), "{} of {}", view.name, scene.name);
        }
    }
}

#[test]
fn masks_cut_at_one_half_and_leave_part_open() {
    let mut masks = 0;
    for scene in scenes() {
        for material in scene.geometry.materials() {
            let Opacity::Texture(texture) = &material.opacity else { continue };
            masks += 1;
            assert!(material.double_sided);
            assert_eq!((texture.cutoff, texture.factor), (Some(0.5), 1.0));
            let n = 64;
            let at = |i: u32| Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let mean = (0..n * n).map(|i| texture.at(at(i))).sum::<f32>() / (n * n) as f32;
            assert!((0.2..0.8).contains(&mean), "{} of {} covers {mean}", material.name, scene.name);
        }
    }
    assert!(masks >= 7, "three masks in the atrium, at least four in the grove");
}

#[test]
fn two_calls_give_identical_arrays() {
    for (a, b) in scenes().iter().zip(scenes()) {
        assert_eq!(a.views, b.views);
        assert_eq!(a.geometry.meshes().len(), b.geometry.meshes().len());
        for (m, n) in a.geometry.meshes().iter().zip(b.geometry.meshes()) {
            assert!(m.positions() == n.positions() && m.triangles() == n.triangles(), "{}", m.name);
            assert!(m.normals() == n.normals() && m.uv_sets() == n.uv_sets(), "{}", m.name);
        }
        assert_eq!(a.geometry.instances().len(), b.geometry.instances().len());
        for (i, j) in a.geometry.instances().iter().zip(b.geometry.instances()) {
            assert!(i.world_from_mesh == j.world_from_mesh && i.mesh == j.mesh && i.name == j.name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn boxes_of_any_size_and_place_are_sound(
        min in prop::array::uniform3(-1e4f32..1e4), size in prop::array::uniform3(0.05f32..1e3),
    ) {
        let (min, size) = (Vec3::from_array(min), Vec3::from_array(size));
        let part = cuboid(min, min + size).smooth(USUAL_CREASE_DEG);
        prop_assert!(defects(&part).is_empty());
        prop_assert_eq!(open_edges(&part), 0);
    }

    #[test]
    fn walls_of_any_arches_are_closed_and_sound(
        widths in prop::collection::vec((0.2f32..2.0, 0.1f32..3.0), 1..5), steps in 2usize..30,
    ) {
        let mut from = 0.0;
        let bays: Vec<ArchBay> = widths.iter().map(|&(half_width, rise)| {
            let centre = from + 0.1 + half_width;
            from = centre + half_width;
            ArchBay { centre, half_width, rise }
        }).collect();
        let outline = arcade_outline(0.0, from + 0.1, 1.0, &bays, steps);
        let part = extruded_wall(&outline, 4.5, Vec2::new(-0.3, 0.3)).smooth(USUAL_CREASE_DEG);
        prop_assert!(defects(&part).is_empty());
        prop_assert_eq!(open_edges(&part), 0);
    }

    #[test]
    fn tubes_through_any_points_are_closed(
        points in prop::collection::vec((prop::array::uniform3(-3f32..3.0), 0.01f32..0.5), 2..9), sides in 3usize..12,
    ) {
        // Points may coincide or turn back: the tube may fold over itself, but stays closed and finite.
        let points: Vec<(Vec3, f32)> = points.into_iter().map(|(p, r)| (Vec3::from_array(p), r)).collect();
        let part = tube(&points, sides).smooth(75.0);
        prop_assert!(part.positions.iter().chain(&part.normals).all(|p| p.is_finite()));
        prop_assert_eq!(open_edges(&part), 0);
    }

    #[test]
    fn turned_solids_are_closed_and_placed_copies_stay_sound(
        radii in prop::collection::vec(0.05f32..2.0, 1..8), turn in 0f32..6.3,
        scale in prop::array::uniform3(prop_oneof![-2f32..-0.5, 0.5f32..2.0]), segments in 3usize..20,
    ) {
        let mut profile = Profile::from_disc(radii[0], 0.0);
        for (i, &radius) in radii.iter().enumerate() {
            profile = profile.to(radius, 0.5 * (i + 1) as f32);
        }
        let solid = lathe(&profile.ending_on_axis(), segments).smooth(USUAL_CREASE_DEG);
        let mut part = Part::default();
        part.place(&solid, &(Affine3A::from_rotation_y(turn) * Affine3A::from_scale(Vec3::from_array(scale))));
        part.place(&icosphere(1), &Affine3A::from_translation(20.0 * Vec3::X));
        prop_assert!(defects(&part).is_empty(), "{:?}", defects(&part));
        prop_assert_eq!(open_edges(&part), 0);
    }

    #[test]
    fn no_name_panics(name in ".{0,20}") {
        prop_assert_eq!(builtin(&name).is_some(), BUILTIN_NAMES.contains(&name.as_str()));
    }
}
