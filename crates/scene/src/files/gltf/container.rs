//! From the bytes of a `.gltf` or `.glb` file to its JSON and its binary chunk.

use super::schema::{Root, Stamp};
use crate::files::error::{Fault, Place, shown};

const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// A document and its binary chunk.
pub(super) struct Container<'a> {
    pub root: Root,
    pub bin: Option<&'a [u8]>,
}

/// Opens either kind of file, by its first bytes.
pub(super) fn open(bytes: &[u8]) -> Result<Container<'_>, Fault> {
    if bytes.starts_with(b"glTF") {
        let (json, bin) = chunks(bytes)?;
        Ok(Container { root: parse(json, true)?, bin })
    } else {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Ok(Container { root: parse(text, false)?, bin: None })
    }
}

fn parse(json: &[u8], is_chunk: bool) -> Result<Root, Fault> {
    let fault = |e: serde_json::Error| {
        // serde_json ends its messages with the place, which the fault says itself.
        let text = e.to_string();
        let reason = text.split(" at line ").next().unwrap_or(&text).to_string();
        let place = match is_chunk {
            true => Place::Element(format!("JSON chunk, line {} column {}", e.line(), e.column())),
            false => Place::Line(e.line() as u64),
        };
        Fault::Malformed { place, reason }
    };
    // The version first: version 1 has the same keys with other types.
    let version = serde_json::from_slice::<Stamp>(json).map_err(fault)?.asset.version;
    if !version.starts_with("2.") {
        return Err(Fault::unsupported(format!("glTF version {}", shown(version.as_bytes()))));
    }
    serde_json::from_slice(json).map_err(fault)
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

/// The JSON chunk and the binary one: "glTF 2.0 Specification", section 4.4.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let truncated = || Fault::byte(bytes.len(), "the file ends within the GLB header");
    let version = u32_at(bytes, 4).ok_or_else(truncated)?;
    let length = u32_at(bytes, 8).ok_or_else(truncated)? as usize;
    if version != 2 {
        return Err(Fault::unsupported(format!("GLB version {version}")));
    }
    if length > bytes.len() {
        let reason = format!("the file ends here, but its header declares {length} bytes");
        return Err(Fault::byte(bytes.len(), reason));
    }
    let (mut at, mut json, mut bin) = (12, None, None);
    while at < length {
        let ends = |what: &str| Fault::byte(at, format!("the file ends within {what}"));
        let size = u32_at(&bytes[..length], at).ok_or_else(|| ends("a chunk's header"))? as usize;
        let kind = u32_at(&bytes[..length], at + 4).ok_or_else(|| ends("a chunk's header"))?;
        let body =
            bytes[..length].get(at + 8..).and_then(|rest| rest.get(..size)).ok_or_else(|| ends("a chunk"))?;
        match kind {
            JSON if json.is_none() => json = Some(body),
            BIN if bin.is_none() => bin = Some(body),
            _ => {}
        }
        // Sizes are multiples of four; files that forgot the padding of the last chunk are common.
        at += 8 + size;
    }
    Ok((json.ok_or_else(|| Fault::byte(12, "there is no JSON chunk"))?, bin))
}
