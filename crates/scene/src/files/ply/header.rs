//! The header of a PLY file: which elements follow, of which properties, in which encoding.
//!
//! After Turk, "The PLY Polygon File Format", 1994.

use crate::files::error::{Fault, shown};
use crate::files::text::{integer, word};

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// Type of a value.
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
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one value in a binary file.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// One property of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub name: String,
    /// Type of the length in front of a list; `None` for a single value.
    pub length: Option<Scalar>,
    /// Type of the value or of the list's entries.
    pub scalar: Scalar,
}

/// A kind of thing and how many of them follow.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// What the file declares.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub encoding: Encoding,
    /// In the order in which they follow.
    pub elements: Vec<Element>,
    /// Byte at which the values start.
    pub body: usize,
    /// Lines of the header.
    pub lines: u64,
}

impl Element {
    /// Fewest bytes that one of these takes in the file: an empty list counts its length only.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let least = |p: &Property| match encoding {
            // A digit and what parts it from the next.
            Encoding::Text => 2,
            _ => p.length.unwrap_or(p.scalar).bytes() as u64,
        };
        self.properties.iter().map(least).sum()
    }

    /// Place of the property of one of these names.
    pub(super) fn property(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|p| names.contains(&p.name.as_str()))
    }
}

/// Reads the header and checks every count against the bytes that are there.
pub(super) fn parse_header(bytes: &[u8]) -> Result<Header, Fault> {
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    let (mut at, mut line) = (0, 0u64);
    loop {
        let Some(content) = next_line(bytes, &mut at) else {
            return Err(Fault::line(line.max(1), "the file ends within the header"));
        };
        line += 1;
        let mut rest = content;
        match word(&mut rest) {
            b"ply" if line == 1 => {}
            _ if line == 1 => return Err(Fault::line(1, "the file does not start with `ply`")),
            b"format" => encoding = Some(parse_encoding(rest, line)?),
            b"element" => elements.push(parse_element(rest, line)?),
            b"property" => match elements.last_mut() {
                Some(element) => element.properties.push(parse_property(rest, line)?),
                None => return Err(Fault::line(line, "a property before any element")),
            },
            b"end_header" => break,
            b"" | b"comment" | b"obj_info" => {}
            other => {
                return Err(Fault::line(line, format!("`{}` is not a word of a PLY header", shown(other))));
            }
        }
    }
    let encoding = encoding.ok_or_else(|| Fault::line(line, "the header has no `format`"))?;
    let header = Header { encoding, elements, body: at, lines: line };
    check_counts(&header, (bytes.len() - at) as u64)?;
    Ok(header)
}

/// Up to the next LF, CR LF or CR.
fn next_line<'a>(bytes: &'a [u8], at: &mut usize) -> Option<&'a [u8]> {
    let rest = &bytes[*at..];
    let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r'))?;
    *at += length + if rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
    Some(&rest[..length])
}

fn parse_encoding(mut rest: &[u8], line: u64) -> Result<Encoding, Fault> {
    match word(&mut rest) {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        other => Err(Fault::line(line, format!("unknown PLY format `{}`", shown(other)))),
    }
}

fn parse_element(mut rest: &[u8], line: u64) -> Result<Element, Fault> {
    let name = shown(word(&mut rest));
    let written = word(&mut rest);
    match integer(written).and_then(|n| u64::try_from(n).ok()) {
        Some(count) => Ok(Element { name, count, properties: Vec::new() }),
        None => Err(Fault::line(line, format!("`{}` is not a count", shown(written)))),
    }
}

fn parse_property(mut rest: &[u8], line: u64) -> Result<Property, Fault> {
    let scalar = |name: &[u8]| {
        Scalar::named(name).ok_or_else(|| Fault::line(line, format!("unknown PLY type `{}`", shown(name))))
    };
    let kind = word(&mut rest);
    let (length, scalar) = if kind == b"list" {
        let length = scalar(word(&mut rest))?;
        if matches!(length, Scalar::F32 | Scalar::F64) {
            return Err(Fault::line(line, "the length of a list must be a whole number"));
        }
        (Some(length), scalar(word(&mut rest))?)
    } else {
        (None, scalar(kind)?)
    };
    match word(&mut rest) {
        b"" => Err(Fault::line(line, "a property without a name")),
        name => Ok(Property { name: String::from_utf8_lossy(name).into_owned(), length, scalar }),
    }
}

fn check_counts(header: &Header, mut left: u64) -> Result<(), Fault> {
    // The last value of a text needs nothing after it.
    left += u64::from(header.encoding == Encoding::Text);
    for element in &header.elements {
        let least = element.count.saturating_mul(element.least_bytes(header.encoding));
        if least > left {
            let (name, count) = (&element.name, element.count);
            let reason = format!("{count} are declared, which the rest of the file is too short for");
            return Err(Fault::element(format!("element `{name}`"), reason));
        }
        left -= least;
    }
    Ok(())
}
