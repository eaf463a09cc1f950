//! Normals that a file has, lacks, or has in part.

use crate::support::{count, load, only_mesh};
use conray_core::{TriangleMesh, Vec3};
use conray_scene::{CREASE_ANGLE_DEG, WarningKind};
use std::f32::consts::TAU;
use std::fmt::Write;

/// A prism about the z axis with `n` sides, all vertices shared; radius 1, from z = 0 to 1.
fn prism(n: usize) -> String {
    let mut text = String::new();
    for i in 0..n {
        let (sin, cos) = (TAU * i as f32 / n as f32).sin_cos();
        write!(text, "v {cos} {sin} 0\nv {cos} {sin} 1\n").unwrap();
    }
    for i in 0..n {
        let (a, b) = (2 * i + 1, 2 * ((i + 1) % n) + 1);
        writeln!(text, "f {a} {b} {} {}", b + 1, a + 1).unwrap();
    }
    let ring = |odd: usize| (0..n).map(move |i| format!(" {}", 2 * i + odd));
    writeln!(text, "f{}\nf{}", ring(2).collect::<String>(), ring(1).rev().collect::<String>()).unwrap();
    text
}

/// Largest angle in degrees between a triangle's own normal and those of its corners.
fn largest_bend_deg(mesh: &TriangleMesh) -> f32 {
    let bend = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        let own = (b - a).cross(c - a).normalize();
        mesh.triangles()[t].map(|v| own.angle_between(mesh.normals()[v as usize]).to_degrees())
    };
    (0..mesh.triangles().len()).flat_map(bend).fold(0.0, f32::max)
}

#[test]
fn prisms_below_the_crease_angle_are_smooth_and_others_sharp() {
    for n in [3, 4, 6, 8, 10, 12, 64] {
        let scene = load("a.obj", prism(n)).unwrap();
        let mesh = only_mesh(&scene);
        assert!(mesh.normals().iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
        let side_angle = 360.0 / n as f32;
        let bend = largest_bend_deg(mesh);
        if side_angle <= CREASE_ANGLE_DEG {
            // Two quads meet at each side edge; at a corner of a quad one of its triangles may have no second corner.
            assert!((bend - side_angle / 2.0).abs() < 0.02 + side_angle / 6.0, "{n} sides bend by {bend}");
            let side = |i: &usize| mesh.normals()[*i].z.abs() < 0.9;
            for i in (0..mesh.positions().len()).filter(side) {
                let radial = mesh.positions()[i].truncate().extend(0.0).normalize();
                assert!(mesh.normals()[i].angle_between(radial).to_degrees() < side_angle / 6.0 + 0.1);
            }
        } else {
            assert!(bend < 0.1, "{n} sides bend by {bend}");
        }
        // The caps stay flat on every prism.
        assert_eq!(mesh.normals().iter().filter(|n| n.z.abs() > 0.99).count(), 2 * n);
    }
}

#[test]
fn vertices_that_are_not_shared_are_smoothed_all_the_same() {
    let shared = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.2\nf 1 2 3\nf 2 4 3\n";
    let apart = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 -0\nf 1 2 3\nf 4 5 6\n";
    let normals = |text: &str| {
        let scene = load("a.obj", text).unwrap();
        let mesh = only_mesh(&scene);
        mesh.triangles().iter().flatten().map(|&v| mesh.normals()[v as usize]).collect::<Vec<_>>()
    };
    assert_eq!(normals(shared), normals(apart));
    assert_ne!(normals(shared)[1], Vec3::Z, "the edge is gentle enough to be smooth");
}

#[test]
fn both_sides_of_a_doubled_sheet_are_smoothed_apart() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0.2\nv 2 1 0.2\nf 1 2 3 4\nf 4 3 2 1\nf 2 5 6 3\nf 3 6 5 2\n";
    let scene = load("a.obj", text).unwrap();
    let mesh = only_mesh(&scene);
    for t in 0..mesh.triangles().len() {
        let up = if t / 2 % 2 == 0 { 1.0 } else { -1.0 };
        let normals = mesh.triangles()[t].map(|v| mesh.normals()[v as usize]);
        assert!(normals.iter().all(|n| n.z * up > 0.9), "triangle {t}: {normals:?}");
    }
    assert!(largest_bend_deg(mesh) > 3.0, "the two halves of each side are joined");
}

#[test]
fn normals_in_the_file_stay_and_missing_ones_are_filled_in() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0.6 0 0.8\nf 1//1 2//1 3//1\nf 1 2 4\n";
    let scene = load("a.obj", text).unwrap();
    let mesh = only_mesh(&scene);
    let of = |t: usize| mesh.triangles()[t].map(|v| mesh.normals()[v as usize]);
    assert_eq!(of(0), [Vec3::new(0.6, 0.0, 0.8); 3]);
    assert_eq!(of(1), [Vec3::NEG_Y; 3]);
}

#[test]
fn normals_without_a_direction_are_replaced() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn 0 0 1e-30\nvn 0 0 3e38\nvn nan 0 1\nf 1//1 2//2 3//3\nf 1//4 2//2 3//3\n";
    let scene = load("a.obj", text).unwrap();
    assert_eq!(count(&scene, WarningKind::BadNormals), 2);
    assert!(
        only_mesh(&scene).normals().iter().all(|n| *n == Vec3::Z),
        "tiny and huge normals keep their direction"
    );
}

#[test]
fn triangles_without_area_get_unit_normals_too() {
    let scene = load("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n").unwrap();
    let mesh = only_mesh(&scene);
    assert!(mesh.normals().iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
    assert!(mesh.triangles()[1].iter().all(|&v| mesh.normals()[v as usize] == Vec3::Z));
}

#[test]
fn a_vertex_of_very_many_faces_takes_no_quadratic_time() {
    // 40 000 faces about one edge: comparing all pairs would take minutes.
    let mut text = String::from("v 0 0 0\nv 0 0 1\n");
    for i in 0..40_000 {
        let (sin, cos) = (TAU * i as f32 / 40_000.0).sin_cos();
        writeln!(text, "v {cos} {sin} 0\nf 1 2 -1").unwrap();
    }
    assert_eq!(load("a.obj", text).unwrap().geometry.triangle_count(), 40_000);
}
