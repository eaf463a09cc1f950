//! ZIP compression of a block of pixels.
//!
//! The bytes are split into even and odd positions, which puts like bytes of the floats together, then replaced by
//! their differences plus 128, then deflated ("OpenEXR File Layout": ZIP; Kainz, Bogart, "Technical Introduction to
//! OpenEXR"). A block that would not shrink is stored as it is.

use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use std::io::{self, Read, Write};

/// Deflate level: OpenEXR's own default; higher ones take several times as long for a few per cent.
const LEVEL: u32 = 4;

/// Compresses one block.
pub(super) fn compress(raw: Vec<u8>) -> io::Result<Vec<u8>> {
    let half = raw.len().div_ceil(2);
    let mut split = vec![0u8; raw.len()];
    for (i, pair) in raw.chunks(2).enumerate() {
        split[i] = pair[0];
        if let Some(&odd) = pair.get(1) {
            split[half + i] = odd;
        }
    }
    for i in (1..split.len()).rev() {
        split[i] = split[i].wrapping_sub(split[i - 1]).wrapping_add(128);
    }
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(raw.len() / 2), Compression::new(LEVEL));
    encoder.write_all(&split)?;
    let packed = encoder.finish()?;
    Ok(if packed.len() < raw.len() { packed } else { raw })
}

/// The inverse of [`compress`] for a block of `raw_bytes`; `None` if the data do not give exactly that many.
pub(super) fn decompress(packed: &[u8], raw_bytes: usize) -> Option<Vec<u8>> {
    if packed.len() == raw_bytes {
        return Some(packed.to_vec());
    }
    let mut split = Vec::new();
    ZlibDecoder::new(packed).take(raw_bytes as u64 + 1).read_to_end(&mut split).ok()?;
    if split.len() != raw_bytes {
        return None;
    }
    for i in 1..split.len() {
        split[i] = split[i].wrapping_add(split[i - 1]).wrapping_sub(128);
    }
    let (even, odd) = split.split_at(raw_bytes.div_ceil(2));
    let mut raw = Vec::with_capacity(raw_bytes);
    for (i, &byte) in even.iter().enumerate() {
        raw.push(byte);
        raw.extend(odd.get(i));
    }
    Some(raw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn blocks_survive(raw in prop::collection::vec(0u8..4, 0..300), noise in prop::collection::vec(any::<u8>(), 0..40)) {
            for raw in [raw, noise] {
                let packed = compress(raw.clone()).unwrap();
                prop_assert!(packed.len() <= raw.len());
                prop_assert_eq!(decompress(&packed, raw.len()), Some(raw.clone()));
                prop_assert_eq!(decompress(&packed, raw.len() + 1), None);
            }
        }
    }
}
