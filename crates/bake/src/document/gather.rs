//! Vertices written anew: chosen elements of an accessor, as they are, and new indices.

use super::{
    Document, DocumentError,
    bounds::{component_bytes, components, set_bounds},
};
use serde_json::{Map, Value};
use std::collections::HashMap;

/// What a buffer view is for.
pub(super) const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Component type of indices.
const UNSIGNED_INT: u32 = 5125;

/// The bytes of a document's buffers, in order.
#[derive(Clone, Debug, Default)]
pub struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Those of a document: the binary chunk, data in the text, and files, for which `read` is asked by the names written in the document.
    ///
    /// # Errors
    /// The name of a buffer that cannot be had.
    pub fn of(
        document: &Document,
        mut read: impl FnMut(&str) -> Option<Vec<u8>>,
    ) -> Result<Self, DocumentError> {
        let bytes = |index: usize| {
            let buffer = document.element("buffers", index)?;
            let found = match buffer.get("uri").and_then(Value::as_str) {
                None => Some(document.bin.clone()),
                Some(uri) => read(uri),
            };
            found.ok_or_else(|| DocumentError::Missing(format!("buffers/{index}")))
        };
        (0..document.count("buffers")).map(bytes).collect::<Result<_, _>>().map(Self)
    }

    pub(super) fn range(&self, buffer: usize, offset: usize, length: usize) -> Option<&[u8]> {
        self.0.get(buffer)?.get(offset..)?.get(..length)
    }
}

/// Elements of an accessor, byte by byte.
pub(super) struct Elements<'a> {
    /// Of the view from the first element on; `None` where all are zero.
    bytes: Option<&'a [u8]>,
    stride: usize,
    size: usize,
    /// Elements that differ.
    sparse: HashMap<u64, &'a [u8]>,
}

impl Elements<'_> {
    pub(super) fn get(&self, index: u32) -> Option<Vec<u8>> {
        if let Some(bytes) = self.sparse.get(&u64::from(index)) {
            return Some(bytes.to_vec());
        }
        match self.bytes {
            None => Some(vec![0; self.size]),
            Some(bytes) => {
                let from = (index as usize).checked_mul(self.stride)?;
                bytes.get(from..)?.get(..self.size).map(<[u8]>::to_vec)
            }
        }
    }
}

pub(super) fn number(map: &Map<String, Value>, key: &str) -> Option<usize> {
    map.get(key).and_then(Value::as_u64).and_then(|number| usize::try_from(number).ok())
}

impl Document {
    /// Adds an accessor of chosen elements of another one: of the same type, with the same bytes.
    ///
    /// # Errors
    /// An accessor that is not what it must be, or whose bytes are compressed or missing.
    pub fn gather(
        &mut self,
        accessor: usize,
        chosen: &[u32],
        buffers: &Buffers,
        name: &str,
    ) -> Result<usize, DocumentError> {
        let unreadable =
            || DocumentError::Shape { place: format!("accessors/{accessor}"), wanted: "readable" };
        let elements = self.elements(accessor, buffers).ok_or_else(unreadable)?;
        let stride = elements.size.next_multiple_of(4);
        let mut bytes = Vec::with_capacity(chosen.len() * stride);
        for &index in chosen {
            bytes.extend(elements.get(index).ok_or_else(unreadable)?);
            bytes.resize(bytes.len().next_multiple_of(stride), 0);
        }
        let view = self.push_bytes(&bytes, name)?;
        let of_view = self.element_mut("bufferViews", view)?;
        of_view.insert("byteStride".into(), stride.into());
        of_view.insert("target".into(), ARRAY_BUFFER.into());
        let mut copy = self.element("accessors", accessor)?.clone();
        ["byteOffset", "sparse"].iter().for_each(|key| {
            copy.remove(*key);
        });
        copy.insert("bufferView".into(), view.into());
        copy.insert("count".into(), chosen.len().into());
        if copy.contains_key("min") || copy.contains_key("max") {
            // They must be those of the elements that are left.
            set_bounds(&mut copy, &bytes, stride);
        }
        self.push("accessors", Value::Object(copy))
    }

    /// Adds a list of indices.
    ///
    /// # Errors
    /// Where the document's lists are none.
    pub fn push_indices(&mut self, indices: &[u32], name: &str) -> Result<usize, DocumentError> {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.push_bytes(&bytes, name)?;
        self.element_mut("bufferViews", view)?.insert("target".into(), ELEMENT_ARRAY_BUFFER.into());
        let count = indices.len();
        let accessor = serde_json::json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR"
        });
        self.push("accessors", accessor)
    }

    /// `None` for an accessor that cannot be read.
    pub(super) fn elements<'a>(&self, accessor: usize, buffers: &'a Buffers) -> Option<Elements<'a>> {
        let accessor = self.element("accessors", accessor).ok()?;
        let component = component_bytes(number(accessor, "componentType")?)?;
        let size = component * components(accessor)?;
        let (bytes, stride) = match number(accessor, "bufferView") {
            None => (None, size),
            Some(view) => {
                let (bytes, stride) = self.view(view, buffers)?;
                (Some(bytes.get(number(accessor, "byteOffset").unwrap_or(0)..)?), stride.unwrap_or(size))
            }
        };
        let mut sparse = HashMap::new();
        if let Some(Value::Object(of)) = accessor.get("sparse") {
            let part = |key: &str| {
                let part = of.get(key)?.as_object()?;
                let bytes = self.view(number(part, "bufferView")?, buffers)?.0;
                Some((part, bytes.get(number(part, "byteOffset").unwrap_or(0)..)?))
            };
            let ((indices, index_bytes), (_, values)) = (part("indices")?, part("values")?);
            let width = component_bytes(number(indices, "componentType")?)?;
            for k in 0..number(of, "count")? {
                let index = index_bytes.get(k * width..)?.get(..width)?;
                let index = index.iter().rev().fold(0u64, |index, &byte| index << 8 | u64::from(byte));
                sparse.insert(index, values.get(k * size..)?.get(..size)?);
            }
        }
        Some(Elements { bytes, stride, size, sparse })
    }

    /// Bytes of a view that is not compressed, and the distance between its elements.
    fn view<'a>(&self, view: usize, buffers: &'a Buffers) -> Option<(&'a [u8], Option<usize>)> {
        let view = self.element("bufferViews", view).ok()?;
        let extensions = view.get("extensions").and_then(Value::as_object);
        if extensions.is_some_and(|all| all.keys().any(|name| name.ends_with("meshopt_compression"))) {
            return None;
        }
        let offset = number(view, "byteOffset").unwrap_or(0);
        let bytes = buffers.range(number(view, "buffer")?, offset, number(view, "byteLength")?)?;
        Some((bytes, number(view, "byteStride").filter(|&stride| stride > 0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::json;

    /// Three elements of three bytes, four bytes apart, from byte 2 on; of which sparse element 1 is 9 9 9.
    const TEXT: &str = r#"{"buffers":[{"uri":"b.bin","byteLength":24}],
        "bufferViews":[{"buffer":0,"byteOffset":2,"byteLength":12,"byteStride":4},{"buffer":0,"byteOffset":16,"byteLength":2},
            {"buffer":0,"byteOffset":18,"byteLength":3},
            {"buffer":0,"byteLength":4,"extensions":{"EXT_meshopt_compression":{}}}],
        "accessors":[{"bufferView":0,"componentType":5121,"normalized":true,"type":"VEC3","count":3,"max":[9,9,9],
            "sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":2}}},
            {"bufferView":3,"componentType":5121,"type":"SCALAR","count":4},
            {"componentType":5126,"type":"VEC2","count":7}]}"#;

    fn document() -> (Document, Buffers) {
        let document = Document::open(TEXT.as_bytes()).unwrap();
        let bytes = [0, 0, 1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 0, 0, 1, 0, 9, 9, 9, 0, 0, 0];
        let buffers = Buffers::of(&document, |name| (name == "b.bin").then(|| bytes.to_vec())).unwrap();
        (document, buffers)
    }

    #[test]
    fn chosen_elements_are_copied_byte_by_byte() {
        let (mut document, buffers) = document();
        let new = document.gather(0, &[2, 1, 2], &buffers, "new").unwrap();
        assert_eq!(document.bin, [7, 8, 9, 0, 9, 9, 9, 0, 7, 8, 9, 0]);
        let accessor = document.element("accessors", new).unwrap();
        assert_eq!((&accessor["normalized"], &accessor["count"]), (&true.into(), &3.into()));
        assert!(!accessor.contains_key("sparse"));
        assert_eq!((&accessor["min"], &accessor["max"]), (&json!([7, 8, 9]), &json!([9, 9, 9])));
        let zeros = document.gather(2, &[6], &buffers, "new").unwrap();
        assert_eq!(document.element("accessors", zeros).unwrap()["type"], "VEC2");
        assert_eq!(document.bin[12..], [0; 8]);
    }

    #[test]
    fn what_cannot_be_read_is_told_by_name() {
        let (mut document, buffers) = document();
        for (accessor, chosen) in [(0, 3), (1, 0)] {
            let found = document.gather(accessor, &[chosen], &buffers, "new").unwrap_err().to_string();
            assert_eq!(found, format!("`accessors/{accessor}` is not readable"));
        }
        assert!(document.gather(9, &[0], &buffers, "new").is_err());
        let missing = Buffers::of(&document, |_| None).unwrap_err().to_string();
        assert_eq!(missing, "`buffers/0` does not exist");
    }

    proptest! {
        #[test]
        fn no_numbers_make_it_panic(
            numbers in prop::collection::vec(prop_oneof![0u64..30, Just(u64::MAX)], 12),
            chosen in prop_oneof![0u32..5, Just(u32::MAX)],
        ) {
            let [a, b, c, d, e, f, g, h, i, j, k, l] = numbers[..] else { unreachable!() };
            let text = format!(
                r#"{{"buffers":[{{"byteLength":{a}}}],"bufferViews":[{{"buffer":{b},"byteOffset":{c},"byteLength":{d},"byteStride":{e}}}],
                "accessors":[{{"bufferView":{f},"byteOffset":{g},"componentType":5123,"type":"VEC2","count":{h},
                "sparse":{{"count":{i},"indices":{{"bufferView":{j},"componentType":5121}},"values":{{"bufferView":0,"byteOffset":{k}}}}}}}]}}"#
            );
            let mut document = Document::open(text.as_bytes()).unwrap();
            let buffers = Buffers(vec![vec![1; (l % 40) as usize]]);
            let _ = document.gather(0, &[chosen], &buffers, "new");
        }
    }
}
