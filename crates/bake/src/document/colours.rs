//! Colours of vertices: read as they are stored, added in sixteen bits.

use super::{
    Document, DocumentError,
    gather::{ARRAY_BUFFER, Buffers, Elements, number},
};
use serde_json::json;

/// Component types.
const UNSIGNED_BYTE: usize = 5121;
const UNSIGNED_SHORT: usize = 5123;
const FLOAT: usize = 5126;

/// Colours that an accessor holds.
pub(crate) struct Colours<'a> {
    elements: Elements<'a>,
    component: usize,
}

impl Document {
    /// The colours of an accessor: three or four floats, or integers of 8 or 16 bits that stand for shares of their largest.
    ///
    /// # Errors
    /// Another accessor, or one whose bytes are compressed or missing.
    pub(crate) fn colours<'a>(
        &self,
        accessor: usize,
        buffers: &'a Buffers,
    ) -> Result<Colours<'a>, DocumentError> {
        let found = self.elements(accessor, buffers).and_then(|elements| {
            let of = self.element("accessors", accessor).ok()?;
            let component = number(of, "componentType")?;
            let is_colour = [UNSIGNED_BYTE, UNSIGNED_SHORT, FLOAT].contains(&component)
                && matches!(of.get("type")?.as_str()?, "VEC3" | "VEC4");
            is_colour.then_some(Colours { elements, component })
        });
        let place = || format!("accessors/{accessor}");
        found.ok_or_else(|| DocumentError::Shape { place: place(), wanted: "readable as colours" })
    }

    /// Adds colours with alpha, in [0, 1], as an accessor for vertices.
    ///
    /// They are stored as four integers of 16 bits: two words, so that nothing is filled up where elements must start at whole words, as three of them would be;
    /// half of what floats take, and finer than any screen shows or any bake is sure of. Colours of 8 bits have their exact values among them.
    ///
    /// # Errors
    /// Where the document's lists are none.
    pub(crate) fn push_colours(&mut self, colours: &[[f32; 4]], name: &str) -> Result<usize, DocumentError> {
        let stored = |value: &f32| (value.clamp(0.0, 1.0) * f32::from(u16::MAX)).round() as u16;
        let bytes: Vec<u8> =
            colours.as_flattened().iter().flat_map(|value| stored(value).to_le_bytes()).collect();
        let view = self.push_bytes(&bytes, name)?;
        self.element_mut("bufferViews", view)?.insert("target".into(), ARRAY_BUFFER.into());
        let accessor = json!({
            "bufferView": view, "componentType": UNSIGNED_SHORT, "normalized": true, "count": colours.len(), "type": "VEC4"
        });
        self.push("accessors", accessor)
    }
}

impl Colours<'_> {
    /// The colour of a vertex, opaque where none says else; `None` where it is not there.
    pub(crate) fn get(&self, vertex: u32) -> Option<[f32; 4]> {
        let bytes = self.elements.get(vertex)?;
        let values: Vec<f32> = match self.component {
            UNSIGNED_BYTE => bytes.iter().map(|&byte| f32::from(byte) / f32::from(u8::MAX)).collect(),
            UNSIGNED_SHORT => {
                let value = |bytes: &[u8; 2]| f32::from(u16::from_le_bytes(*bytes)) / f32::from(u16::MAX);
                bytes.as_chunks().0.iter().map(value).collect()
            }
            _ => bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect(),
        };
        let at = |k: usize| values.get(k).copied().unwrap_or(1.0);
        Some([0, 1, 2, 3].map(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two colours of each kind: bytes, shorts with alpha, floats; and three numbers that are none.
    const TEXT: &str = r#"{"buffers":[{"uri":"b","byteLength":48}],
        "bufferViews":[{"buffer":0,"byteLength":8,"byteStride":4},{"buffer":0,"byteOffset":8,"byteLength":16},
            {"buffer":0,"byteOffset":24,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5121,"normalized":true,"type":"VEC3","count":2},
            {"bufferView":1,"componentType":5123,"normalized":true,"type":"VEC4","count":2},
            {"bufferView":2,"componentType":5126,"type":"VEC3","count":2},
            {"bufferView":2,"componentType":5125,"type":"VEC3","count":2},
            {"bufferView":2,"componentType":5126,"type":"VEC2","count":2}]}"#;

    fn document() -> (Document, Buffers) {
        let document = Document::open(TEXT.as_bytes()).unwrap();
        let mut bytes = vec![255, 51, 0, 7, 1, 2, 3, 7];
        bytes.extend([65535u16, 0, 13107, 32768, 1, 2, 3, 4].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0.25f32, 0.5, 1.0, 0.0, 0.0, 0.125].iter().flat_map(|x| x.to_le_bytes()));
        let buffers = Buffers::of(&document, |_| Some(bytes.clone())).unwrap();
        (document, buffers)
    }

    #[test]
    fn colours_of_all_kinds_are_read() {
        let (document, buffers) = document();
        let get = |accessor: usize, vertex| document.colours(accessor, &buffers).unwrap().get(vertex);
        assert_eq!(get(0, 0), Some([1.0, 0.2, 0.0, 1.0]));
        assert_eq!(get(1, 0), Some([1.0, 0.0, 0.2, 32768.0 / 65535.0]));
        assert_eq!(get(2, 1), Some([0.0, 0.0, 0.125, 1.0]));
        assert_eq!(get(2, 2), None);
        for accessor in [3, 4] {
            let found = document.colours(accessor, &buffers).err().unwrap().to_string();
            assert_eq!(found, format!("`accessors/{accessor}` is not readable as colours"));
        }
    }

    #[test]
    fn colours_come_back_as_they_were_added() {
        let (mut document, _) = document();
        let new = document
            .push_colours(&[[1.0, 0.2, 0.0, 2.0], [128.0 / 255.0, 0.0, f32::NAN, 0.5]], "new")
            .unwrap();
        let accessor = document.element("accessors", new).unwrap();
        assert_eq!((&accessor["normalized"], &accessor["type"]), (&true.into(), &"VEC4".into()));
        let view = accessor["bufferView"].as_u64().unwrap() as usize;
        assert_eq!(document.element("bufferViews", view).unwrap()["target"], ARRAY_BUFFER);
        let own = document.bin.clone();
        let buffers =
            Buffers::of(&document, |uri| Some(if uri == "b" { vec![0; 48] } else { own.clone() })).unwrap();
        let colours = document.colours(new, &buffers).unwrap();
        assert_eq!(colours.get(0), Some([1.0, 0.2, 0.0, 1.0]));
        let second = colours.get(1).unwrap();
        assert_eq!(second[..3], [128.0 / 255.0, 0.0, 0.0]);
        assert!((second[3] - 0.5).abs() < 1e-5);
    }
}
