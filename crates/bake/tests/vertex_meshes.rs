//! Plain meshes with values at their vertices: what other readers find in them.

use conray::{AoSettings, Session};
use conray_bake::{Facing, Slots, VertexSettings, VertexTarget, VertexValues, write_obj, write_ply};
use conray_core::{Affine3A, Estimate, Geometry, Quat, TriangleMesh, Vec3};
use conray_scene::{Limits, load};
use conray_target::Target;
use std::{fs, path::Path};

/// A box, each corner one vertex with a smooth normal if wanted.
fn solid(is_smooth: bool) -> TriangleMesh {
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    let outward = (0..8).map(|k| (corner(k) - 0.5).normalize()).collect();
    if is_smooth { mesh.with_normals(outward).unwrap() } else { mesh }
}

/// Some boxes, the second placed by a turn, a mirror and a stretch, with values that tell the slots apart.
fn scene(smooth: [bool; 2]) -> (Session, Slots, VertexValues) {
    let mut geometry = Geometry::default();
    let turn = Quat::from_rotation_y(0.7);
    let placed = Affine3A::from_scale_rotation_translation(Vec3::new(-1.0, 2.0, 0.5), turn, Vec3::splat(3.0));
    for (is_smooth, placement) in smooth.into_iter().zip([Affine3A::IDENTITY, placed]) {
        let mesh = geometry.add_mesh(solid(is_smooth)).unwrap();
        geometry.add_named_instance(mesh, placement, "a  box".into()).unwrap();
    }
    let session = Session::build(geometry, &AoSettings::default()).unwrap();
    let slots = Slots::of(&session, &[0, 1], &[0, 1]);
    let target =
        VertexTarget::new(&session, slots.clone(), &VertexSettings::default(), &Facing::default()).unwrap();
    let open = Estimate { visibility: 1.0, error: 0.0, ..Estimate::PENDING };
    let mut values = target.resolve(&vec![open; target.points().len()]).unwrap();
    let count = values.visibility.len() as f32;
    values.visibility.iter_mut().enumerate().for_each(|(slot, value)| *value = slot as f32 / count);
    (session, slots, values)
}

/// Triangles of all instances in the world.
fn triangles(geometry: &Geometry) -> Vec<[Vec3; 3]> {
    let of = |instance: &conray_core::Instance| {
        let (mesh, placement) = (&geometry.meshes()[instance.mesh as usize], instance.world_from_mesh);
        (0..mesh.triangles().len()).map(move |t| mesh.corners(t).map(|p| placement.transform_point3(p)))
    };
    geometry.instances().iter().flat_map(of).collect()
}

/// The same triangles in the same order, those of the mirrored instance turned round, and all with their fronts outwards.
fn check(before: &Geometry, path: &Path) {
    let after = load(path, &Limits::default()).unwrap().geometry;
    let (found, expected) = (triangles(&after), triangles(before));
    assert_eq!(found.len(), expected.len());
    for (k, (found, [a, b, c])) in found.iter().zip(expected).enumerate() {
        assert_eq!(*found, if k < 12 { [a, b, c] } else { [a, c, b] }, "triangle {k}");
        let middle = if k < 12 {
            Vec3::splat(0.5)
        } else {
            before.instances()[1].world_from_mesh.transform_point3(Vec3::splat(0.5))
        };
        let [a, b, c] = *found;
        assert!((b - a).cross(c - a).dot(a - middle) > 0.0, "triangle {k}");
    }
    // Vertex normals point outwards too.
    for mesh in after.meshes() {
        for (triangle, corners) in mesh.triangles().iter().zip((0..).map(|t| mesh.corners(t))) {
            let [a, b, c] = corners;
            let front = (b - a).cross(c - a).normalize();
            assert!(triangle.iter().all(|&v| mesh.normals()[v as usize].dot(front) > 0.2));
            assert!(triangle.iter().all(|&v| (mesh.normals()[v as usize].length() - 1.0).abs() < 1e-5));
        }
    }
}

#[test]
fn a_ply_file_holds_the_mesh_in_the_world_with_colours_and_visibility() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.ply");
    for smooth in [[false, false], [false, true], [true, true]] {
        let (session, slots, values) = scene(smooth);
        write_ply(&path, session.geometry(), &slots, &values).unwrap();
        check(session.geometry(), &path);
        let bytes = fs::read(&path).unwrap();
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        let has_normals = smooth.contains(&true);
        assert_eq!(header.contains("property float nx\n"), has_normals);
        assert!(header.contains("property uchar red\n") && header.contains("property float visibility\n"));
        let size = if has_normals { 24 } else { 12 } + 3 + 4;
        let all: Vec<u32> = slots.surfaces().iter().flat_map(|surface| surface.slots.clone()).collect();
        assert_eq!(bytes.len(), end + all.len() * size + 24 * 13);
        for (record, slot) in bytes[end..].chunks_exact(size).zip(all) {
            let value = values.visibility[slot as usize];
            assert_eq!(record[size - 4..], value.to_le_bytes());
            assert_eq!(record[size - 7..size - 4], [(value * 255.0).round() as u8; 3]);
        }
    }
    assert!(
        write_ply(folder.path(), scene([true; 2]).0.geometry(), &Slots::default(), &VertexValues::default())
            .is_err()
    );
}

#[test]
fn an_obj_file_holds_the_mesh_in_the_world_with_colours() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.obj");
    for smooth in [[false, false], [false, true], [true, true]] {
        let (session, slots, values) = scene(smooth);
        write_obj(&path, session.geometry(), &slots, &values).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().filter(|line| *line == "o a box").count(), 2);
        let greys: Vec<[f32; 3]> = text
            .lines()
            .filter_map(|line| line.strip_prefix("v "))
            .map(|line| {
                let numbers: Vec<f32> = line.split(' ').map(|number| number.parse().unwrap()).collect();
                numbers[3..].try_into().unwrap()
            })
            .collect();
        let all = slots.surfaces().iter().flat_map(|surface| &surface.slots);
        assert!(greys.into_iter().eq(all.map(|&slot| [values.visibility[slot as usize]; 3])));
        check(session.geometry(), &path);
    }
}
