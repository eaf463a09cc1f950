//! What is wrong with a glTF is told with the element that is wrong.

use crate::bad_input::refusal;
use crate::support::{Document, load};
use conray_scene::{Limits, load_bytes};
use serde_json::{Value, json};

#[test]
fn glb_containers_that_are_cut_or_strange() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    doc.root(json!({"mesh": mesh}));
    let whole = doc.glb();
    assert!(load("a.glb", &whole).is_ok());
    let cut = refusal("a.glb", &whole[..whole.len() - 8]);
    let expected = format!(
        "a.glb: byte {}: the file ends here, but its header declares {} bytes",
        whole.len() - 8,
        whole.len()
    );
    assert_eq!(cut, expected);
    assert_eq!(refusal("a.glb", &whole[..10]), "a.glb: byte 10: the file ends within the GLB header");
    let mut version = whole.clone();
    version[4] = 1;
    assert_eq!(refusal("a.glb", version), "a.glb: GLB version 1 is not supported");
    let mut long_chunk = whole.clone();
    long_chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(refusal("a.glb", long_chunk), "a.glb: byte 12: the file ends within a chunk");
    let bare = [b"glTF", &2u32.to_le_bytes()[..], &12u32.to_le_bytes()].concat();
    assert_eq!(refusal("a.glb", bare), "a.glb: byte 12: there is no JSON chunk");
    let cut = refusal("a.gltf", "{\n \"asset\": {\"version\": \"2.0\"},\n");
    assert!(cut.starts_with("a.gltf: line ") && cut.contains("EOF"), "{cut}");
    assert_eq!(refusal("a.gltf", "{}"), "a.gltf: line 1: missing field `asset`");
    let old = r#"{"asset": {"version": "1.0"}, "meshes": {"a": {}}}"#;
    assert_eq!(refusal("a.gltf", old), "a.gltf: glTF version 1.0 is not supported");
}

/// Changes a good document of one triangle and expects a refusal.
fn broken(expected: &str, change: impl FnOnce(&mut Value)) {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    doc.root(json!({"mesh": mesh}));
    let indices = doc.accessor(&[0, 1, 2], 5121, "SCALAR", 3);
    doc.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    doc.json["buffers"] = json!([{"byteLength": doc.bytes.len()}]);
    assert!(doc.load().is_ok(), "the document is good before the change");
    change(&mut doc.json);
    let message = doc.load().expect_err("it must be refused").to_string();
    assert_eq!(message, format!("doc.glb: {expected}"));
}

#[test]
fn gltf_references_and_ranges() {
    broken("the document: scene 3 does not exist: there are 1", |j| j["scene"] = json!(3));
    broken("the node tree: node 9 does not exist: there are 1", |j| j["scenes"][0]["nodes"] = json!([9]));
    broken("node 0: mesh 9 does not exist: there are 1", |j| j["nodes"][0]["mesh"] = json!(9));
    broken("mesh 0 primitive 0: accessor 9 does not exist: there are 2", |j| {
        j["meshes"][0]["primitives"][0]["indices"] = json!(9)
    });
    broken("mesh 0 primitive 0: material 0 does not exist: there are 0", |j| {
        j["meshes"][0]["primitives"][0]["material"] = json!(0)
    });
    broken("mesh 0 primitive 0: mode 7 is not known", |j| j["meshes"][0]["primitives"][0]["mode"] = json!(7));
    broken("accessor 0: buffer view 9 does not exist: there are 2", |j| {
        j["accessors"][0]["bufferView"] = json!(9)
    });
    broken("accessor 0: 4 elements do not fit into its buffer view of 36 bytes", |j| {
        j["accessors"][0]["count"] = json!(4)
    });
    broken("accessor 0: 18446744073709551615 elements do not fit into its buffer view of 36 bytes", |j| {
        j["accessors"][0]["count"] = json!(u64::MAX)
    });
    broken("accessor 0: component type 5124 is not known", |j| {
        j["accessors"][0]["componentType"] = json!(5124)
    });
    broken("accessor 0: POSITION needs 3 components, not 2", |j| j["accessors"][0]["type"] = json!("VEC2"));
    broken("accessor 1: indices must be unsigned integers", |j| {
        j["accessors"][1]["componentType"] = json!(5120)
    });
    broken("buffer view 0: bytes 16 to 52 of buffer 0, which has 40", |j| {
        j["bufferViews"][0]["byteOffset"] = json!(16)
    });
    broken("mesh 0 primitive 0: vertex index 2 is out of range (there are 2 vertices)", |j| {
        j["accessors"][0]["count"] = json!(2)
    });
    broken("buffer 0: it has 40 bytes, 41 are declared", |j| j["buffers"][0]["byteLength"] = json!(41));
    broken("buffer 0: `gone.bin` cannot be read: entity not found", |j| {
        j["buffers"][0]["uri"] = json!("gone.bin")
    });
    broken("buffer 1: it has no URI, and the file has no binary chunk for it", |j| {
        j["buffers"] = json!([{"byteLength": 40}, {"byteLength": 1}])
    });
    broken("there are no triangles", |j| j["scenes"][0]["nodes"] = json!([]));
    broken("node 0: it has several parents or is its own ancestor", |j| {
        j["nodes"][0]["children"] = json!([0])
    });
    broken("node 0: it has several parents or is its own ancestor", |j| {
        j["scenes"][0]["nodes"] = json!([0, 0])
    });
    broken("node 0: its matrix does not end in the row 0 0 0 1", |j| {
        j["nodes"][0]["matrix"] = json!(vec![1; 16])
    });
    broken("node 0: it stands beyond the range of numbers", |j| {
        j["nodes"][0]["scale"] = json!([1e38, 1, 1]);
        j["nodes"][0]["translation"] = json!([3e38, 0, 0]);
    });
    broken("material 0: alphaMode `GLASS` is not known", |j| {
        j["materials"] = json!([{"alphaMode": "GLASS"}])
    });
}

#[test]
fn gltf_vertices_that_are_not_finite() {
    let mut doc = Document::new();
    let position = doc.floats(&[0., 0., 0., 1., 0., f32::INFINITY, 0., 1., 0.], "VEC3");
    let mesh = doc.push("meshes", json!({"primitives": [{"attributes": {"POSITION": position}}]}));
    doc.root(json!({"mesh": mesh}));
    assert_eq!(doc.load().unwrap_err().to_string(), "doc.glb: mesh 0 primitive 0: vertex 1 is not finite");
}

#[test]
fn gltf_features_that_are_not_built_are_named() {
    broken("KHR_draco_mesh_compression is not supported", |j| {
        j["extensionsRequired"] = json!(["KHR_mesh_quantization", "KHR_draco_mesh_compression"])
    });
    broken("KHR_draco_mesh_compression is not supported", |j| {
        j["meshes"][0]["primitives"][0]["extensions"] =
            json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
        j["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    });
    broken("reading over a network (`https://example.org/a.bin`) is not supported", |j| {
        j["buffers"][0]["uri"] = json!("https://example.org/a.bin")
    });
    let masked = json!([{"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    broken("KHR_texture_basisu (which the opacity of a material needs) is not supported", |j| {
        j["materials"] = masked;
        j["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    });
    // The same texture harms nobody where it is not asked for opacity.
    let mut doc = Document::new();
    let mesh = doc.triangle();
    doc.root(json!({"mesh": mesh}));
    doc.json["extensionsRequired"] = json!(["KHR_texture_basisu", "KHR_materials_unlit"]);
    doc.json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    assert!(doc.load().is_ok());
}

#[test]
fn small_files_that_ask_for_the_world() {
    // Many primitives that copy the same data under different materials.
    let mut doc = Document::new();
    let count = 30_000;
    let position = doc.floats(&vec![0.5; 9 * count], "VEC3");
    let primitives: Vec<_> =
        (0..500).map(|m| json!({"attributes": {"POSITION": position}, "material": m})).collect();
    (0..500).for_each(|_| {
        doc.push("materials", json!({}));
    });
    let mesh = doc.push("meshes", json!({"primitives": primitives}));
    doc.root(json!({"mesh": mesh}));
    let limits = Limits { max_expansion: 1, ..Limits::default() };
    let message =
        load_bytes("a.glb", &doc.glb(), None, &|_| unreachable!(), &limits).unwrap_err().to_string();
    assert!(message.starts_with("a.glb: too many bytes of geometry for so small a file"), "{message}");
    // Elements without data.
    broken("accessor 0: 1000000 elements without data, in so small a file", |j| {
        j["accessors"][0]["count"] = json!(1_000_000);
        j["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    });
    // A compressed view that claims to hold a thousand million vertices.
    let message = {
        let mut doc = Document::new();
        let mesh = doc.triangle();
        doc.root(json!({"mesh": mesh}));
        doc.json["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 0, "byteLength": 36,
            "byteStride": 4, "count": 10_000_000, "mode": "ATTRIBUTES"}});
        doc.load().unwrap_err().to_string()
    };
    assert_eq!(message, "doc.glb: buffer view 0: 36 compressed bytes are too few for 10000000 elements");
}
