//! Normal maps and tangents, where they are wanted.

use crate::support::{Document, count, load_extras, png};
use conray_core::{NormalMap, Vec2, Vec3, Vec4, Wrap};
use conray_scene::{Extras, Scene, WarningKind};
use image::ExtendedColorType::{L8, Rgb8};
use serde_json::{Value, json};

const WANTED: Extras = Extras { tangents: true, normal_maps: true };

/// Two texels, one above the other: the upper leans to the right, the lower up in the picture.
fn normals() -> Vec<u8> {
    png(1, 2, Rgb8, &[255, 128, 128, 128, 255, 128])
}

fn document(normal_texture: Value) -> Document {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    let image = doc.view(&normals());
    doc.push("images", json!({"bufferView": image, "mimeType": "image/png"}));
    doc.push("textures", json!({"source": 0}));
    doc.push("materials", json!({"normalTexture": normal_texture}));
    doc.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
    doc.root(json!({"mesh": mesh}));
    doc
}

fn loaded(doc: &Document, extras: Extras) -> Scene {
    load_extras("doc.glb", doc.glb(), &[], extras).unwrap()
}

fn map(scene: &Scene) -> &NormalMap {
    scene.geometry.materials()[0].normal_map.as_ref().expect("a normal map")
}

fn near(found: Vec3, expected: Vec3) {
    assert!((found - expected).length() < 0.02, "{found} {expected}");
}

#[test]
fn a_gltf_tells_its_normals_where_they_are_wanted() {
    let doc = document(json!({"index": 0}));
    let scene = loaded(&doc, WANTED);
    near(map(&scene).at(Vec2::new(0.5, 0.25), 1.0), Vec3::X);
    near(map(&scene).at(Vec2::new(0.5, 0.75), 1.0), Vec3::Y);
    assert!(scene.warnings.is_empty());
    assert!(loaded(&doc, Extras::default()).geometry.materials()[0].normal_map.is_none());
}

#[test]
fn scales_sets_transforms_and_samplers_are_followed() {
    let transform = json!({"offset": [0, 1], "scale": [1, -1], "texCoord": 2});
    let mut doc = document(json!({"index": 0, "scale": 0.5, "texCoord": 1,
        "extensions": {"KHR_texture_transform": transform}}));
    doc.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648}]);
    doc.json["textures"][0]["sampler"] = json!(0);
    let scene = loaded(&doc, WANTED);
    let map = map(&scene);
    assert_eq!((map.uv_set, map.scale, map.wrap), (2, 0.5, [Wrap::Clamp, Wrap::Mirror]));
    near(map.at(Vec2::new(0.5, 0.25), 1.0), Vec3::Y);
}

#[test]
fn what_is_missing_is_warned_about_and_what_is_broken_refused() {
    let mut doc = document(json!({"index": 0}));
    doc.json["images"][0] = json!({"uri": "gone.png"});
    let scene = loaded(&doc, WANTED);
    assert_eq!(count(&scene, WarningKind::MissingNormalMap), 1);
    assert!(scene.geometry.materials()[0].normal_map.is_none());
    let other = load_extras("doc.glb", doc.glb(), &[("gone.png", b"DDS |\0\0\0")], WANTED).unwrap();
    assert_eq!(count(&other, WarningKind::MissingNormalMap), 1);
    assert!(other.warnings[0].example.contains("DDS"));
    let broken = &normals()[..40];
    let refused = load_extras("doc.glb", doc.glb(), &[("gone.png", broken)], WANTED).unwrap_err();
    assert!(refused.to_string().contains("gone.png"), "{refused}");
    doc.json["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    let basis = loaded(&doc, WANTED);
    assert!(basis.warnings[0].example.contains("KHR_texture_basisu"));
    doc.json["materials"][0]["normalTexture"]["index"] = json!(7);
    assert!(load_extras("doc.glb", doc.glb(), &[], WANTED).is_err());
}

#[test]
fn tangents_are_read_where_there_are_normals() {
    let mut doc = document(json!({"index": 0}));
    let tangents = doc.floats(&[2., 0., 0., 1., 0., 1., 0., -1., f32::NAN, 0., 0., 1.], "VEC4");
    doc.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(tangents);
    assert!(loaded(&doc, WANTED).geometry.meshes()[0].tangents().is_empty());
    let normals = doc.floats(&[0., 0., 1., 0., 0., 1., 0., 0., 1.], "VEC3");
    doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let scene = loaded(&doc, WANTED);
    let expected = [Vec4::new(1., 0., 0., 1.), Vec4::new(0., 1., 0., -1.), Vec4::new(0., 0., 0., 1.)];
    assert_eq!(scene.geometry.meshes()[0].tangents(), expected);
    assert!(loaded(&doc, Extras::default()).geometry.meshes()[0].tangents().is_empty());
    let wrong = doc.floats(&[0., 0., 1.], "VEC3");
    doc.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(wrong);
    assert!(load_extras("doc.glb", doc.glb(), &[], WANTED).is_err());
}

fn obj(statement: &str, image: &[u8]) -> Scene {
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let mtl = format!("newmtl m\n{statement}\n");
    load_extras("a.obj", text, &[("a.mtl", mtl.as_bytes()), ("n.png", image)], WANTED).unwrap()
}

#[test]
fn an_obj_names_normals_by_norm_or_by_bump() {
    for statement in ["norm n.png", "map_Bump -bm 0.5 n.png", "bump n.png", "norm n.png\nbump gone.png"] {
        let scene = obj(statement, &normals());
        assert!(scene.warnings.is_empty(), "{statement}");
        // The upper texel is at the end of v, which points up.
        near(map(&scene).at(Vec2::new(0.5, 0.75), 1.0).with_z(0.0).normalize(), Vec3::X);
        assert_eq!(map(&scene).scale, if statement.contains("-bm") { 0.5 } else { 1.0 });
    }
    let heights = obj("map_Bump n.png", &png(1, 2, L8, &[3, 200]));
    assert!(heights.geometry.materials()[0].normal_map.is_none());
    assert!(heights.warnings[0].example.contains("heights"));
    assert_eq!(count(&obj("norm gone.png", &normals()), WarningKind::MissingNormalMap), 1);
    assert!(obj("Kd 1 1 1", &normals()).warnings.is_empty());
}
