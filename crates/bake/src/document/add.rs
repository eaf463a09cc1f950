//! What a document gains: bytes, accessors, images, textures.

use super::{Document, DocumentError, Kind, gather::ARRAY_BUFFER};
use serde_json::{Map, Value, json};

/// Linear, as most renderers take textures without a sampler.
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;
const CLAMP_TO_EDGE: u32 = 33071;
const REPEAT: u32 = 10497;
/// Component type of floats.
const FLOAT: u32 = 5126;

impl Document {
    /// Appends an element to one of the document's lists, and tells its index.
    ///
    /// # Errors
    /// Where the list is none.
    pub fn push(&mut self, list: &str, element: Value) -> Result<usize, DocumentError> {
        let all = self.root.entry(list).or_insert_with(|| Value::Array(Vec::new()));
        let all = all.as_array_mut();
        let all = all.ok_or_else(|| DocumentError::Shape { place: list.into(), wanted: "a list" })?;
        all.push(element);
        Ok(all.len() - 1)
    }

    /// Appends bytes, and tells the buffer view that holds them. `name` is that of a text document's file.
    ///
    /// # Errors
    /// Where the document's lists are none.
    pub fn push_bytes(&mut self, bytes: &[u8], name: &str) -> Result<usize, DocumentError> {
        let buffer = self.own_buffer(name)?;
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend(bytes);
        let length = self.bin.len();
        self.element_mut("buffers", buffer)?.insert("byteLength".into(), length.into());
        self.push("bufferViews", json!({ "buffer": buffer, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// The buffer that bytes are appended to: the binary chunk's, or a new one.
    fn own_buffer(&mut self, name: &str) -> Result<usize, DocumentError> {
        if let Some(buffer) = self.buffer {
            return Ok(buffer);
        }
        let is_chunk = self.kind == Kind::Binary
            && self.element("buffers", 0).is_ok_and(|buffer| !buffer.contains_key("uri"));
        let buffer = if is_chunk {
            0
        } else if self.kind == Kind::Text {
            {
                let uri = self.free_name(name, "bin");
                self.push("buffers", json!({ "uri": uri, "byteLength": 0 }))?
            }
        } else if self.count("buffers") == 0 {
            self.push("buffers", json!({ "byteLength": 0 }))?
        } else {
            // The chunk is buffer 0 or none, and indices must not change: the bytes stand in the text.
            return Err(DocumentError::Shape { place: "buffers/0".into(), wanted: "the binary chunk" });
        };
        self.buffer = Some(buffer);
        Ok(buffer)
    }

    /// A file name that the document does not name yet.
    fn free_name(&self, name: &str, ending: &str) -> String {
        let taken = |file: &String| {
            let named =
                |list: &str, k: usize| self.uri(list, k).is_some_and(|uri| uri.eq_ignore_ascii_case(file));
            ["buffers", "images"].iter().any(|list| (0..self.count(list)).any(|k| named(list, k)))
        };
        let names = (2..).map(|more| format!("{name}-{more}.{ending}"));
        let mut names = std::iter::once(format!("{name}.{ending}")).chain(names);
        names.find(|file| !taken(file)).expect("names without end")
    }

    /// Adds vectors of floats, each of `N` components, as an accessor for vertices.
    ///
    /// # Errors
    /// Where the document's lists are none.
    pub fn push_floats<const N: usize>(
        &mut self,
        values: &[[f32; N]],
        name: &str,
    ) -> Result<usize, DocumentError> {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.push_bytes(&bytes, name)?;
        self.element_mut("bufferViews", view)?.insert("target".into(), ARRAY_BUFFER.into());
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind });
        self.push("accessors", accessor)
    }

    /// Adds a PNG image and a texture of it, that repeats or else is clamped at its edges; tells the texture. `name` is that of the image,
    /// and of a text document's file.
    ///
    /// # Errors
    /// Where the document's lists are none.
    pub fn push_png(&mut self, png: Vec<u8>, name: &str, repeats: bool) -> Result<usize, DocumentError> {
        let wrap = if repeats { REPEAT } else { CLAMP_TO_EDGE };
        let image = match self.kind {
            Kind::Binary => {
                let view = self.push_bytes(&png, name)?;
                json!({ "name": name, "mimeType": "image/png", "bufferView": view })
            }
            Kind::Text => {
                let file = self.free_name(name, "png");
                let image = json!({ "name": name, "uri": file });
                self.added.push((file, png));
                image
            }
        };
        let image = self.push("images", image)?;
        let sampler = json!({
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR, "wrapS": wrap, "wrapT": wrap
        });
        let known = (0..self.count("samplers")).find(|&k| self.root["samplers"][k] == sampler);
        let sampler = match known {
            Some(known) => known,
            None => self.push("samplers", sampler)?,
        };
        self.push("textures", json!({ "name": name, "sampler": sampler, "source": image }))
    }

    /// Makes a texture the occlusion of a material, read by that UV set; `strength`, extensions and extras of the one before stay, but
    /// not how it moved its UVs.
    ///
    /// # Errors
    /// Where the material does not exist or is no object.
    pub fn set_occlusion(
        &mut self,
        material: usize,
        texture: usize,
        uv_set: usize,
    ) -> Result<(), DocumentError> {
        let material = self.element_mut("materials", material)?;
        let mut occlusion = match material.remove("occlusionTexture") {
            Some(Value::Object(before)) => before,
            _ => Map::new(),
        };
        occlusion.insert("index".into(), texture.into());
        occlusion.insert("texCoord".into(), uv_set.into());
        if let Some(Value::Object(extensions)) = occlusion.get_mut("extensions") {
            extensions.remove("KHR_texture_transform");
            if extensions.is_empty() {
                occlusion.remove("extensions");
            }
        }
        material.insert("occlusionTexture".into(), Value::Object(occlusion));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{super::Files, *};

    const TEXT: &str = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":4}],
        "images":[{"uri":"data:image/png;base64,AA=="},{"uri":"b.png"}],"samplers":[{}],
        "materials":[{"name":"m","occlusionTexture":{"index":3,"strength":0.5,"extras":7,
        "extensions":{"KHR_texture_transform":{"scale":[2,2]}}},"extras":[1]}]}"#;

    fn binary() -> Document {
        let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        let json = br#"{"buffers":[{"byteLength":6}]}  "#;
        for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", b"123456\0\0")] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        let length = file.len() as u32;
        file[8..12].copy_from_slice(&length.to_le_bytes());
        Document::open(&file).unwrap()
    }

    #[test]
    fn a_binary_document_keeps_all_in_its_chunk() {
        let mut document = binary();
        let texture = document.push_png(b"PNG-1".to_vec(), "ao", true).unwrap();
        let accessor = document.push_floats(&[[0.5, 1.0], [2.0, 3.0]], "ao").unwrap();
        assert_eq!((texture, accessor), (0, 0));
        let again = Document::open(&document.to_bytes().unwrap()).unwrap();
        let view = |k: usize| again.element("bufferViews", k).unwrap();
        let bytes = |k: usize| {
            let [offset, length] =
                ["byteOffset", "byteLength"].map(|key| view(k)[key].as_u64().unwrap() as usize);
            &again.bin[offset..offset + length]
        };
        assert_eq!(&again.bin[..6], b"123456");
        assert_eq!(bytes(0), b"PNG-1");
        assert_eq!(bytes(1)[..8], [0.5f32.to_le_bytes(), 1.0f32.to_le_bytes()].concat());
        assert!(view(1)["byteOffset"].as_u64().unwrap().is_multiple_of(4));
        assert_eq!(again.root()["buffers"][0]["byteLength"].as_u64(), Some(again.bin.len() as u64));
        assert_eq!(again.root()["images"][0]["mimeType"], "image/png");
        assert_eq!(again.root()["samplers"][0]["wrapS"], REPEAT);
        assert_eq!(document.files(), Files::default());
    }

    #[test]
    fn a_text_document_gains_files_and_knows_those_it_had() {
        let mut document = Document::open(TEXT.as_bytes()).unwrap();
        document.push_png(b"PNG".to_vec(), "ao-m", false).unwrap();
        document.push_png(b"PNG".to_vec(), "ao-n", false).unwrap();
        assert_eq!((document.count("samplers"), document.count("textures")), (2, 2), "one sampler for both");
        document.push_floats(&[[1.0]], "ao").unwrap();
        let files = document.files();
        assert_eq!(files.had, ["a.bin", "b.png"]);
        let names: Vec<&str> = files.added.iter().map(|(name, _)| &name[..]).collect();
        assert_eq!(names, ["ao-m.png", "ao-n.png", "ao.bin"]);
        assert_eq!(files.added[2].1, 1.0f32.to_le_bytes());
        assert_eq!(document.root()["buffers"][1], json!({ "uri": "ao.bin", "byteLength": 4 }));
    }

    #[test]
    fn files_that_the_document_names_are_not_replaced() {
        let mut document = Document::open(TEXT.as_bytes()).unwrap();
        document.push_png(b"PNG".to_vec(), "b", false).unwrap();
        document.push_png(b"PNG".to_vec(), "b", false).unwrap();
        document.push_floats(&[[1.0]], "a").unwrap();
        let files = document.files();
        assert_eq!(files.had, ["a.bin", "b.png"]);
        let names: Vec<&str> = files.added.iter().map(|(name, _)| &name[..]).collect();
        assert_eq!(names, ["b-2.png", "b-3.png", "a-2.bin"]);
    }

    #[test]
    fn occlusion_is_set_and_the_rest_of_the_material_stays() {
        let mut document = Document::open(TEXT.as_bytes()).unwrap();
        document.set_occlusion(0, 9, 1).unwrap();
        let expected = r#"{"name":"m","extras":[1],"occlusionTexture":{"index":9,"strength":0.5,"extras":7,"texCoord":1}}"#;
        let material = document.element("materials", 0).unwrap();
        assert_eq!(Value::Object(material.clone()), serde_json::from_str::<Value>(expected).unwrap());
        assert_eq!(document.set_occlusion(1, 0, 0).unwrap_err().to_string(), "`materials/1` does not exist");
    }

    #[test]
    fn lists_that_are_none_are_told() {
        let mut document = Document::open(br#"{"textures":{},"materials":[3]}"#).unwrap();
        assert_eq!(document.push("textures", json!({})).unwrap_err().to_string(), "`textures` is not a list");
        assert_eq!(
            document.set_occlusion(0, 0, 0).unwrap_err().to_string(),
            "`materials/0` is not an object"
        );
    }
}
