//! From and to the bytes of `.glb` and `.gltf` files.

use super::{Document, DocumentError, Kind};
use serde_json::{Map, Value};

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");
/// Of the file, and of each chunk.
const FILE_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

impl Document {
    /// Opens either kind of file, by its first bytes.
    ///
    /// # Errors
    /// Where it is cut short, or its JSON is none.
    pub fn open(bytes: &[u8]) -> Result<Self, DocumentError> {
        let mut document = Self {
            kind: Kind::Text,
            root: Map::new(),
            bin: Vec::new(),
            chunks: Vec::new(),
            buffer: None,
            added: Vec::new(),
        };
        if !bytes.starts_with(MAGIC) {
            document.root = parsed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))?;
            return Ok(document);
        }
        document.kind = Kind::Binary;
        let mut json = None;
        for (kind, chunk) in chunks(bytes)? {
            match kind {
                JSON if json.is_none() => json = Some(chunk),
                BIN if document.bin.is_empty() => document.bin = chunk.to_vec(),
                _ => document.chunks.push((kind, chunk.to_vec())),
            }
        }
        document.root = parsed(json.ok_or_else(|| container("it has no JSON chunk"))?)?;
        Ok(document)
    }

    /// The bytes of the file; a text document's added files are [`Document::files`].
    ///
    /// # Errors
    /// A binary document of 4 GiB or more.
    pub fn to_bytes(&self) -> Result<Vec<u8>, DocumentError> {
        let fault = |e: serde_json::Error| DocumentError::Json(e.to_string());
        if self.kind == Kind::Text {
            let mut text = serde_json::to_vec_pretty(&self.root).map_err(fault)?;
            text.push(b'\n');
            return Ok(text);
        }
        let json = serde_json::to_vec(&self.root).map_err(fault)?;
        let mut out = [&MAGIC[..], &VERSION.to_le_bytes(), &[0; 4]].concat();
        put(&mut out, JSON, &json, b' ');
        if !self.bin.is_empty() {
            put(&mut out, BIN, &self.bin, 0);
        }
        for (kind, chunk) in &self.chunks {
            put(&mut out, *kind, chunk, 0);
        }
        let length =
            u32::try_from(out.len()).map_err(|_| container("a .glb of 4 GiB cannot be; write a .gltf"))?;
        out[8..FILE_HEADER].copy_from_slice(&length.to_le_bytes());
        Ok(out)
    }
}

fn container(reason: &str) -> DocumentError {
    DocumentError::Container(reason.into())
}

fn parsed(json: &[u8]) -> Result<Map<String, Value>, DocumentError> {
    serde_json::from_slice(json).map_err(|e| DocumentError::Json(e.to_string()))
}

/// The chunks of a binary document: kind and bytes.
fn chunks(bytes: &[u8]) -> Result<Vec<(u32, &[u8])>, DocumentError> {
    let number = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|four| four.try_into().ok());
        four.map(u32::from_le_bytes).ok_or_else(|| container("it is cut short"))
    };
    let (version, length) = (number(4)?, number(8)? as usize);
    if version != VERSION {
        return Err(DocumentError::Container(format!("its version is {version}, not {VERSION}")));
    }
    if length > bytes.len() {
        let reason = format!("it is cut short: {} of {length} bytes", bytes.len());
        return Err(DocumentError::Container(reason));
    }
    let (mut found, mut at) = (Vec::new(), FILE_HEADER);
    while at + CHUNK_HEADER <= length {
        let (size, kind) = (number(at)? as usize, number(at + 4)?);
        let from = at + CHUNK_HEADER;
        let chunk =
            bytes.get(from..from.saturating_add(size)).ok_or_else(|| container("a chunk is cut short"))?;
        found.push((kind, chunk));
        at = from + size.next_multiple_of(4);
    }
    Ok(found)
}

/// A chunk, filled up to whole words.
fn put(out: &mut Vec<u8>, kind: u32, bytes: &[u8], filler: u8) {
    let size = bytes.len().next_multiple_of(4);
    out.extend((size as u32).to_le_bytes());
    out.extend(kind.to_le_bytes());
    out.extend(bytes);
    out.resize(out.len() + size - bytes.len(), filler);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn binary(json: &str, bin: &[u8], more: &[(u32, Vec<u8>)]) -> Vec<u8> {
        let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        put(&mut out, JSON, json.as_bytes(), b' ');
        put(&mut out, BIN, bin, 0);
        more.iter().for_each(|(kind, chunk)| put(&mut out, *kind, chunk, 0));
        let length = out.len() as u32;
        out[8..12].copy_from_slice(&length.to_le_bytes());
        out
    }

    #[test]
    fn values_order_and_unknown_things_stay_as_they_were() {
        let json = r#"{"zeta":0.01,"asset":{"version":"2.0"},"extras":{"b":1e-7,"a":-0.0,"c":18446744073709551615},"alpha":[1.0,0.30000000000000004]}"#;
        let file = binary(json, b"12345678", &[(7, b"abcd".to_vec())]);
        let document = Document::open(&file).unwrap();
        assert_eq!(document.to_bytes().unwrap(), file);
        let text = Document::open(json.as_bytes()).unwrap();
        let written = String::from_utf8(text.to_bytes().unwrap()).unwrap();
        assert_eq!(written.split_whitespace().collect::<String>(), json);
    }

    #[test]
    fn what_is_no_document_is_told() {
        let file = binary("{}", b"", &[]);
        assert!(matches!(Document::open(&file[..20]), Err(DocumentError::Container(_))));
        let mut old = file.clone();
        old[4] = 1;
        assert_eq!(Document::open(&old).unwrap_err().to_string(), "its version is 1, not 2");
        assert!(matches!(Document::open(b"{\"a\":"), Err(DocumentError::Json(_))));
        assert!(matches!(Document::open(b"[]"), Err(DocumentError::Json(_))));
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
            let _ = Document::open(&bytes);
            let _ = Document::open(&[b"glTF\x02\0\0\0", &bytes[..]].concat());
        }
    }
}
