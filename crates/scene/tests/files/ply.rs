//! PLY in its three encodings.

use crate::support::{count, load, only_mesh, world_corners};
use conray_core::{Vec2, Vec3};
use conray_scene::WarningKind;

/// A unit square of two faces (a triangle and a quad that overlap) with properties that nobody asked for.
fn header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nobj_info none\nelement vertex 4\nproperty float x\n\
         property double y\nproperty float z\nproperty uchar red\nproperty list uchar short extra\nelement face 2\n\
         property uchar flags\nproperty list uchar int vertex_indices\nelement other 1\nproperty short a\nend_header\n"
    )
}

const CORNERS: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5], [0., 1., 0.25]];

fn text() -> Vec<u8> {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z} 255 2 7 -8\n")).collect();
    format!("{}{vertices}9 3 0 1 2\n9 4 0 1 2 3\n-5\n", header("ascii")).into_bytes()
}

fn binary(big: bool) -> Vec<u8> {
    let mut out = header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
    let mut put = |little: &[u8]| {
        if big { out.extend(little.iter().rev()) } else { out.extend(little) }
    };
    for [x, y, z] in CORNERS {
        put(&x.to_le_bytes());
        put(&f64::from(y).to_le_bytes());
        put(&z.to_le_bytes());
        put(&[255]);
        put(&[2]);
        put(&7i16.to_le_bytes());
        put(&(-8i16).to_le_bytes());
    }
    for face in [&[0i32, 1, 2][..], &[0, 1, 2, 3]] {
        put(&[9]);
        put(&[face.len() as u8]);
        face.iter().for_each(|i| put(&i.to_le_bytes()));
    }
    put(&(-5i16).to_le_bytes());
    out
}

#[test]
fn all_encodings_say_the_same() {
    let expected = world_corners(&load("a.ply", text()).unwrap());
    assert_eq!(expected.len(), 9);
    assert_eq!(expected[2], Vec3::new(1.0, 1.0, 0.5));
    for big in [false, true] {
        assert_eq!(world_corners(&load("a.ply", binary(big)).unwrap()), expected);
    }
    let crlf = String::from_utf8(text()).unwrap().replace('\n', "\r\n");
    assert_eq!(world_corners(&load("a.ply", crlf).unwrap()), expected);
    // The wrong byte order must not pass for the right one.
    let values = &binary(false)[header("binary_little_endian").len()..];
    assert!(load("a.ply", [header("binary_big_endian").as_bytes(), values].concat()).is_err());
}

#[test]
fn normals_and_uvs_stay_with_their_vertices() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
        element face 1\nproperty list uchar uint vertex_index\nend_header\n\
        0 0 0 0 0 2 0.5 0.25\n9 9 9 0 0 1 0 0\n1 0 0 0 0 0 0 0\n0 1 0 0 3 4 0 1\n3 0 2 3\n";
    let scene = load("a.ply", text).unwrap();
    let mesh = only_mesh(&scene);
    assert_eq!(mesh.positions().len(), 4, "vertices stay as they are");
    assert_eq!(mesh.normals()[0], Vec3::Z);
    assert_eq!(mesh.normals()[2], Vec3::Z, "no length: the triangle's own");
    assert!((mesh.normals()[3] - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
    assert_eq!(mesh.corner_uvs(0, 0), [Vec2::new(0.5, 0.25), Vec2::ZERO, Vec2::Y]);
    assert_eq!(count(&scene, WarningKind::BadNormals), 1);
    assert_eq!(count(&scene, WarningKind::UnusedVertices), 1);
}

#[test]
fn strips_turn_every_second_triangle() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n8 0 1 2 3 -1 2 3 4\n";
    let corners = world_corners(&load("a.ply", text).unwrap());
    assert_eq!(corners.len(), 9);
    assert!(corners.chunks(3).all(|t| (t[1] - t[0]).cross(t[2] - t[0]).z > 0.0), "all face up: {corners:?}");
}

#[test]
fn elements_that_take_no_bytes_take_no_time() {
    let text = "ply\nformat ascii 1.0\nelement nothing 999999999999\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 1 0 0\n0 1 0\n3 0 1 2";
    assert_eq!(load("a.ply", text).unwrap().geometry.triangle_count(), 1);
}
