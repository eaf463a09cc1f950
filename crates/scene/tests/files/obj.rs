//! OBJ: what its faces may look like.

use crate::support::{count, load, load_with, only_mesh, world_corners};
use conray_core::{Vec2, Vec3};
use conray_scene::WarningKind;
use proptest::prelude::*;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn indices_count_from_the_start_or_back_from_the_face() {
    let forward = load("a.obj", format!("{SQUARE}f 1 2 3\nv 9 9 9\nf 3 4 1\nf 1 2 5")).unwrap();
    let back = load("a.obj", format!("{SQUARE}f -4 -3 -2\nv 9 9 9\nf -3 -2 -5\nf -5 -4 -1")).unwrap();
    assert_eq!(world_corners(&forward), world_corners(&back));
    let other = load("a.obj", format!("{SQUARE}f -4 -3 -1\nv 9 9 9\nf -3 -2 -5\nf -5 -4 -1")).unwrap();
    assert_ne!(world_corners(&forward), world_corners(&other), "the oracle must be able to fail");
}

#[test]
fn a_face_may_come_before_its_vertices() {
    let scene = load("a.obj", format!("f 1 2 3\n{SQUARE}")).unwrap();
    assert_eq!(world_corners(&scene), [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y]);
}

#[test]
fn corners_of_all_four_kinds_mix_in_one_file() {
    let text = format!(
        "{SQUARE}vt 0.25 0.5\nvt 0.75 1\nvn 0 0 1\nf 1 2 3\nf 1/1 3/2 4/1\nf 1//1 2//1 4//1\nf 2/2/1 3/1/1 4/2/1"
    );
    let scene = load("a.obj", text).unwrap();
    let mesh = only_mesh(&scene);
    assert_eq!(mesh.triangles().len(), 4);
    assert_eq!(mesh.corner_uvs(0, 0), [Vec2::ZERO; 3]);
    assert_eq!(mesh.corner_uvs(1, 0), [Vec2::new(0.25, 0.5), Vec2::new(0.75, 1.0), Vec2::new(0.25, 0.5)]);
    assert_eq!(mesh.corner_uvs(2, 0), [Vec2::ZERO; 3]);
    assert_eq!(mesh.corner_uvs(3, 0)[0], Vec2::new(0.75, 1.0));
    assert!(mesh.normals().iter().all(|n| *n == Vec3::Z));
}

#[test]
fn corners_that_agree_become_one_vertex_and_others_do_not() {
    let scene =
        load("a.obj", format!("{SQUARE}vt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/2/1 4/1/1"))
            .unwrap();
    assert_eq!(only_mesh(&scene).positions().len(), 5, "vertex 3 has two UVs");
}

#[test]
fn polygons_are_cut_within_their_outline() {
    // A concave pentagon: the fan about its first corner would leave it.
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nf 2 3 4 5 1\n";
    let corners = world_corners(&load("a.obj", text).unwrap());
    assert_eq!(corners.len(), 9);
    let area = |t: &[Vec3]| 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).z;
    let sum: f32 = corners.chunks(3).map(area).sum();
    let absolute: f32 = corners.chunks(3).map(|t| area(t).abs()).sum();
    assert!((sum - 2.5).abs() < 1e-6 && (absolute - 2.5).abs() < 1e-6, "{sum} {absolute}");
}

#[test]
fn line_ends_continuations_and_comments_change_nothing() {
    let plain = load("a.obj", format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    let odd = format!("\u{feff}# made \\\n  {SQUARE}\t f  1 2 \\\n 3 4 # four\n").replace('\n', "\r\n");
    assert_eq!(world_corners(&plain), world_corners(&load("a.obj", odd).unwrap()));
    let mac = format!("{SQUARE}f 1 2 3 4").replace('\n', "\r");
    assert_eq!(world_corners(&plain), world_corners(&load("a.obj", mac).unwrap()));
}

#[test]
fn vertex_weights_and_colours_are_let_be() {
    let scene = load("a.obj", "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 1 1 1\nf 1 2 3").unwrap();
    assert_eq!(world_corners(&scene), [Vec3::ZERO, Vec3::X, Vec3::Y]);
}

#[test]
fn one_mesh_for_each_object_and_material() {
    let text = format!(
        "{SQUARE}usemtl a\no one\nf 1 2 3\nusemtl b\nf 1 3 4\no two\ng inner\nf 1 2 4\no one\nusemtl a\nf 2 3 4\n"
    );
    let mtl: &[u8] = b"newmtl b\nnewmtl a\nnewmtl unused\n";
    let scene = load_with("a.obj", format!("mtllib m.mtl\n{text}"), &[("m.mtl", mtl)]).unwrap();
    let g = &scene.geometry;
    let found: Vec<_> = (0..g.instances().len())
        .map(|i| (g.instances()[i].name.as_str(), g.mesh_of(i)))
        .map(|(name, mesh)| {
            (name, g.materials()[mesh.material as usize].name.as_str(), mesh.triangles().len())
        })
        .collect();
    assert_eq!(found, [("one", "a", 2), ("one", "b", 1), ("two", "b", 1)]);
    assert!(g.meshes().iter().zip(g.instances()).all(|(mesh, instance)| mesh.name == instance.name));
    assert_eq!(g.materials().len(), 2, "only those in use");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn groups_name_objects_where_nothing_else_does() {
    let scene = load("a.obj", format!("{SQUARE}g left wall\nf 1 2 3\ng\nf 1 3 4\n")).unwrap();
    let names: Vec<_> = scene.geometry.meshes().iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["left wall", ""]);
}

#[test]
fn geometric_defects_are_counted() {
    let text = format!(
        "{SQUARE}v 5 5 5\nv 0.5 0 0\nvn 0 0 -1\nf 1 2 3\nf 3 1 2\nf 2 1 3\nf 1//1 2//1 4//1\nf 1 6 2\nf 1 2\nf 1 1 2\nl 1 2\np 3\n"
    );
    let scene = load("a.obj", text).unwrap();
    let counts = [
        (WarningKind::DuplicateTriangles, 2),
        (WarningKind::FlippedTriangles, 1),
        (WarningKind::DegenerateTriangles, 1),
        (WarningKind::UnusedVertices, 1),
        (WarningKind::IgnoredFaces, 2),
        (WarningKind::IgnoredPrimitives, 2),
    ];
    for (kind, expected) in counts {
        assert_eq!(count(&scene, kind), expected, "{kind}");
    }
    assert_eq!(scene.geometry.triangle_count(), 5);
    let sound = load("a.obj", format!("{SQUARE}f 1 2 3 4")).unwrap();
    assert!(sound.warnings.is_empty(), "{:?}", sound.warnings);
}

#[test]
fn unknown_statements_are_passed_over_and_named() {
    let scene = load("a.obj", format!("{SQUARE}curv2 1 2\nf 1 2 3\n")).unwrap();
    assert_eq!(count(&scene, WarningKind::IgnoredFeature), 1);
    assert!(scene.warnings[0].to_string().contains("curv2"), "{}", scene.warnings[0]);
}

proptest! {
    #[test]
    fn positions_are_read_to_the_nearest(p in prop::array::uniform9(-1e6f32..1e6)) {
        let lines: String = p.chunks(3).map(|c| format!("v {} {} {:e}\n", c[0], c[1], c[2])).collect();
        let scene = load("a.obj", format!("{lines}f 1 2 3")).unwrap();
        let expected: Vec<Vec3> = p.chunks(3).map(Vec3::from_slice).collect();
        prop_assert_eq!(world_corners(&scene), expected);
    }
}
