//! Models whose vertices show values: what is written, and what a reader makes of it.

use conray::{AoSettings, Control, Session};
use conray_bake::{
    Document, Facing, Origins, Slots, VertexAttribute, VertexSettings, VertexTarget, VertexValues,
    WriteError, Written, objects, write_vertex_model,
};
use conray_scene::{Limits, Scene, load};
use conray_target::Target;
use serde_json::{Value, json};
use std::{
    f32::consts::FRAC_1_SQRT_2,
    fs,
    path::{Path, PathBuf},
};

/// A document in the making: accessors of elements one after the other in one buffer.
#[derive(Default)]
struct Model {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Model {
    fn add(
        &mut self,
        bytes: &[u8],
        component: u32,
        kind: &str,
        count: usize,
        stride: Option<usize>,
    ) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.bin.extend(bytes);
        self.views.push(view);
        let mut accessor = json!({ "bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": kind });
        if kind == "VEC4" {
            accessor["normalized"] = true.into();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(&bytes, 5126, kind, values.len(), None)
    }

    fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(&bytes, 5123, "SCALAR", indices.len(), None)
    }

    /// Writes it as text with a file beside it.
    fn write(self, folder: &Path, meshes: Value, nodes: Value) -> PathBuf {
        fs::write(folder.join("m.bin"), &self.bin).unwrap();
        let count = nodes.as_array().unwrap().len();
        let document = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": (0..count).collect::<Vec<_>>() }],
            "nodes": nodes, "meshes": meshes, "materials": [{ "name": "a" }, { "name": "b" }],
            "buffers": [{ "uri": "m.bin", "byteLength": self.bin.len() }], "extras": { "kept": 0.01 },
            "bufferViews": self.views, "accessors": self.accessors,
        });
        let path = folder.join("m.gltf");
        fs::write(&path, document.to_string()).unwrap();
        path
    }
}

/// A scene with its values.
struct Baked {
    scene: Scene,
    slots: Slots,
    values: VertexValues,
    written: Result<Written, WriteError>,
}

fn bake(source: &Path, to: &Path, attribute: VertexAttribute) -> Baked {
    let scene = load(source, &Limits::default()).unwrap();
    let settings = AoSettings { rays: Some(64), ..AoSettings::default() };
    let session = Session::build(scene.geometry.clone(), &settings).unwrap();
    let instances: Vec<u32> = (0..scene.geometry.instances().len() as u32).collect();
    let slots = Slots::of(&session, &instances, &objects(&scene.geometry, &scene.origins));
    let target = VertexTarget::new(&session, slots, &VertexSettings::default(), &Facing::default()).unwrap();
    let estimates = session.run_target(&target, Control::none()).unwrap().estimates;
    let values = target.resolve(&estimates).unwrap();
    let document = Document::open(&fs::read(source).unwrap()).unwrap();
    let vertices: Vec<&[u32]> = scene
        .geometry
        .instances()
        .iter()
        .map(|instance| &scene.sources[instance.mesh as usize][..])
        .collect();
    let origins = Origins { instances: &scene.origins, vertices: &vertices };
    let slots = target.slots().clone();
    let written = write_vertex_model(to, source, document, &origins, &slots, &values, attribute);
    Baked { scene, slots, values, written }
}

/// A written document and the bytes of its buffers.
struct Shown {
    root: Value,
    buffers: Vec<Vec<u8>>,
}

impl Shown {
    fn open(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let root = Value::Object(Document::open(&bytes).unwrap().root().clone());
        let folder = path.parent().unwrap();
        let of = |buffer: &Value| match buffer["uri"].as_str() {
            Some(uri) => fs::read(folder.join(uri)).unwrap(),
            // The chunk behind the JSON.
            None => bytes[28 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize..].to_vec(),
        };
        let buffers = root["buffers"].as_array().unwrap().iter().map(of).collect();
        Self { root, buffers }
    }

    fn primitive(&self, node: usize, primitive: usize) -> &Value {
        let mesh = self.root["nodes"][node]["mesh"].as_u64().unwrap() as usize;
        &self.root["meshes"][mesh]["primitives"][primitive]
    }

    /// The elements of an accessor.
    fn elements(&self, accessor: &Value) -> Vec<&[u8]> {
        let accessor = &self.root["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &self.root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let number = |of: &Value, key: &str| of[key].as_u64().map(|number| number as usize);
        let components = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            kind => kind[3..].parse().unwrap(),
        };
        let bytes = match number(accessor, "componentType").unwrap() {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let size = components * bytes;
        let stride = number(view, "byteStride").unwrap_or(size);
        assert!(stride.is_multiple_of(4) || view["target"] != 34962, "elements start at whole words");
        let start = number(view, "byteOffset").unwrap_or(0);
        let buffer = &self.buffers[number(view, "buffer").unwrap()];
        let all = 0..number(accessor, "count").unwrap();
        all.map(|k| &buffer[start + k * stride..][..size]).collect()
    }

    fn floats(&self, accessor: &Value) -> Vec<Vec<f32>> {
        let of = |bytes: &[u8]| bytes.as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect();
        self.elements(accessor).into_iter().map(of).collect()
    }

    fn colours(&self, accessor: &Value) -> Vec<Vec<f32>> {
        let of = |bytes: &[u8]| {
            bytes.as_chunks().0.iter().map(|two| f32::from(u16::from_le_bytes(*two)) / 65535.0).collect()
        };
        self.elements(accessor).into_iter().map(of).collect()
    }
}

const QUAD: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const ALONG_Z: [[f32; 3]; 4] = [[0.0, 0.0, 1.0]; 4];

/// Two quads at a right angle, by one mesh with colours and alpha that two nodes show.
fn two_quads(folder: &Path) -> PathBuf {
    let mut model = Model::default();
    let (position, normal) = (model.floats(&QUAD, "VEC3"), model.floats(&ALONG_Z, "VEC3"));
    let colours = [[255, 51, 0, 128], [255, 255, 255, 255], [0, 0, 0, 0], [51, 51, 51, 51]];
    let colour = model.add(colours.as_flattened(), 5121, "VEC4", 4, None);
    let indices = model.indices(&[0, 1, 2, 0, 2, 3]);
    let attributes = json!({ "COLOR_0": colour, "POSITION": position, "NORMAL": normal });
    let meshes = json!([{ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }]);
    let lying =
        json!({ "mesh": 0, "rotation": [-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2], "translation": [0, 0, 1] });
    model.write(folder, meshes, json!([{ "mesh": 0 }, lying]))
}

#[test]
fn colours_are_multiplied_or_replaced_and_alpha_stays() {
    let folder = tempfile::tempdir().unwrap();
    let source = two_quads(folder.path());
    let before = Shown::open(&source);
    for attribute in [VertexAttribute::Color, VertexAttribute::MultipliedColor] {
        let out = folder.path().join("baked.gltf");
        let baked = bake(&source, &out, attribute);
        let names = baked.written.unwrap().files;
        assert_eq!(names, [folder.path().join("baked-ao.bin"), out.clone()]);
        let after = Shown::open(&out);
        assert_eq!(after.root["extras"], before.root["extras"]);
        assert_eq!(after.root["meshes"].as_array().unwrap().len(), 2, "what the nodes show differs");
        for node in 0..2 {
            let (shown, had) = (after.primitive(node, 0), before.primitive(node, 0));
            let keys = |primitive: &Value| {
                primitive["attributes"].as_object().unwrap().keys().cloned().collect::<Vec<_>>()
            };
            assert_eq!(keys(shown), keys(had), "in their order");
            assert_eq!(
                (&shown["indices"], &shown["attributes"]["POSITION"]),
                (&had["indices"], &had["attributes"]["POSITION"])
            );
            let colours = after.colours(&shown["attributes"]["COLOR_0"]);
            assert_eq!(colours.len(), 4);
            for (vertex, had) in before.elements(&had["attributes"]["COLOR_0"]).iter().enumerate() {
                let at = baked.scene.sources[0].iter().position(|&v| v as usize == vertex).unwrap();
                let value = baked.values.visibility[baked.slots.surfaces()[node].slots[at] as usize];
                for (k, &had) in had.iter().enumerate() {
                    let had = f32::from(had) / 255.0;
                    let expected = match (attribute, k) {
                        (_, 3) => had,
                        (VertexAttribute::Color, _) => value,
                        _ => had * value,
                    };
                    assert!((colours[vertex][k] - expected).abs() < 1e-5, "{attribute:?} {vertex} {k}");
                }
            }
        }
        // Where the quads meet it is darker than at their far edges.
        let grey = |node: usize| after.colours(&after.primitive(node, 0)["attributes"]["COLOR_0"]);
        if attribute == VertexAttribute::Color {
            assert!(grey(0)[0][0] < grey(0)[3][0] - 0.05, "{:?}", grey(0));
        }
        let (loaded, original) = (load(&out, &Limits::default()).unwrap(), &baked.scene);
        assert_eq!(loaded.origins.len(), 2);
        for (one, other) in loaded.geometry.instances().iter().zip(original.geometry.instances()) {
            let [one, other] =
                [(&loaded, one), (original, other)].map(|(s, i)| &s.geometry.meshes()[i.mesh as usize]);
            assert_eq!(
                (one.positions(), one.triangles(), one.normals()),
                (other.positions(), other.triangles(), other.normals())
            );
        }
    }
}

#[test]
fn a_flat_box_gets_vertices_for_its_hard_edges_with_all_that_they_had() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = Model::default();
    let corner = |k: u8| [0, 1, 2].map(|axis| f32::from(k >> axis & 1));
    let position = model.floats(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner), "VEC3");
    let marks: Vec<u8> = (0..8).flat_map(|k| [k, 0, 0, 0]).collect();
    let mark = model.add(&marks, 5121, "SCALAR", 8, Some(4));
    let moved = model.floats(&[0, 1, 2, 3, 4, 5, 6, 7].map(|k: u8| [f32::from(k), 0.0, 0.0]), "VEC3");
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]];
    let indices: Vec<u16> = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let indices = model.indices(&indices);
    let primitive = json!({
        "attributes": { "POSITION": position, "_MARK": mark }, "targets": [{ "POSITION": moved }], "indices": indices
    });
    let source = model.write(folder.path(), json!([{ "primitives": [primitive] }]), json!([{ "mesh": 0 }]));
    let out = folder.path().join("baked.gltf");
    let baked = bake(&source, &out, VertexAttribute::Ao);
    assert!(baked.slots.surfaces()[0].is_split());
    assert_eq!(baked.written.unwrap().files.len(), 2);
    let after = Shown::open(&out);
    let shown = after.primitive(0, 0);
    assert_eq!(shown.as_object().unwrap().keys().collect::<Vec<_>>(), ["attributes", "targets", "indices"]);
    let [marks, positions] = ["_MARK", "POSITION"].map(|key| after.elements(&shown["attributes"][key]));
    let values = after.floats(&shown["attributes"]["_AO"]);
    assert_eq!((marks.len(), positions.len(), values.len()), (24, 24, 24));
    let targets = after.floats(&shown["targets"][0]["POSITION"]);
    for (k, mark) in marks.iter().enumerate() {
        assert_eq!(targets[k][0], f32::from(mark[0]));
        assert_eq!(after.floats(&shown["attributes"]["POSITION"])[k], corner(mark[0]));
    }
    let accessor = &after.root["accessors"][shown["attributes"]["_AO"].as_u64().unwrap() as usize];
    assert_eq!((&accessor["componentType"], &accessor["type"]), (&5126.into(), &"SCALAR".into()));
    // Each corner shows the value of its slot.
    let loaded = load(&out, &Limits::default()).unwrap();
    let (mesh, before) = (&loaded.geometry.meshes()[0], &baked.scene.geometry.meshes()[0]);
    for triangle in 0..12 {
        assert_eq!(mesh.corners(triangle), before.corners(triangle));
        let slots = baked.slots.surfaces()[0].corners(triangle);
        for (vertex, slot) in mesh.triangles()[triangle].into_iter().zip(slots) {
            let written = loaded.sources[0][vertex as usize] as usize;
            assert_eq!(values[written][0], baked.values.visibility[slot as usize]);
        }
    }
    assert!(baked.values.visibility.iter().all(|&value| value == 1.0), "nothing is about it");
}

#[test]
fn parts_of_one_node_agree_where_they_meet_and_share_no_long_lists() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = Model::default();
    // A quad of two materials in the corner of a list of a hundred vertices, and another mesh that stands on it.
    let mut places = QUAD.to_vec();
    places.resize(100, [9.0, 9.0, 9.0]);
    let (position, normal) = (model.floats(&places, "VEC3"), model.floats(&[[0.0, 0.0, 1.0]; 100], "VEC3"));
    let (one, other) = (model.indices(&[2, 0, 1]), model.indices(&[0, 2, 3]));
    let attributes = json!({ "POSITION": position, "NORMAL": normal });
    let part =
        |indices, material| json!({ "attributes": attributes, "indices": indices, "material": material });
    let meshes = json!([{ "primitives": [part(one, 0), part(other, 1)] }, { "primitives": [part(one, 0)] }]);
    let standing = json!({ "mesh": 1, "rotation": [FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2] });
    let source = model.write(folder.path(), meshes, json!([{ "mesh": 0 }, standing]));
    let out = folder.path().join("baked.gltf");
    let baked = bake(&source, &out, VertexAttribute::Ao);
    baked.written.unwrap();
    let after = Shown::open(&out);
    let parts = [0, 1].map(|primitive| after.primitive(0, primitive));
    let found = parts.map(|part| {
        let [places, values] = ["POSITION", "_AO"].map(|key| after.floats(&part["attributes"][key]));
        assert_eq!((places.len(), values.len()), (3, 3), "those that it uses");
        places.into_iter().zip(values).collect::<Vec<_>>()
    });
    let shared: Vec<_> =
        found[0].iter().filter_map(|at| Some((at, found[1].iter().find(|o| o.0 == at.0)?))).collect();
    assert_eq!(shared.len(), 2);
    assert!(shared.iter().all(|(a, b)| a.1 == b.1) && shared.iter().any(|(a, _)| a.1[0] < 0.9), "{shared:?}");
    assert_eq!(after.root["meshes"].as_array().unwrap().len(), 2);
    assert_eq!(load(&out, &Limits::default()).unwrap().geometry.triangle_count(), 3);
}

#[test]
fn a_binary_model_keeps_its_bytes_and_gains_more_behind_them() {
    let folder = tempfile::tempdir().unwrap();
    let text = two_quads(folder.path());
    let mut json: Value = serde_json::from_slice(&fs::read(&text).unwrap()).unwrap();
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    let (mut json, bin) = (json.to_string().into_bytes(), fs::read(folder.path().join("m.bin")).unwrap());
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file =
        [&b"glTF"[..], &2u32.to_le_bytes(), &((28 + json.len() + bin.len()) as u32).to_le_bytes()].concat();
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bin)] {
        file.extend([&(chunk.len() as u32).to_le_bytes()[..], kind, chunk].concat());
    }
    let source = folder.path().join("m.glb");
    fs::write(&source, file).unwrap();
    let out = folder.path().join("baked.glb");
    let baked = bake(&source, &out, VertexAttribute::Color);
    assert_eq!(baked.written.unwrap().files, std::slice::from_ref(&out));
    let after = Shown::open(&out);
    assert_eq!(after.buffers[0][..bin.len()], bin);
    for node in 0..2 {
        let colours = after.colours(&after.primitive(node, 0)["attributes"]["COLOR_0"]);
        let slots = &baked.slots.surfaces()[node].slots;
        for (at, &slot) in slots.iter().enumerate() {
            let vertex = baked.scene.sources[0][at] as usize;
            assert!((colours[vertex][0] - baked.values.visibility[slot as usize]).abs() < 1e-5);
        }
    }
    let before: Vec<Value> = Shown::open(&text).root["accessors"].as_array().unwrap().clone();
    assert_eq!(after.root["accessors"].as_array().unwrap()[..before.len()], before);
}

#[test]
fn copies_that_one_node_places_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = Model::default();
    let (position, places) = (model.floats(&QUAD, "VEC3"), model.floats(&[[0.0f32; 3], [2.0; 3]], "VEC3"));
    let indices = model.indices(&[0, 1, 2, 0, 2, 3]);
    let meshes = json!([{ "primitives": [{ "attributes": { "POSITION": position }, "indices": indices }] }]);
    let copies = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    let source = model.write(folder.path(), meshes, json!([{ "mesh": 0, "extensions": copies }]));
    let out = folder.path().join("baked.gltf");
    let refused = bake(&source, &out, VertexAttribute::Ao).written.unwrap_err().to_string();
    assert!(refused.starts_with("node 0 places several copies"), "{refused}");
    assert!(!out.exists());
}
