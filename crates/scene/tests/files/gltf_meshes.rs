//! glTF: primitives and the accessors behind them.

use crate::support::{Document, count, load_with, only_mesh, world_corners};
use conray_core::{Vec2, Vec3};
use conray_scene::WarningKind;
use serde_json::json;

/// A scene of one mesh with one primitive.
fn show(mut doc: Document, primitive: serde_json::Value) -> Document {
    let mesh = doc.push("meshes", json!({"primitives": [primitive]}));
    doc.root(json!({"mesh": mesh}));
    doc
}

const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];

fn bytes_of<T: bytemuck::Pod>(values: &[T]) -> Vec<u8> {
    bytemuck::cast_slice(values).to_vec()
}

#[test]
fn indices_come_in_three_sizes_or_not_at_all() {
    let expected = [0usize, 1, 2, 0, 2, 3].map(|i| Vec3::from_slice(&SQUARE[3 * i..]));
    let kinds: [(u32, Vec<u8>); 3] = [
        (5121, bytes_of(&[0u8, 1, 2, 0, 2, 3])),
        (5123, bytes_of(&[0u16, 1, 2, 0, 2, 3])),
        (5125, bytes_of(&[0u32, 1, 2, 0, 2, 3])),
    ];
    for (code, bytes) in kinds {
        let mut doc = Document::new();
        let position = doc.floats(&SQUARE, "VEC3");
        let indices = doc.accessor(&bytes, code, "SCALAR", 6);
        let scene =
            show(doc, json!({"attributes": {"POSITION": position}, "indices": indices})).load().unwrap();
        assert_eq!(world_corners(&scene), expected);
        assert!(only_mesh(&scene).normals().is_empty(), "flat without normals, as the specification says");
    }
    let mut doc = Document::new();
    let position = doc.floats(&SQUARE[..9], "VEC3");
    assert_eq!(
        world_corners(&show(doc, json!({"attributes": {"POSITION": position}})).load().unwrap()),
        expected[..3]
    );
}

#[test]
fn strips_and_fans_keep_their_sense() {
    let zigzag = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0., 0., 2., 0.];
    for (mode, positions, triangles) in [(5, &zigzag[..], 3), (6, &SQUARE[..], 2)] {
        let mut doc = Document::new();
        let position = doc.floats(positions, "VEC3");
        let scene = show(doc, json!({"attributes": {"POSITION": position}, "mode": mode})).load().unwrap();
        let corners = world_corners(&scene);
        assert_eq!(corners.len(), 3 * triangles);
        assert!(corners.chunks(3).all(|t| (t[1] - t[0]).cross(t[2] - t[0]).z > 0.0), "mode {mode}");
    }
}

#[test]
fn points_and_lines_are_ignored_with_a_warning() {
    let mut doc = Document::new();
    let position = doc.floats(&SQUARE, "VEC3");
    let attributes = json!({"POSITION": position});
    let primitives: Vec<_> = (0..4).map(|mode| json!({"attributes": attributes, "mode": mode})).collect();
    let mesh = doc.push("meshes", json!({"primitives": primitives}));
    let triangle = doc.triangle();
    doc.root(json!({"mesh": mesh}));
    doc.root(json!({"mesh": triangle}));
    let scene = doc.load().unwrap();
    assert_eq!((scene.geometry.triangle_count(), count(&scene, WarningKind::IgnoredPrimitives)), (1, 4));
}

#[test]
fn uv_sets_keep_their_numbers() {
    let mut doc = Document::new();
    let position = doc.floats(&SQUARE[..9], "VEC3");
    let uv0 = doc.floats(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6], "VEC2");
    let mut padded = vec![];
    [[51u8, 102], [255, 0], [0, 153]].iter().for_each(|uv| padded.extend([uv[0], uv[1], 0, 0]));
    let view = doc.view(&padded);
    doc.json["bufferViews"][view]["byteStride"] = json!(4);
    let uv2 = doc.push(
        "accessors",
        json!({"bufferView": view, "componentType": 5121, "normalized": true, "type": "VEC2", "count": 3}),
    );
    let attributes = json!({"POSITION": position, "TEXCOORD_0": uv0, "TEXCOORD_2": uv2});
    let scene = show(doc, json!({"attributes": attributes})).load().unwrap();
    let mesh = only_mesh(&scene);
    assert_eq!(mesh.uv_sets().len(), 3);
    assert_eq!(mesh.corner_uvs(0, 0)[1], Vec2::new(0.3, 0.4));
    assert_eq!(mesh.corner_uvs(0, 1), [Vec2::ZERO; 3]);
    assert_eq!(mesh.corner_uvs(0, 2), [Vec2::new(0.2, 0.4), Vec2::X, Vec2::new(0.0, 0.6)]);
}

#[test]
fn quantised_positions_keep_their_values_and_normalised_ones_become_fractions() {
    for (code, normalized, bytes, expected) in [
        (5122, false, bytes_of(&[0i16, 0, 0, 0, 300, 0, 0, 0, 0, -200, 0, 0]), [300.0, -200.0]),
        (5122, true, bytes_of(&[0i16, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0]), [1.0, -1.0]),
        (5123, true, bytes_of(&[0u16, 0, 0, 0, 65535, 0, 0, 0, 0, 13107, 0, 0]), [1.0, 0.2]),
        (5120, false, bytes_of(&[0i8, 0, 0, 0, 100, 0, 0, 0, 0, -100, 0, 0]), [100.0, -100.0]),
        (5121, true, bytes_of(&[0u8, 0, 0, 0, 255, 0, 0, 0, 0, 51, 0, 0]), [1.0, 0.2]),
    ] {
        let mut doc = Document::new();
        doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let view = doc.view(&bytes);
        doc.json["bufferViews"][view]["byteStride"] = json!(bytes.len() / 3);
        let position = doc.push(
            "accessors",
            json!({"bufferView": view, "componentType": code, "normalized": normalized, "type": "VEC3", "count": 3}),
        );
        let scene = show(doc, json!({"attributes": {"POSITION": position}})).load().unwrap();
        let corners = [Vec3::ZERO, Vec3::X * expected[0], Vec3::Y * expected[1]];
        assert_eq!(world_corners(&scene), corners, "code {code}");
    }
}

#[test]
fn sparse_accessors_replace_elements_of_a_list_or_of_zeros() {
    for with_base in [true, false] {
        let mut doc = Document::new();
        let position = if with_base {
            doc.floats(&SQUARE[..9], "VEC3")
        } else {
            doc.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 3}))
        };
        let (indices, values) =
            (doc.view(&bytes_of(&[1u16, 2])), doc.view(&bytes_of(&[5f32, 0., 0., 0., 6., 0.])));
        doc.json["accessors"][position]["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": 5123},
            "values": {"bufferView": values},
        });
        let scene = show(doc, json!({"attributes": {"POSITION": position}})).load().unwrap();
        assert_eq!(world_corners(&scene), [Vec3::ZERO, Vec3::X * 5.0, Vec3::Y * 6.0]);
    }
}

#[test]
fn interleaved_attributes_and_shared_lists_are_taken_apart() {
    let mut doc = Document::new();
    // Position and normal in turn, four vertices; two primitives share the list and use three vertices each.
    let rows: Vec<f32> = SQUARE.chunks(3).flat_map(|p| [p[0], p[1], p[2], 0.0, 0.0, 2.0]).collect();
    let view = doc.view(&bytes_of(&rows));
    doc.json["bufferViews"][view]["byteStride"] = json!(24);
    let part = |offset: usize| json!({"bufferView": view, "byteOffset": offset, "componentType": 5126, "type": "VEC3", "count": 4});
    let (position, normal) = (doc.push("accessors", part(0)), doc.push("accessors", part(12)));
    let attributes = json!({"POSITION": position, "NORMAL": normal});
    let (a, b) = (doc.accessor(&[0, 1, 2], 5121, "SCALAR", 3), doc.accessor(&[0, 2, 3], 5121, "SCALAR", 3));
    let mesh = doc.push(
        "meshes",
        json!({"primitives": [
            {"attributes": attributes, "indices": a}, {"attributes": attributes, "indices": b}
        ]}),
    );
    doc.root(json!({"mesh": mesh}));
    let scene = doc.load().unwrap();
    assert_eq!(scene.geometry.meshes().len(), 2);
    for mesh in scene.geometry.meshes() {
        assert_eq!(mesh.positions().len(), 3, "only what the primitive uses");
        assert_eq!(mesh.normals(), [Vec3::Z; 3]);
    }
    assert_eq!(scene.geometry.meshes()[1].corners(0)[2], Vec3::Y);
}

#[test]
fn normals_without_length_are_replaced() {
    let mut doc = Document::new();
    let position = doc.floats(&SQUARE[..9], "VEC3");
    let normal = doc.floats(&[0., 0., 0., 0., 3., 4., 0., 0., f32::NAN], "VEC3");
    let scene = show(doc, json!({"attributes": {"POSITION": position, "NORMAL": normal}})).load().unwrap();
    assert_eq!(only_mesh(&scene).normals(), [Vec3::Z, Vec3::new(0.0, 0.6, 0.8), Vec3::Z]);
    assert_eq!(count(&scene, WarningKind::BadNormals), 2);
}

#[test]
fn buffers_come_inline_or_from_files_with_encoded_names() {
    let mut doc = Document::new();
    let mesh = doc.triangle();
    doc.root(json!({"mesh": mesh}));
    let expected = world_corners(&doc.load().unwrap());
    let inline = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &doc.bytes);
    let uris = [
        format!("data:application/octet-stream;base64,{inline}"),
        "my%20data.bin".into(),
        "my data.bin".into(),
    ];
    for uri in uris {
        doc.json["buffers"] = json!([{"uri": uri, "byteLength": doc.bytes.len()}]);
        let json = serde_json::to_vec(&doc.json).unwrap();
        let scene = load_with("a.gltf", json, &[("my data.bin", &doc.bytes)]).unwrap();
        assert_eq!(world_corners(&scene), expected);
    }
}

#[test]
fn compressed_views_decode_to_what_went_in() {
    let positions: Vec<[f32; 4]> = (0..300).map(|i| [i as f32, (i * i % 97) as f32, 0.5, 0.0]).collect();
    let indices: Vec<u32> = (0..298).flat_map(|i| [i, i + 1, i + 2]).collect();
    let mut doc = Document::new();
    let plain = [doc.view(&bytes_of(&positions)), doc.view(&bytes_of(&indices))];
    let encoded = [
        (meshopt::encode_vertex_buffer(&positions).unwrap(), 16, 300, "ATTRIBUTES"),
        (meshopt::encode_index_buffer(&indices, 300).unwrap(), 4, 894, "TRIANGLES"),
        (meshopt::encode_index_sequence(&indices, 300).unwrap(), 4, 894, "INDICES"),
    ];
    let mut views = Vec::new();
    for (bytes, stride, count, mode) in &encoded {
        let view = doc.view(bytes);
        let extension = json!({"buffer": 0, "byteOffset": doc.json["bufferViews"][view]["byteOffset"],
            "byteLength": bytes.len(), "byteStride": stride, "count": count, "mode": mode});
        doc.json["bufferViews"][view] = json!({"buffer": 1, "byteLength": stride * count,
            "extensions": {"EXT_meshopt_compression": extension}});
        views.push(view);
    }
    let mut scenes = Vec::new();
    for (position, index) in [(plain[0], plain[1]), (views[0], views[1]), (views[0], views[2])] {
        let mut doc = Document { json: doc.json.clone(), bytes: doc.bytes.clone() };
        doc.json["bufferViews"][plain[0]]["byteStride"] = json!(16);
        doc.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
        doc.json["buffers"] = json!([{"byteLength": doc.bytes.len()},
            {"byteLength": 4800, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
        let accessor = |view, kind, code, count| json!({"bufferView": view, "componentType": code, "type": kind, "count": count});
        let position = doc.push("accessors", accessor(position, "VEC3", 5126, 300));
        let index = doc.push("accessors", accessor(index, "SCALAR", 5125, 894));
        let doc = show(doc, json!({"attributes": {"POSITION": position}, "indices": index}));
        scenes.push(doc.load().unwrap());
    }
    // The triangle codec may turn a triangle's corners round, and keeps its sense.
    let turned = |scene: &conray_scene::Scene| -> Vec<[[u32; 3]; 3]> {
        let corners = world_corners(scene);
        let bits = |t: &[Vec3]| [0, 1, 2].map(|i| t[i].to_array().map(f32::to_bits));
        corners
            .chunks(3)
            .map(|t| (0..3).map(|k| bits(&[t[k], t[(k + 1) % 3], t[(k + 2) % 3]])).min().unwrap())
            .collect()
    };
    assert_eq!(turned(&scenes[0]), turned(&scenes[1]));
    assert_eq!(world_corners(&scenes[0]), world_corners(&scenes[2]));
}

#[test]
fn compressed_normals_are_unfiltered() {
    let expected = [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.6, -0.8), Vec3::NEG_X];
    let input: Vec<[f32; 4]> = expected.iter().map(|n| n.extend(0.0).to_array()).collect();
    let filtered: Vec<[i8; 4]> = meshopt::encode_filter_oct(&input, 8);
    let encoded = meshopt::encode_vertex_buffer(&filtered).unwrap();
    let mut doc = Document::new();
    let position = doc.floats(&SQUARE[..9], "VEC3");
    let view = doc.view(&encoded);
    let offset = doc.json["bufferViews"][view]["byteOffset"].clone();
    doc.json["bufferViews"][view]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 0, "byteOffset": offset,
        "byteLength": encoded.len(), "byteStride": 4, "count": 3, "mode": "ATTRIBUTES", "filter": "OCTAHEDRAL"}});
    let normal = doc.push(
        "accessors",
        json!({"bufferView": view, "componentType": 5120, "normalized": true, "type": "VEC3", "count": 3}),
    );
    let scene = show(doc, json!({"attributes": {"POSITION": position, "NORMAL": normal}})).load().unwrap();
    for (found, expected) in only_mesh(&scene).normals().iter().zip(expected) {
        assert!(found.angle_between(expected).to_degrees() < 1.5, "{found} {expected}");
    }
}
