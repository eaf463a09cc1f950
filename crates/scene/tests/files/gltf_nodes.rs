//! glTF: where meshes and cameras stand.

use crate::support::{Document, count, world_corners};
use conray_core::{Affine3A, Quat, Vec3};
use conray_scene::{Limits, Origin, WarningKind, load_bytes};
use serde_json::json;
use std::f32::consts::FRAC_PI_2;

fn assert_near(found: &[Vec3], expected: &[Vec3]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((*f - *e).length() < 1e-5, "{found:?} {expected:?}");
    }
}

#[test]
fn transforms_compose_from_the_root_down() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    let turn = Quat::from_rotation_z(FRAC_PI_2).to_array();
    // Not of unit length: a quaternion is a direction here.
    let child =
        doc.push("nodes", json!({"mesh": mesh, "scale": [2, 3, 1], "rotation": turn.map(|x| 2.0 * x)}));
    doc.root(json!({"children": [child], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1]}));
    let origin = Vec3::new(10.0, 20.0, 30.0);
    assert_near(
        &world_corners(&doc.load().unwrap()),
        &[origin, origin + 2.0 * Vec3::Y, origin - 3.0 * Vec3::X],
    );
}

#[test]
fn a_mesh_of_several_nodes_is_stored_once() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    for x in 0..3 {
        doc.root(json!({"name": format!("copy {x}"), "mesh": mesh, "translation": [x, 0, 0]}));
    }
    let scene = doc.load().unwrap();
    let g = &scene.geometry;
    assert_eq!((g.meshes().len(), g.instances().len(), g.triangle_count()), (1, 3, 3));
    assert_eq!((g.meshes()[0].name.as_str(), g.instances()[1].name.as_str()), ("tri", "copy 1"));
    assert_near(&world_corners(&scene)[3..6], &[Vec3::X, 2.0 * Vec3::X, Vec3::X + Vec3::Y]);
    assert!(scene.warnings.is_empty(), "copies in different places are no duplicates");
}

#[test]
fn equal_primitives_of_different_meshes_are_stored_once_too() {
    let mut doc = Document::new();
    let first = doc.triangle();
    let copy = doc.json["meshes"][first].clone();
    let second = doc.push("meshes", copy);
    doc.root(json!({"mesh": first}));
    doc.root(json!({"mesh": second, "translation": [5, 0, 0]}));
    let scene = doc.load().unwrap();
    assert_eq!((scene.geometry.meshes().len(), scene.geometry.instances().len()), (1, 2));
}

#[test]
fn gpu_instances_multiply_a_node() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    let translation = doc.floats(&[0., 0., 1., 0., 0., 2.], "VEC3");
    let scale = doc.floats(&[1., 1., 1., 4., 4., 4.], "VEC3");
    let rotation = doc.accessor(&[0u8, 0, 0, 127, 0, 0, 90, 90], 5120, "VEC4", 2);
    doc.json["accessors"][rotation]["normalized"] = json!(true);
    doc.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let attributes = json!({"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale});
    doc.root(json!({"mesh": mesh, "translation": [10, 0, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}));
    let scene = doc.load().unwrap();
    assert_eq!((scene.geometry.meshes().len(), scene.geometry.instances().len()), (1, 2));
    let (a, b) = (Vec3::new(10.0, 0.0, 1.0), Vec3::new(10.0, 0.0, 2.0));
    let expected = [a, a + Vec3::X, a + Vec3::Y, b, b + 4.0 * Vec3::Y, b - 4.0 * Vec3::X];
    assert_near(&world_corners(&scene), &expected);
}

#[test]
fn instances_know_where_in_the_document_they_stand() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    // Points between two primitives of triangles: the indices are those of the document all the same.
    let primitive = doc.json["meshes"][mesh]["primitives"][0].clone();
    let mut points = primitive.clone();
    points["mode"] = json!(0);
    let several = doc.push("meshes", json!({"primitives": [points, primitive.clone(), primitive]}));
    let translation = doc.floats(&[0., 0., 1., 0., 0., 2.], "VEC3");
    doc.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation}}});
    doc.root(json!({"name": "empty"}));
    doc.root(json!({"mesh": mesh}));
    doc.root(json!({"mesh": several, "translation": [5, 0, 0], "extensions": instancing}));
    let scene = doc.load().unwrap();
    let origin = |node, copy, mesh: usize, primitive| Origin { node, copy, mesh: mesh as u32, primitive };
    let expected = [
        origin(1, 0, mesh, 0),
        origin(2, 0, several, 1),
        origin(2, 0, several, 2),
        origin(2, 1, several, 1),
        origin(2, 1, several, 2),
    ];
    assert_eq!(scene.origins, expected);
    assert_eq!(scene.geometry.instances().len(), expected.len());
    assert_eq!(scene.sources.len(), scene.geometry.meshes().len());
    assert_eq!(scene.sources[0], [0, 1, 2]);
}

#[test]
fn only_the_documents_scene_is_loaded() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    doc.root(json!({"mesh": mesh}));
    let other = doc.push("nodes", json!({"mesh": mesh, "translation": [7, 0, 0]}));
    doc.json["scenes"] = json!([doc.json["scenes"][0], {"nodes": [other]}]);
    assert_eq!(world_corners(&doc.load().unwrap())[0], Vec3::ZERO);
    doc.json["scene"] = json!(1);
    assert_eq!(world_corners(&doc.load().unwrap())[0], 7.0 * Vec3::X);
    doc.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(world_corners(&doc.load().unwrap())[0], Vec3::ZERO, "the first");
    doc.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(doc.load().unwrap().geometry.instances().len(), 2, "all nodes without a parent");
}

#[test]
fn invisible_nodes_hide_what_is_below_them() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    let child = doc.push("nodes", json!({"mesh": mesh}));
    doc.root(json!({"children": [child], "extensions": {"KHR_node_visibility": {"visible": false}}}));
    doc.root(json!({"mesh": mesh, "extensions": {"KHR_node_visibility": {"visible": true}}}));
    assert_eq!(doc.load().unwrap().geometry.instances().len(), 1);
}

#[test]
fn flattened_meshes_stay_and_can_be_traced() {
    let mut doc = Document::new();
    let position = doc.floats(&[0., 0., 5., 1., 0., 6., 0., 1., 7.], "VEC3");
    let mesh = doc.push("meshes", json!({"primitives": [{"attributes": {"POSITION": position}}]}));
    doc.root(json!({"mesh": mesh, "scale": [1, 1, 0], "translation": [0, 0, 2]}));
    let scene = doc.load().unwrap();
    assert_eq!(scene.geometry.instances()[0].world_from_mesh, Affine3A::IDENTITY);
    let z = 2.0 * Vec3::Z;
    assert_eq!(world_corners(&scene), [z, z + Vec3::X, z + Vec3::Y]);
}

#[test]
fn perspective_cameras_become_views() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    doc.root(json!({"mesh": mesh}));
    doc.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": FRAC_PI_2, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9}},
    ]);
    let turn = Quat::from_rotation_y(FRAC_PI_2).to_array();
    doc.root(json!({"name": "side", "camera": 0, "translation": [4, 0.5, 0], "rotation": turn}));
    doc.root(json!({"name": "side", "camera": 0}));
    doc.root(json!({"camera": 1}));
    let scene = doc.load().unwrap();
    let names: Vec<_> = scene.views.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["side", "side 2"]);
    let view = &scene.views[0];
    assert!((view.vertical_fov_deg - 90.0).abs() < 1e-3);
    // Turned by a right angle about y, -z becomes -x; the scene's middle is at (0.5, 0.5, 0).
    assert_near(
        &[view.eye, view.look_at, view.up],
        &[Vec3::new(4.0, 0.5, 0.0), Vec3::new(0.5, 0.5, 0.0), Vec3::Y],
    );
    assert_eq!(count(&scene, WarningKind::IgnoredFeature), 1);
}

#[test]
fn morphs_and_skins_are_shown_at_rest_with_a_warning() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    doc.json["meshes"][mesh]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    doc.root(json!({"mesh": mesh, "skin": 0}));
    let scene = doc.load().unwrap();
    assert_eq!(count(&scene, WarningKind::IgnoredFeature), 2);
    assert_eq!(world_corners(&scene), [Vec3::ZERO, Vec3::X, Vec3::Y]);
}

#[test]
fn a_deep_tree_is_walked_as_far_as_the_limit() {
    let depth = 2000;
    let mut doc = Document::new();
    let mesh = doc.triangle();
    let mut node = doc.push("nodes", json!({"mesh": mesh}));
    for _ in 1..depth {
        node = doc.push("nodes", json!({"children": [node], "translation": [1, 0, 0]}));
    }
    doc.json["scenes"][0]["nodes"] = json!([node]);
    assert_eq!(world_corners(&doc.load().unwrap())[0], (depth - 1) as f32 * Vec3::X);
    let limits = Limits { max_node_depth: depth as u64 - 1, ..Limits::default() };
    let error = load_bytes("a.glb", &doc.glb(), None, &|_| unreachable!(), &limits).unwrap_err();
    assert_eq!(error.to_string(), "a.glb: too many levels of nodes: 2000 are more than the limit of 1999");
}
