//! The body: where each record starts and ends.

use super::{
    PlyError,
    header::{Element, Encoding, Header, Kind, Scalar},
};
use std::ops::Range;

/// Vertices per block: what one thread reads or writes at a time.
pub(super) const BLOCK: u64 = 1 << 14;

/// Where the vertices lie.
#[derive(Clone, Debug)]
pub(super) struct VertexRange {
    /// From the first vertex to the end of the last; a line end behind it is not included.
    pub(super) bytes: Range<usize>,
    /// Start of every [`BLOCK`]th vertex.
    pub(super) blocks: Vec<usize>,
}

/// Walks the whole body, so that everything declared is known to be there, and finds the vertices.
pub(super) fn find_vertices(bytes: &[u8], header: &Header, vertex: usize) -> Result<VertexRange, PlyError> {
    let mut at = header.body;
    let mut vertices = VertexRange { bytes: 0..0, blocks: Vec::new() };
    for (index, element) in header.elements.iter().enumerate() {
        let walk = Walk { bytes, encoding: header.encoding, element };
        let wanted = (index == vertex).then_some(&mut vertices.blocks);
        let end = walk.end(at, wanted)?;
        if index == vertex {
            vertices.bytes = at..end;
        }
        at = end;
    }
    Ok(vertices)
}

/// The records of one element.
pub(super) struct Walk<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) encoding: Encoding,
    pub(super) element: &'a Element,
}

impl Walk<'_> {
    /// Where the element ends that starts at `start`; collects the start of every [`BLOCK`]th record.
    fn end(&self, start: usize, mut blocks: Option<&mut Vec<usize>>) -> Result<usize, PlyError> {
        self.check_count(start)?;
        let count = self.element.count;
        // Records of equal size need no walk.
        if let Some(size) = self.record_size() {
            let of = |index: u64| start + index as usize * size;
            if let Some(blocks) = blocks {
                blocks.extend((0..count).step_by(BLOCK as usize).map(of));
            }
            return Ok(of(count));
        }
        let mut at = start;
        for index in 0..count {
            if let Some(blocks) = blocks.as_mut().filter(|_| index.is_multiple_of(BLOCK)) {
                blocks.push(at);
            }
            at = self.record(at, index)?.end;
        }
        Ok(at)
    }

    /// Refuses counts that the rest of the file cannot hold, before any memory is taken on their word.
    fn check_count(&self, start: usize) -> Result<(), PlyError> {
        let rest = (self.bytes.len() - start) as u64;
        let properties = self.element.properties.iter();
        let least: u64 = match self.encoding {
            // A character and a separator each; the last separator may be missing.
            Encoding::Ascii => properties.count() as u64 * 2,
            _ => properties
                .map(|p| match p.kind {
                    Kind::Scalar(scalar) | Kind::List { count: scalar, .. } => scalar.bytes() as u64,
                })
                .sum(),
        };
        let slack = u64::from(self.encoding == Encoding::Ascii);
        match self.element.count.checked_mul(least) {
            Some(bytes) if bytes <= rest + slack => Ok(()),
            _ => Err(self.truncated((rest + slack) / least)),
        }
    }

    /// Size of every record, if it is the same for all.
    fn record_size(&self) -> Option<usize> {
        if self.encoding == Encoding::Ascii {
            return None;
        }
        let sizes = self.element.properties.iter().map(|p| match p.kind {
            Kind::Scalar(scalar) => Some(scalar.bytes()),
            Kind::List { .. } => None,
        });
        sizes.sum()
    }

    /// The record after `at`; a blank line between `at` and an ASCII record belongs to neither.
    pub(super) fn record(&self, at: usize, index: u64) -> Result<Range<usize>, PlyError> {
        match self.encoding {
            Encoding::Ascii => {
                let line = next_line(self.bytes, at).ok_or_else(|| self.truncated(index))?;
                let mut rest = &self.bytes[line.clone()];
                for property in &self.element.properties {
                    rest = self.skip_tokens(rest, property.kind, index)?;
                }
                if next_token(rest).is_some() {
                    return Err(self.bad(index, "the line has more values than are declared".into()));
                }
                Ok(line)
            }
            _ => {
                let mut end = at;
                for property in &self.element.properties {
                    end = self.value_end(end, property.kind, index)?;
                }
                Ok(at..end)
            }
        }
    }

    /// Where a binary value ends.
    pub(super) fn value_end(&self, at: usize, kind: Kind, index: u64) -> Result<usize, PlyError> {
        let end = match kind {
            Kind::Scalar(scalar) => at.checked_add(scalar.bytes()),
            Kind::List { count, item } => {
                let first = at + count.bytes();
                let number = self.bytes.get(at..first).ok_or_else(|| self.truncated(index))?;
                let count = self.list_length(decode(number, count, self.encoding), index)?;
                count.checked_mul(item.bytes()).and_then(|bytes| first.checked_add(bytes))
            }
        };
        end.filter(|&end| end <= self.bytes.len()).ok_or_else(|| self.truncated(index))
    }

    /// The rest of a line after the tokens of one property.
    pub(super) fn skip_tokens<'b>(
        &self,
        line: &'b [u8],
        kind: Kind,
        index: u64,
    ) -> Result<&'b [u8], PlyError> {
        let few = || self.bad(index, "the line has fewer values than are declared".into());
        let (token, mut rest) = next_token(line).ok_or_else(few)?;
        if let Kind::List { .. } = kind {
            let count = parse_number(token).ok_or_else(|| self.bad(index, "a list has no count".into()))?;
            for _ in 0..self.list_length(count, index)? {
                rest = next_token(rest).ok_or_else(few)?.1;
            }
        }
        Ok(rest)
    }

    fn list_length(&self, count: f64, index: u64) -> Result<usize, PlyError> {
        if count >= 0.0 && count <= f64::from(u32::MAX) && count.fract() == 0.0 {
            Ok(count as usize)
        } else {
            Err(self.bad(index, format!("a list has {count} entries")))
        }
    }

    fn truncated(&self, index: u64) -> PlyError {
        PlyError::Truncated { element: self.element.name.clone(), index, count: self.element.count }
    }

    pub(super) fn bad(&self, index: u64, problem: String) -> PlyError {
        PlyError::Record { element: self.element.name.clone(), index, problem }
    }
}

/// The next line that is not blank, from its first to its last visible character.
fn next_line(bytes: &[u8], at: usize) -> Option<Range<usize>> {
    let start = at + bytes.get(at..)?.iter().position(|b| !b.is_ascii_whitespace())?;
    let rest = &bytes[start..];
    let line = &rest[..rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len())];
    Some(start..start + line.trim_ascii_end().len())
}

/// The next run of visible characters and what follows it.
pub(super) fn next_token(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let line = line.trim_ascii_start();
    let length = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (length > 0).then(|| line.split_at(length))
}

/// A number as text; also `nan` and `inf`.
pub(super) fn parse_number(token: &[u8]) -> Option<f64> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// A binary number; `bytes` has the size of its type.
pub(super) fn decode(bytes: &[u8], scalar: Scalar, encoding: Encoding) -> f64 {
    let mut little = [0; 8];
    little[..bytes.len()].copy_from_slice(bytes);
    if encoding == Encoding::BigEndian {
        little[..bytes.len()].reverse();
    }
    let [a, b, c, d, ..] = little;
    match scalar {
        Scalar::I8 => f64::from(a as i8),
        Scalar::U8 => f64::from(a),
        Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
        Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
        Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Scalar::F64 => f64::from_le_bytes(little),
    }
}
