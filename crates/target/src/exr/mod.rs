//! OpenEXR scan-line images of 32-bit floats: every layer, lossless, with the settings in the header.
//!
//! Written here rather than by a library, because the same layers must give the same bytes: the `exr` crate keeps custom
//! attributes in a hash map and so writes them in another order in every run. It reads our files in the tests.
//!
//! Format: "Technical Introduction to OpenEXR" and "OpenEXR File Layout", openexr.com.

mod block;
mod read;
mod write;

pub use read::{ExrImage, decode_exr_channels, read_exr_channels};
pub use write::{encode_exr, write_exr};

/// First four bytes of every file.
const MAGIC: [u8; 4] = 20_000_630u32.to_le_bytes();
/// Version field: 2, single part, scan lines.
const VERSION: u32 = 2;
/// Flag of the version field: names of up to 255 bytes instead of 31.
const LONG_NAMES: u32 = 0x400;
/// Pixel type of a channel: 32-bit float.
const FLOAT: i32 = 2;
/// Value of the `compression` attribute: deflate over blocks of 16 rows.
const ZIP: u8 = 3;
/// Rows in a block of that compression.
const ZIP_ROWS: u32 = 16;

#[cfg(test)]
mod tests;
