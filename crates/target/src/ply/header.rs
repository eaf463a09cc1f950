//! The header: encoding, elements and their properties.

use super::PlyError;
use std::ops::Range;

/// Longest header that is read.
const MAX_HEADER_BYTES: usize = 1 << 20;

/// Most elements of a file and properties of an element.
const MAX_PARTS: usize = 1024;

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Size in a binary body.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// What a property holds in each record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

/// One property of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Its line in the header, line end included.
    pub(super) line: Range<usize>,
}

/// A kind of record.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// What the header says.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Where the body starts.
    pub(super) body: usize,
    /// How lines end.
    pub(super) line_end: &'static str,
}

impl Header {
    /// Reads the header at the start of a file. Every element has properties, with distinct names.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, PlyError> {
        let (first, mut at) = next_line(bytes, 0).ok_or(PlyError::NotPly)?;
        if first != "ply" {
            return Err(PlyError::NotPly);
        }
        let line_end = if bytes[..at].ends_with(b"\r\n") { "\r\n" } else { "\n" };
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        for number in 2.. {
            let (line, end) = next_line(bytes, at).ok_or(PlyError::HeaderEnd)?;
            let fail = |problem: String| PlyError::Header { line: number, problem };
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words.as_slice() {
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, _version] => encoding = Some(encoding_of(name).map_err(fail)?),
                ["element", name, count] => {
                    let element = new_element(&elements, name, count).map_err(fail)?;
                    elements.push(element);
                }
                ["property", rest @ ..] => {
                    let element =
                        elements.last_mut().ok_or_else(|| fail("it precedes all elements".into()))?;
                    let property = new_property(element, rest, at..end).map_err(fail)?;
                    element.properties.push(property);
                }
                ["end_header"] => {
                    let encoding = encoding.ok_or_else(|| fail("there is no format line".into()))?;
                    if let Some(empty) = elements.iter().find(|e| e.properties.is_empty()) {
                        return Err(fail(format!("element {} has no properties", empty.name)));
                    }
                    return Ok(Self { encoding, elements, body: end, line_end });
                }
                _ => return Err(fail(format!("{line:?} is not understood"))),
            }
            at = end;
        }
        Err(PlyError::HeaderEnd)
    }
}

/// The line that starts at `at`, without its end, and where the next one starts.
fn next_line(bytes: &[u8], at: usize) -> Option<(String, usize)> {
    let rest = bytes.get(at..bytes.len().min(MAX_HEADER_BYTES))?;
    let length = rest.iter().position(|&b| b == b'\n')?;
    let line = rest[..length].strip_suffix(b"\r").unwrap_or(&rest[..length]);
    Some((String::from_utf8_lossy(line).into_owned(), at + length + 1))
}

fn encoding_of(name: &str) -> Result<Encoding, String> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(format!("the format {name} is unknown")),
    }
}

fn new_element(earlier: &[Element], name: &str, count: &str) -> Result<Element, String> {
    let count = count.parse().map_err(|_| format!("{count} is no count"))?;
    if earlier.iter().any(|e| e.name == name) {
        return Err(format!("there are two elements {name}"));
    }
    if earlier.len() == MAX_PARTS {
        return Err(format!("there are more than {MAX_PARTS} elements"));
    }
    Ok(Element { name: name.into(), count, properties: Vec::new() })
}

fn new_property(element: &Element, words: &[&str], line: Range<usize>) -> Result<Property, String> {
    let scalar = |name: &str| Scalar::from_name(name).ok_or_else(|| format!("the type {name} is unknown"));
    let (kind, name) = match words {
        ["list", count, item, name] => {
            let (count, item) = (scalar(count)?, scalar(item)?);
            if matches!(count, Scalar::F32 | Scalar::F64) {
                return Err("a list is counted in whole numbers".into());
            }
            (Kind::List { count, item }, name)
        }
        [kind, name] => (Kind::Scalar(scalar(kind)?), name),
        _ => return Err("a property is a type and a name".into()),
    };
    if element.properties.iter().any(|p| p.name == *name) {
        return Err(format!("element {} has two properties {name}", element.name));
    }
    if element.properties.len() == MAX_PARTS {
        return Err(format!("element {} has more than {MAX_PARTS} properties", element.name));
    }
    Ok(Property { name: (*name).into(), kind, line })
}
