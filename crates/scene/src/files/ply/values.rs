//! The values of a PLY file, one after the other, in text or binary.

use super::header::{Encoding, Header, Property, Scalar};
use crate::files::error::{Fault, Place, shown};
use crate::files::text::{float, integer};

/// Reads values in file order.
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    encoding: Encoding,
    /// Which element and which of them is being read, for messages.
    pub element: (&'a str, u64),
}

impl<'a> Values<'a> {
    /// The values after a header.
    pub(super) fn new(bytes: &'a [u8], header: &Header) -> Self {
        let (at, line, encoding) = (header.body, header.lines + 1, header.encoding);
        Self { bytes, at, line, encoding, element: ("", 0) }
    }

    /// A broken rule in what is being read.
    pub(super) fn fault(&self, reason: impl Into<String>) -> Fault {
        let place = match self.encoding {
            Encoding::Text => Place::Line(self.line),
            _ => Place::Element(format!("{} {}", self.element.0, self.element.1)),
        };
        Fault::Malformed { place, reason: reason.into() }
    }

    fn truncated(&self) -> Fault {
        let (name, index) = self.element;
        Fault::byte(self.bytes.len(), format!("the file ends within {name} {index}"))
    }

    /// The next word of a text file, with the line it stands in noted.
    fn word(&mut self) -> Result<&'a [u8], Fault> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(|| self.truncated())?;
        // LF ends lines; files with CR alone count as one line.
        self.line += rest[..start].iter().filter(|b| **b == b'\n').count() as u64;
        let word = &rest[start..];
        let length = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        self.at += start + length;
        Ok(&word[..length])
    }

    fn raw<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let raw: [u8; N] = self
            .bytes
            .get(self.at..self.at + N)
            .and_then(|raw| raw.try_into().ok())
            .ok_or_else(|| self.truncated())?;
        self.at += N;
        Ok(if self.encoding == Encoding::BigEndian { reversed(raw) } else { raw })
    }

    /// The next value as the nearest `f32`.
    pub(super) fn float(&mut self, scalar: Scalar) -> Result<f32, Fault> {
        if self.encoding == Encoding::Text {
            let word = self.word()?;
            return float(word).ok_or_else(|| self.fault(format!("`{}` is not a number", shown(word))));
        }
        Ok(match scalar {
            Scalar::F32 => f32::from_le_bytes(self.raw()?),
            Scalar::F64 => f64::from_le_bytes(self.raw()?) as f32,
            _ => self.integer(scalar)? as f32,
        })
    }

    /// The next value as a whole number; one with a fraction is a fault.
    pub(super) fn integer(&mut self, scalar: Scalar) -> Result<i64, Fault> {
        if self.encoding == Encoding::Text {
            let word = self.word()?;
            return integer(word)
                .ok_or_else(|| self.fault(format!("`{}` is not a whole number", shown(word))));
        }
        Ok(match scalar {
            Scalar::I8 => i64::from(i8::from_le_bytes(self.raw()?)),
            Scalar::U8 => i64::from(u8::from_le_bytes(self.raw()?)),
            Scalar::I16 => i64::from(i16::from_le_bytes(self.raw()?)),
            Scalar::U16 => i64::from(u16::from_le_bytes(self.raw()?)),
            Scalar::I32 => i64::from(i32::from_le_bytes(self.raw()?)),
            Scalar::U32 => i64::from(u32::from_le_bytes(self.raw()?)),
            Scalar::F32 | Scalar::F64 => {
                let value = self.float(scalar)?;
                if value.fract() != 0.0 || value.abs() > 1e9 {
                    return Err(self.fault(format!("{value} is not a whole number")));
                }
                value as i64
            }
        })
    }

    /// The length of a list whose entries the rest of the file can hold.
    pub(super) fn length(&mut self, length: Scalar, entry: Scalar) -> Result<usize, Fault> {
        let written = self.integer(length)?;
        let least = if self.encoding == Encoding::Text { 2 } else { entry.bytes() };
        let left = (self.bytes.len() - self.at + 1) / least;
        match usize::try_from(written) {
            Ok(length) if length <= left => Ok(length),
            Ok(_) => Err(self.truncated()),
            Err(_) => Err(self.fault(format!("a list of length {written}"))),
        }
    }

    /// Passes over one property.
    pub(super) fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        let count = match property.length {
            Some(length) => self.length(length, property.scalar)?,
            None => 1,
        };
        if self.encoding == Encoding::Text {
            for _ in 0..count {
                self.word()?;
            }
            return Ok(());
        }
        let end = self.at + count * property.scalar.bytes();
        if end > self.bytes.len() {
            return Err(self.truncated());
        }
        self.at = end;
        Ok(())
    }
}

fn reversed<const N: usize>(mut bytes: [u8; N]) -> [u8; N] {
    bytes.reverse();
    bytes
}
