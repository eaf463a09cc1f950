//! The same file with the estimates added to its vertices.

use super::{
    PointValues, PointsTarget,
    body::{BLOCK, Walk, next_token},
    header::{Encoding, Kind, Property},
};
use crate::{Target, TargetError, write_atomically};
use conray_core::Estimate;
use rayon::prelude::*;
use std::{
    io::{self, Write},
    ops::Range,
    path::Path,
};

/// What is added to each vertex, in this order.
const ADDED: [&str; 3] = ["visibility", "error", "rays"];
/// Blocks that are held in memory at once while writing.
const BLOCKS_AT_ONCE: usize = 64;

impl PointsTarget {
    /// Writes the file again, in the same encoding and with everything that it held, its vertices having the float
    /// properties `visibility`, `error` and `rays` in addition.
    ///
    /// Properties that had these names are replaced. Vertices without an estimate have a NaN visibility and an infinite
    /// error. The file, which may be the one that was read, appears whole or not at all ([`write_atomically`]).
    pub fn write(&self, path: impl AsRef<Path>, estimates: &[Estimate]) -> Result<(), TargetError> {
        let values = self.resolve(estimates)?;
        write_atomically(path, |w| self.encode(w, &values))
    }

    fn encode(&self, writer: &mut dyn Write, values: &PointValues) -> io::Result<()> {
        self.encode_header(writer)?;
        writer.write_all(&self.bytes[self.header.body..self.vertices.bytes.start])?;
        let numbered: Vec<(usize, usize)> = self.vertices.blocks.iter().copied().enumerate().collect();
        for group in numbered.chunks(BLOCKS_AT_ONCE) {
            let encoded: Vec<Vec<u8>> = group
                .par_iter()
                .map(|&(i, start)| self.encode_block(i, start, values))
                .collect::<Result<_, _>>()?;
            for bytes in encoded {
                writer.write_all(&bytes)?;
            }
        }
        writer.write_all(&self.bytes[self.vertices.bytes.end..])
    }

    /// The header without the replaced properties and with the new ones behind the last of the vertices' own.
    fn encode_header(&self, writer: &mut dyn Write) -> io::Result<()> {
        let properties = &self.element().properties;
        let mut at = 0;
        for property in properties {
            writer.write_all(&self.bytes[at..property.line.start])?;
            if !is_replaced(property) {
                writer.write_all(&self.bytes[property.line.clone()])?;
            }
            at = property.line.end;
        }
        for name in ADDED {
            write!(writer, "property float {name}{}", self.header.line_end)?;
        }
        writer.write_all(&self.bytes[at..self.header.body])
    }

    fn encode_block(&self, block: usize, start: usize, values: &PointValues) -> io::Result<Vec<u8>> {
        let walk = Walk { bytes: &self.bytes, encoding: self.header.encoding, element: self.element() };
        let end = self.vertices.blocks.get(block + 1).copied().unwrap_or(self.vertices.bytes.end);
        let mut out = Vec::with_capacity((end - start) * 3 / 2);
        let mut at = start;
        let first = block as u64 * BLOCK;
        for vertex in first..(first + BLOCK).min(self.vertex_count()) {
            // Every record was walked when the file was read.
            let record = walk.record(at, vertex).map_err(io::Error::other)?;
            out.extend(&self.bytes[at..record.start]);
            at = record.end;
            let v = vertex as usize;
            let added = [values.visibility[v], values.error[v], values.rays[v]];
            match walk.encoding {
                Encoding::Ascii => ascii_vertex(&mut out, &walk, record, vertex, added)?,
                encoding => binary_vertex(&mut out, &walk, record, vertex, added, encoding)?,
            }
        }
        Ok(out)
    }
}

fn is_replaced(property: &Property) -> bool {
    ADDED.contains(&property.name.as_str())
}

fn ascii_vertex(
    out: &mut Vec<u8>,
    walk: &Walk,
    record: Range<usize>,
    vertex: u64,
    added: [f32; 3],
) -> io::Result<()> {
    let mut rest = &walk.bytes[record];
    for property in &walk.element.properties {
        let after = walk.skip_tokens(rest, property.kind, vertex).map_err(io::Error::other)?;
        if !is_replaced(property) {
            let tokens = rest[..rest.len() - after.len()].trim_ascii();
            out.extend(tokens);
            out.push(b' ');
        }
        rest = after;
    }
    debug_assert!(next_token(rest).is_none());
    // The shortest decimal that gives the same float; as C's strtod reads them: nan, inf.
    let [visibility, error, rays] = added.map(|v| if v.is_nan() { "nan".into() } else { v.to_string() });
    write!(out, "{visibility} {error} {rays}")
}

fn binary_vertex(
    out: &mut Vec<u8>,
    walk: &Walk,
    record: Range<usize>,
    vertex: u64,
    added: [f32; 3],
    encoding: Encoding,
) -> io::Result<()> {
    let mut at = record.start;
    for property in &walk.element.properties {
        let end = match property.kind {
            Kind::Scalar(scalar) => at + scalar.bytes(),
            list => walk.value_end(at, list, vertex).map_err(io::Error::other)?,
        };
        if !is_replaced(property) {
            out.extend(&walk.bytes[at..end]);
        }
        at = end;
    }
    for value in added {
        out.extend(if encoding == Encoding::BigEndian { value.to_be_bytes() } else { value.to_le_bytes() });
    }
    Ok(())
}
