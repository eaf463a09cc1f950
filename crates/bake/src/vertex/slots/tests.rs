use super::*;
use conray::{AoSettings, Distance};
use conray_core::{Affine3A, GeometryError, Material};
use proptest::prelude::*;

/// The corners of a box, each one vertex, and its faces as triangles.
fn solid() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

fn session(meshes: Vec<TriangleMesh>) -> Session {
    let mut geometry = Geometry::default();
    for _ in 0..2 {
        geometry.add_material(Material::default());
    }
    for mesh in meshes {
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    let settings = AoSettings { distance: Distance::Infinite, ..AoSettings::default() };
    Session::build(geometry, &settings).unwrap()
}

/// The slots of all instances, `objects` saying what they are parts of.
fn slots(session: &Session, objects: &[u32]) -> Slots {
    let instances: Vec<u32> = (0..objects.len() as u32).collect();
    let found = Slots::of(session, &instances, objects);
    check(session, &found);
    found
}

/// What holds of all: each slot is some vertex's, vertices are where they were, and corners that share a slot are at one place.
fn check(session: &Session, slots: &Slots) {
    let mut place = vec![None; slots.count()];
    for surface in slots.surfaces() {
        let mesh = session.geometry().mesh_of(surface.instance as usize);
        assert_eq!(surface.vertices.len(), surface.slots.len());
        assert_eq!(surface.is_split(), surface.vertices.len() > mesh.positions().len());
        assert!((0..mesh.positions().len()).all(|vertex| surface.vertices[vertex] == vertex as u32));
        let before = surface.triangles.iter().map(|t| t.map(|v| surface.vertices[v as usize]));
        assert!(before.eq(mesh.triangles().iter().copied()));
        let placed = &session.geometry().instances()[surface.instance as usize];
        for (&vertex, &slot) in surface.vertices.iter().zip(&surface.slots) {
            let here = placed.world_from_mesh.transform_point3(mesh.positions()[vertex as usize]);
            assert_eq!(*place[slot as usize].get_or_insert(here), here);
        }
    }
    assert!(place.iter().all(Option::is_some), "slots that nobody shows");
}

#[test]
fn a_flat_box_has_three_values_at_each_corner_and_a_smooth_one_has_one() {
    let (positions, triangles) = solid();
    let flat = TriangleMesh::new(positions.clone(), triangles).unwrap();
    let found = slots(&session(vec![flat.clone()]), &[0]);
    assert_eq!(found.count(), 24);
    assert_eq!((found.surfaces()[0].vertices.len(), found.surfaces()[0].is_split()), (24, true));
    // Both triangles of a face share the ends of its diagonal.
    let surface = &found.surfaces()[0];
    assert!((0..6).all(|face| surface.corners(2 * face)[2] == surface.corners(2 * face + 1)[1]));
    let outward = positions.iter().map(|p| (*p - 0.5).normalize()).collect();
    let found = slots(&session(vec![flat.with_normals(outward).unwrap()]), &[0]);
    assert_eq!((found.count(), found.surfaces()[0].is_split()), (8, false));
    assert_eq!(found.surfaces()[0].slots.len(), 8);
}

/// A square of two triangles, whose diagonal has vertices on both sides with these normals.
fn cut(normals: [Vec3; 2]) -> TriangleMesh {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, -0.0));
    let [a, b, c, d] = square;
    let [m, n] = normals;
    let mesh = TriangleMesh::new(vec![a, b, c, c + 0.0, d, a + 0.0], vec![[0, 1, 2], [3, 4, 5]]).unwrap();
    mesh.with_normals(vec![m, m, m, n, n, n]).unwrap()
}

#[test]
fn vertices_that_uvs_part_share_a_value_and_hard_edges_keep_two() {
    let tilted = |degrees: f32| {
        let angle = degrees.to_radians();
        Vec3::new(angle.sin(), 0.0, angle.cos())
    };
    for (degrees, expected) in [(0.0, 4), (10.0, 4), (13.0, 6), (60.0, 6)] {
        let found = slots(&session(vec![cut([Vec3::Z, tilted(degrees)])]), &[0]);
        assert_eq!((found.count(), found.surfaces()[0].is_split()), (expected, false), "{degrees}");
    }
}

#[test]
fn parts_of_one_object_share_values_across_materials_and_objects_do_not() {
    let half = |triangle: [u32; 3], material| {
        let positions = cut([Vec3::Z; 2]).positions().to_vec();
        let mesh = TriangleMesh::new(positions, vec![triangle]).unwrap().with_material(material);
        mesh.with_normals(vec![Vec3::Z; 6]).unwrap()
    };
    let session = session(vec![half([0, 1, 2], 0), half([3, 4, 5], 1)]);
    // Three vertices of either mesh are not used, and get values of their own.
    assert_eq!(slots(&session, &[0, 0]).count(), 4 + 6);
    assert_eq!(slots(&session, &[0, 1]).count(), 6 + 6);
    assert_eq!(slots(&session, &[1, 1]).surfaces()[1].corners(0)[0], 2, "numbered as they come");
}

#[test]
fn triangles_without_area_split_nothing() {
    let (mut positions, mut triangles) = solid();
    positions.push(Vec3::splat(9.0));
    triangles.extend([[0, 1, 1], [8, 8, 8]]);
    let outward = positions.iter().map(|p| (*p - 0.5).normalize()).collect();
    let mesh = TriangleMesh::new(positions, triangles).unwrap();
    let found = slots(&session(vec![mesh.clone().with_normals(outward).unwrap()]), &[0]);
    assert_eq!((found.count(), found.surfaces()[0].is_split()), (9, false));
    assert_eq!(slots(&session(vec![mesh]), &[0]).count(), 25);
}

#[test]
fn objects_are_nodes_or_names() {
    let mut geometry = Geometry::default();
    let (positions, triangles) = solid();
    let mesh = geometry.add_mesh(TriangleMesh::new(positions, triangles).unwrap()).unwrap();
    for name in ["a", "b", "a"] {
        geometry.add_named_instance(mesh, Affine3A::IDENTITY, name.into()).unwrap();
    }
    assert_eq!(objects(&geometry, &[]), [0, 1, 0]);
    let origin = |node, copy| Origin { node, copy, mesh: 0, primitive: 0 };
    assert_eq!(objects(&geometry, &[origin(5, 0), origin(5, 1), origin(5, 1)]), [0, 1, 1]);
}

#[test]
fn normals_agree_by_way_of_others_and_far_ones_do_not() {
    // A fan of 200 facets round the z axis, 1.8 degrees from each to the next, and one that stands apart.
    let facet = |k: u32| {
        let angle = (k as f32 * 1.8).to_radians();
        Vec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let mut normals: Vec<Vec3> = (0..200).map(facet).collect();
    normals.push(Vec3::Z);
    let found = alike(&normals);
    assert!(found[..200].iter().all(|&first| first == 0));
    assert_eq!(found[200], 200);
}

proptest! {
    #[test]
    fn any_triangles_have_slots(
        places in prop::collection::vec([0u8..3, 0u8..3, 0u8..2], 3..12),
        corners in prop::collection::vec([0u32..12, 0u32..12, 0u32..12], 1..20),
        smooth: bool,
    ) {
        let positions: Vec<Vec3> = places.iter().map(|p| Vec3::from_array(p.map(f32::from))).collect();
        let count = positions.len() as u32;
        let triangles = corners.iter().map(|triangle| triangle.map(|vertex| vertex % count)).collect();
        let mesh = || -> Result<TriangleMesh, GeometryError> {
            let mesh = TriangleMesh::new(positions.clone(), triangles)?;
            if smooth { mesh.with_normals(vec![Vec3::Y; positions.len()]) } else { Ok(mesh) }
        };
        let found = slots(&session(vec![mesh().unwrap()]), &[0]);
        // One normal for each vertex: nothing is split unless a triangle stands on edge to it.
        if smooth && places.iter().all(|place| place[1] == 0) {
            prop_assert!(!found.surfaces()[0].is_split());
        }
    }
}
