//! What an accessor says of its elements: their size, and the least and the largest of their values.
//!
//! ("glTF 2.0 Specification", section 3.6.2.)

use super::gather::number;
use serde_json::{Map, Value};

/// Component types: of floats, and of integers with a sign.
const FLOAT: usize = 5126;
const BYTE: usize = 5120;
const SHORT: usize = 5122;

/// Sets the least and the largest value of each component, as it is stored. Positions must have them, also where they are integers
/// ("KHR_mesh_quantization").
pub(super) fn set_bounds(accessor: &mut Map<String, Value>, bytes: &[u8], stride: usize) {
    accessor.remove("min");
    accessor.remove("max");
    let kind = number(accessor, "componentType");
    let (Some(width), Some(components)) = (kind.and_then(component_bytes), components(accessor)) else {
        return;
    };
    let mut bounds = vec![[f64::INFINITY, f64::NEG_INFINITY]; components];
    for element in bytes.chunks_exact(stride) {
        for (bounds, value) in bounds.iter_mut().zip(element.chunks_exact(width)) {
            let value = component(kind, value);
            *bounds = [bounds[0].min(value), bounds[1].max(value)];
        }
    }
    for (k, key) in ["min", "max"].into_iter().enumerate() {
        // Floats as doubles of the same value.
        let number = |bounds: &[f64; 2]| match kind {
            Some(FLOAT) => Value::from(bounds[k]),
            _ => Value::from(bounds[k] as i64),
        };
        accessor.insert(key.into(), bounds.iter().map(number).collect());
    }
}

/// A component as it is stored, of the bytes that it has.
fn component(kind: Option<usize>, bytes: &[u8]) -> f64 {
    let mut whole = [0; 4];
    whole[..bytes.len()].copy_from_slice(bytes);
    let value = u32::from_le_bytes(whole);
    match kind {
        Some(BYTE) => f64::from(value as u8 as i8),
        Some(SHORT) => f64::from(value as u16 as i16),
        Some(FLOAT) => f64::from(f32::from_bits(value)),
        _ => f64::from(value),
    }
}

/// Components of an element; `None` for matrices.
pub(super) fn components(accessor: &Map<String, Value>) -> Option<usize> {
    let types = ["SCALAR", "VEC2", "VEC3", "VEC4"];
    let kind = accessor.get("type")?.as_str()?;
    types.iter().position(|&known| known == kind).map(|position| position + 1)
}

/// Bytes of a component; `None` for a type that glTF does not have.
pub(super) fn component_bytes(code: usize) -> Option<usize> {
    match code {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        5125 | 5126 => Some(4),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Buffers, Document};
    use serde_json::json;

    #[test]
    fn bounds_are_those_of_the_elements_that_are_left() {
        let text = r#"{"buffers":[{"uri":"b","byteLength":24}],"bufferViews":[{"buffer":0,"byteLength":24}],
            "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC2","count":3,"min":[-9,-9],"max":[9,9]}]}"#;
        let mut document = Document::open(text.as_bytes()).unwrap();
        let numbers = [0.5f32, 2.0, -9.0, 9.0, 0.25, 3.0];
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let buffers = Buffers::of(&document, |_| Some(bytes.clone())).unwrap();
        let new = document.gather(0, &[0, 2, 2], &buffers, "new").unwrap();
        let accessor = document.element("accessors", new).unwrap();
        assert_eq!(accessor["min"], json!([0.25, 2.0]));
        assert_eq!(accessor["max"], json!([0.5, 3.0]));
    }

    #[test]
    fn bounds_of_integers_are_those_that_are_stored() {
        // Of three shorts and a pad: quantised positions, for which bounds are required. Least and largest in turn, of each sign.
        let elements: [[i16; 4]; 3] = [[-32767, 300, 7, 9999], [0, -1, 8, 9999], [20, 32767, -9, 9999]];
        let bytes: Vec<u8> = elements.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let text = |kind: u32| {
            format!(
                r#"{{"buffers":[{{"uri":"b","byteLength":24}}],"bufferViews":[{{"buffer":0,"byteLength":24,"byteStride":8}}],
                "accessors":[{{"bufferView":0,"componentType":{kind},"type":"VEC3","count":3,"min":[0,0,0],"max":[1,1,1]}}]}}"#
            )
        };
        let bounds = |kind: u32, chosen: &[u32]| {
            let mut document = Document::open(text(kind).as_bytes()).unwrap();
            let buffers = Buffers::of(&document, |_| Some(bytes.clone())).unwrap();
            let new = document.gather(0, chosen, &buffers, "new").unwrap();
            let accessor = document.element("accessors", new).unwrap();
            [accessor["min"].to_string(), accessor["max"].to_string()]
        };
        assert_eq!(bounds(5122, &[2, 0]), ["[-32767,300,-9]", "[20,32767,7]"]);
        assert_eq!(bounds(5123, &[0, 1]), ["[0,300,7]", "[32769,65535,8]"]);
        // The first three bytes of an element: -32767 is 1, 128.
        assert_eq!(bounds(5120, &[0, 1]), ["[0,-128,-1]", "[1,0,44]"]);
        assert_eq!(bounds(5121, &[0, 1]), ["[0,0,44]", "[1,128,255]"]);
    }
}
