//! Reading whole files.

use crate::TargetError;
use std::{fs, io, path::Path};

/// Largest file that is read: 32 GiB.
const MAX_FILE_BYTES: u64 = 32 << 30;

/// The bytes of a regular file. Devices and pipes are refused: they may never end.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, TargetError> {
    let unreadable = |source| TargetError::Unreadable { path: path.into(), source };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(unreadable(io::ErrorKind::IsADirectory.into()));
    }
    if !metadata.is_file() {
        return Err(unreadable(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")));
    }
    if metadata.len() > MAX_FILE_BYTES {
        let (count, limit) = (metadata.len(), MAX_FILE_BYTES);
        return Err(TargetError::Limits { path: path.into(), what: "bytes", count, limit });
    }
    fs::read(path).map_err(unreadable)
}

/// The most that deflate can expand a byte: 258 bytes for two bits (RFC 1951: one bit of length, one of distance).
pub(crate) const MAX_DEFLATE_RATIO: u64 = 1032;
