//! glTF: opacity by alphaMode.

use crate::support::{Document, count, load_with, png_with_alpha};
use conray_core::{Opacity, Vec2, Wrap};
use conray_scene::{Scene, WarningKind};
use serde_json::{Value, json};

/// A triangle of one material that may use texture 0, whose upper texel is opaque and whose lower is a fifth.
fn document(material: Value) -> Document {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    let image = doc.view(&png_with_alpha());
    doc.push("images", json!({"bufferView": image, "mimeType": "image/png"}));
    doc.push("textures", json!({"source": 0}));
    doc.push("materials", material);
    doc.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
    doc.root(json!({"mesh": mesh}));
    doc
}

fn opacity(material: Value) -> Opacity {
    document(material).load().unwrap().geometry.materials()[0].opacity.clone()
}

fn constant(material: Value) -> f32 {
    match opacity(material) {
        Opacity::Constant(opacity) => opacity,
        Opacity::Texture(_) => panic!("a constant was expected"),
    }
}

/// Opacity at the top and at the bottom of the texture.
fn ends(opacity: &Opacity) -> [f32; 2] {
    match opacity {
        Opacity::Constant(_) => panic!("a texture was expected"),
        Opacity::Texture(t) => [0.25, 0.75].map(|v| t.at(Vec2::new(0.5, v))),
    }
}

fn textured(mode: &str, alpha: f32) -> Value {
    json!({"alphaMode": mode, "pbrMetallicRoughness":
        {"baseColorFactor": [1, 1, 1, alpha], "baseColorTexture": {"index": 0}}})
}

#[test]
fn opaque_materials_look_at_no_alpha() {
    assert_eq!(constant(textured("OPAQUE", 0.1)), 1.0);
    assert_eq!(constant(json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0]}})), 1.0);
    // The image of an opaque material need not even be an image.
    let mut doc = document(textured("OPAQUE", 1.0));
    doc.json["images"][0] = json!({"uri": "gone.png"});
    assert!(doc.load().unwrap().warnings.is_empty());
}

#[test]
fn masks_cut_at_a_half_or_where_they_say() {
    assert_eq!(ends(&opacity(textured("MASK", 1.0))), [1.0, 0.0]);
    let mut material = textured("MASK", 1.0);
    material["alphaCutoff"] = json!(0.15);
    assert_eq!(constant(material.clone()), 1.0, "both texels reach it");
    material["alphaCutoff"] = json!(1.5);
    assert_eq!(constant(material), 0.0, "neither does");
    assert_eq!(constant(textured("MASK", 0.4)), 0.0, "the factor counts before the cutoff");
    let untextured = |alpha: f32| json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, alpha]}});
    assert_eq!((constant(untextured(0.5)), constant(untextured(0.49))), (1.0, 0.0));
}

#[test]
fn blended_materials_are_fractional() {
    assert_eq!(ends(&opacity(textured("BLEND", 0.5))), [0.5, 0.1]);
    assert_eq!(
        constant(json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]}})),
        0.25
    );
    let older = json!({"alphaMode": "BLEND", "extensions": {"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor": [1, 1, 1, 0.5], "diffuseTexture": {"index": 0}}}});
    assert_eq!(ends(&opacity(older)), [0.5, 0.1]);
}

#[test]
fn sets_transforms_and_samplers_are_followed() {
    let mut material = textured("BLEND", 1.0);
    material["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0, "texCoord": 3,
        "extensions": {"KHR_texture_transform": {"offset": [0, 1], "scale": [1, -1], "texCoord": 1}}});
    let mut doc = document(material);
    doc.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648}]);
    doc.json["textures"][0]["sampler"] = json!(0);
    let scene = doc.load().unwrap();
    let opacity = &scene.geometry.materials()[0].opacity;
    assert_eq!(ends(opacity), [0.2, 1.0], "turned over");
    let Opacity::Texture(texture) = opacity else { panic!() };
    assert_eq!((texture.uv_set, texture.wrap), (1, [Wrap::Clamp, Wrap::Mirror]));
}

#[test]
fn materials_keep_their_indices_and_an_absent_one_is_opaque() {
    let mut doc = document(json!({"name": "first", "doubleSided": true}));
    doc.push("materials", json!({"name": "unused"}));
    let bare = doc.triangle();
    doc.root(json!({"mesh": bare}));
    let scene = doc.load().unwrap();
    let materials = scene.geometry.materials();
    let names: Vec<_> = materials.iter().map(|m| (m.name.as_str(), m.double_sided)).collect();
    assert_eq!(names, [("first", true), ("unused", false), ("", false)]);
    assert_eq!(scene.geometry.meshes()[1].material, 2);
    assert!(materials.iter().all(|m| m.opacity.is_opaque()));
}

#[test]
fn a_missing_image_is_opaque_and_warned_about() {
    let mut doc = document(textured("MASK", 1.0));
    doc.json["images"][0] = json!({"uri": "gone.png"});
    let scene = doc.load().unwrap();
    assert_eq!(count(&scene, WarningKind::MissingTexture), 1);
    assert!(scene.geometry.materials()[0].opacity.is_opaque());
}

#[test]
fn images_come_from_files_and_from_data_uris() {
    let png = png_with_alpha();
    let inline = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &png);
    for uri in [format!("data:image/png;base64,{inline}"), "tex%20ture.png".into()] {
        let mut doc = document(textured("BLEND", 1.0));
        doc.json["images"][0] = json!({"uri": uri});
        let scene: Scene = load_with("a.glb", doc.glb(), &[("tex ture.png", &png)]).unwrap();
        assert_eq!(ends(&scene.geometry.materials()[0].opacity), [1.0, 0.2]);
    }
}
