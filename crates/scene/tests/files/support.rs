//! Short ways to load a text, to make an image and to make a glTF.

use conray_core::{TriangleMesh, Vec3};
use conray_scene::{Extras, Limits, Scene, SceneError, WarningKind, load_bytes_with};
use serde_json::{Value, json};
use std::io;

/// Loads a file that names no others.
pub(crate) fn load(name: &str, bytes: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    load_with(name, bytes, &[])
}

/// Loads a file with the others that it names.
pub(crate) fn load_with(
    name: &str,
    bytes: impl AsRef<[u8]>,
    others: &[(&str, &[u8])],
) -> Result<Scene, SceneError> {
    load_extras(name, bytes, others, Extras::default())
}

/// The same with more than what occludes.
pub(crate) fn load_extras(
    name: &str,
    bytes: impl AsRef<[u8]>,
    others: &[(&str, &[u8])],
    extras: Extras,
) -> Result<Scene, SceneError> {
    let resolve = |wanted: &str| {
        let found = others.iter().find(|(name, _)| *name == wanted);
        found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    load_bytes_with(name, bytes.as_ref(), None, &resolve, &Limits::default(), extras)
}

/// How often a kind of oddity was met.
pub(crate) fn count(scene: &Scene, kind: WarningKind) -> u64 {
    scene.warnings.iter().filter(|w| w.kind == kind).map(|w| w.count).sum()
}

/// The only mesh of a scene.
pub(crate) fn only_mesh(scene: &Scene) -> &TriangleMesh {
    assert_eq!(scene.geometry.meshes().len(), 1);
    &scene.geometry.meshes()[0]
}

/// All corners of all triangles in the world, in order.
pub(crate) fn world_corners(scene: &Scene) -> Vec<Vec3> {
    let g = &scene.geometry;
    let of_instance = |i: usize| {
        let (mesh, m) = (g.mesh_of(i), g.instances()[i].world_from_mesh);
        (0..mesh.triangles().len()).flat_map(move |t| mesh.corners(t)).map(move |p| m.transform_point3(p))
    };
    (0..g.instances().len()).flat_map(of_instance).collect()
}

/// A PNG of colour type `kind` from the bytes of its pixels.
pub(crate) fn png(width: u32, height: u32, kind: image::ExtendedColorType, pixels: &[u8]) -> Vec<u8> {
    use image::ImageEncoder;
    let mut out = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut out);
    encoder.write_image(pixels, width, height, kind).unwrap();
    out
}

/// Two texels, one above the other, black: alpha 255 at the top, 51 (a fifth) below.
pub(crate) fn png_with_alpha() -> Vec<u8> {
    png(1, 2, image::ExtendedColorType::Rgba8, &[0, 0, 0, 255, 0, 0, 0, 51])
}

/// A glTF document in the making: JSON and one buffer.
pub(crate) struct Document {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl Document {
    /// A document with an empty scene.
    pub(crate) fn new() -> Self {
        let lists = ["nodes", "meshes", "accessors", "bufferViews", "materials", "textures", "images"];
        let mut json = json!({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]});
        lists.iter().for_each(|list| json[list] = json!([]));
        Self { json, bytes: Vec::new() }
    }

    /// Appends to one of the document's lists and returns the index there.
    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Adds bytes and a view of them.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Adds an accessor with its data; `kind` as in the file, codes as in the file.
    pub(crate) fn accessor(&mut self, bytes: &[u8], code: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": code, "type": kind, "count": count}),
        )
    }

    /// Adds an accessor of floats.
    pub(crate) fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width = if kind == "SCALAR" { 1 } else { usize::from(kind.as_bytes()[3] - b'0') };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, values.len() / width)
    }

    /// Adds a mesh of one triangle with corners 0, X, Y and returns it.
    pub(crate) fn triangle(&mut self) -> usize {
        let position = self.floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.], "VEC3");
        self.push("meshes", json!({"name": "tri", "primitives": [{"attributes": {"POSITION": position}}]}))
    }

    /// Adds a node to the scene's roots.
    pub(crate) fn root(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index));
        index
    }

    /// The document as GLB.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut root = self.json.clone();
        if root.get("buffers").is_none() {
            root["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        }
        let mut json = serde_json::to_vec(&root).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bytes.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let chunk =
            |kind: &[u8; 4], body: &[u8]| [&(body.len() as u32).to_le_bytes()[..], kind, body].concat();
        let body = [chunk(b"JSON", &json), chunk(b"BIN\0", &bin)].concat();
        [b"glTF", &2u32.to_le_bytes()[..], &(body.len() as u32 + 12).to_le_bytes(), &body].concat()
    }

    /// Loads the document as GLB.
    pub(crate) fn load(&self) -> Result<Scene, SceneError> {
        load("doc.glb", self.glb())
    }
}
