//! Buffer views compressed by `EXT_meshopt_compression`, where there is no decoder: it is C++, which is not built for web pages.

use super::schema::Meshopt;

/// Refuses every view.
pub(super) fn decode(_: &Meshopt, _: &[u8]) -> Result<Vec<u8>, String> {
    Err("meshopt compression is not read in a web page; the desktop program reads it".into())
}
