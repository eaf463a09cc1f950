//! Files kept between runs: named arrays of numbers with a header, checked as a whole.
//!
//! | bytes | what |
//! | --- | --- |
//! | 8 | `conraykp` |
//! | 4 | version |
//! | 16 | fingerprint of what the content was computed from |
//! | 8 + n | kind, as text |
//! | 8 + n | header, as JSON |
//! | 8 | number of arrays |
//! | 8 + n, 8 + 4 n | each array: name, values of 32 bits |
//! | 16 | XXH3 checksum, 128 bits, of all bytes before it |
//!
//! All numbers are little-endian; every text and array follows its length in 64 bits. A length is believed only where the file
//! is long enough for it.

use crate::{Fingerprint, StudyError};
use conray::target::{TargetError, write_atomically};
use serde_json::Value;
use std::{collections::BTreeMap, fs, io::ErrorKind, path::Path};
use twox_hash::XxHash3_128;

const MAGIC: &[u8; 8] = b"conraykp";
/// Raised whenever the layout changes.
const VERSION: u32 = 1;
const CHECKSUM_BYTES: usize = 16;

/// What a file keeps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    /// Anything small.
    pub header: Value,
    /// Numbers by name; every bit is kept, that of NaN too.
    pub arrays: BTreeMap<String, Vec<f32>>,
}

impl Kept {
    /// Reads a file of that kind, computed from what has that fingerprint; `None` where there is no file.
    ///
    /// # Errors
    /// [`StudyError::Kept`] where the file cannot be read, is damaged or cut short, or is another one.
    pub fn read(path: &Path, kind: &str, fingerprint: Fingerprint) -> Result<Option<Self>, StudyError> {
        match fs::read(path) {
            Ok(bytes) => decode(&bytes, kind, fingerprint).map(Some).map_err(|what| damaged(path, &what)),
            // Nor is there one where a folder of the path is a file; writing there will say so.
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
            Err(e) => Err(damaged(path, &format!("it cannot be read: {e}"))),
        }
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`StudyError::Output`] names the file and what the system says.
    pub fn write(&self, path: &Path, kind: &str, fingerprint: Fingerprint) -> Result<(), StudyError> {
        let bytes = encode(self, kind, fingerprint);
        write_atomically(path, |w| w.write_all(&bytes)).map_err(|e| output(path, e))
    }
}

/// What is wrong with a kept file, and what to do.
pub(crate) fn damaged(path: &Path, what: &str) -> StudyError {
    StudyError::Kept { path: path.into(), problem: format!("{what}; delete it to have it computed anew") }
}

/// A file or folder that cannot be written.
pub(crate) fn output(path: &Path, error: TargetError) -> StudyError {
    match error {
        TargetError::Output { path, source } => StudyError::Output { path, reason: source.to_string() },
        other => StudyError::Output { path: path.into(), reason: other.to_string() },
    }
}

fn encode(kept: &Kept, kind: &str, fingerprint: Fingerprint) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    let text = |bytes: &mut Vec<u8>, text: &str| {
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(text.as_bytes());
    };
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(fingerprint.to_le_bytes());
    text(&mut bytes, kind);
    text(&mut bytes, &kept.header.to_string());
    bytes.extend((kept.arrays.len() as u64).to_le_bytes());
    for (name, values) in &kept.arrays {
        text(&mut bytes, name);
        bytes.extend((values.len() as u64).to_le_bytes());
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }
    let checksum = XxHash3_128::oneshot(&bytes);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// The content, or what is wrong with it.
fn decode(bytes: &[u8], kind: &str, fingerprint: Fingerprint) -> Result<Kept, String> {
    let mut all = Cursor(bytes);
    if all.array::<8>()? != *MAGIC {
        return Err("it is no file of this program".into());
    }
    // The version goes first: another one may keep its checksum elsewhere.
    let version = u32::from_le_bytes(all.array()?);
    if version != VERSION {
        return Err(format!("it has version {version} where this program reads version {VERSION}"));
    }
    let end = bytes.len().checked_sub(CHECKSUM_BYTES).ok_or(CUT_SHORT)?;
    let (content, checksum) = bytes.split_at(end);
    if XxHash3_128::oneshot(content).to_le_bytes() != checksum {
        return Err("its checksum does not match: it is damaged or cut short".into());
    }
    let mut rest = Cursor(content);
    rest.take(MAGIC.len() + size_of::<u32>())?;
    let found_fingerprint = Fingerprint::from_le_bytes(rest.array()?);
    let found_kind = rest.text()?;
    if found_kind != kind {
        return Err(format!("it keeps {found_kind} where {kind} is expected"));
    }
    if found_fingerprint != fingerprint {
        return Err(format!(
            "it was computed from other things: {found_fingerprint} instead of {fingerprint}"
        ));
    }
    let header = serde_json::from_str(rest.text()?).map_err(|e| format!("its header is no JSON: {e}"))?;
    let count = rest.length()?;
    let mut arrays = BTreeMap::new();
    for _ in 0..count {
        let name = rest.text()?.to_owned();
        let bytes = rest.length()?.checked_mul(size_of::<f32>()).ok_or(CUT_SHORT)?;
        let values = rest.take(bytes)?.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        arrays.insert(name, values);
    }
    if rest.0.is_empty() { Ok(Kept { header, arrays }) } else { Err("it goes on after its end".into()) }
}

const CUT_SHORT: &str = "it is cut short";

/// What is left to read.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CUT_SHORT)?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (taken, rest) = self.0.split_first_chunk().ok_or(CUT_SHORT)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn length(&mut self) -> Result<usize, String> {
        usize::try_from(u64::from_le_bytes(self.array()?)).map_err(|_| CUT_SHORT.into())
    }

    fn text(&mut self) -> Result<&'a str, String> {
        let length = self.length()?;
        std::str::from_utf8(self.take(length)?).map_err(|_| "it holds text that is none".into())
    }
}

#[cfg(test)]
mod tests;
