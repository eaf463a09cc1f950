//! STL in text and binary.

use crate::support::{count, load, only_mesh, world_corners};
use conray_core::Vec3;
use conray_scene::WarningKind;

const TETRAHEDRON: [[Vec3; 3]; 4] = [
    [Vec3::ZERO, Vec3::Y, Vec3::X],
    [Vec3::ZERO, Vec3::X, Vec3::Z],
    [Vec3::ZERO, Vec3::Z, Vec3::Y],
    [Vec3::X, Vec3::Y, Vec3::Z],
];

pub(crate) fn text() -> String {
    let facet = |t: &[Vec3; 3]| {
        let corners: String = t.iter().map(|p| format!("      vertex {:e} {} {}\n", p.x, p.y, p.z)).collect();
        format!("  FACET normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
    };
    format!(
        "solid my vertex thing\n{}endsolid my vertex thing\n",
        TETRAHEDRON.iter().map(facet).collect::<String>()
    )
}

pub(crate) fn binary(header: &[u8]) -> Vec<u8> {
    let mut out = header.to_vec();
    out.resize(80, b' ');
    out.extend((TETRAHEDRON.len() as u32).to_le_bytes());
    for triangle in TETRAHEDRON {
        out.extend([0u8; 12]);
        triangle.iter().flat_map(|p| p.to_array()).for_each(|x| out.extend(x.to_le_bytes()));
        out.extend([0u8; 2]);
    }
    out
}

#[test]
fn text_and_binary_say_the_same() {
    let scene = load("a.stl", text()).unwrap();
    let expected: Vec<Vec3> = TETRAHEDRON.concat();
    assert_eq!(world_corners(&scene), expected);
    assert_eq!(only_mesh(&scene).name, "my vertex thing");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    for header in [&b"made by hand"[..], b"solid binary that calls itself text"] {
        assert_eq!(world_corners(&load("a.stl", binary(header)).unwrap()), expected);
    }
    let crlf = text().replace('\n', "\r\n");
    assert_eq!(world_corners(&load("a.stl", crlf).unwrap()), expected);
}

#[test]
fn corners_are_welded_and_split_at_creases() {
    let scene = load("a.stl", text()).unwrap();
    let mesh = only_mesh(&scene);
    // All edges of a tetrahedron are sharp: three normals at each of four corners.
    assert_eq!(mesh.positions().len(), 12);
    let flat = "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendfacet\nfacet\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\nendfacet\n";
    assert_eq!(only_mesh(&load("a.stl", flat).unwrap()).positions().len(), 4, "a flat square is welded");
}

#[test]
fn defects_are_counted() {
    let mut bytes = binary(b"");
    let first = bytes[84..134].to_vec();
    bytes.extend(first);
    bytes[80] += 1;
    let scene = load("a.stl", bytes).unwrap();
    assert_eq!(count(&scene, WarningKind::DuplicateTriangles), 1);
}
