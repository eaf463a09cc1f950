//! Morton codes: the bits of three coordinates interleaved, x lowest.

use glam::UVec3;

/// Code of a cell; coordinates below 2^10.
#[inline]
pub(crate) fn encode(cell: UVec3) -> u32 {
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

/// Cell of a code; the inverse of [`encode`].
#[inline]
pub(crate) fn decode(code: u32) -> UVec3 {
    UVec3::new(gather(code), gather(code >> 1), gather(code >> 2))
}

/// Moves bit i to bit 3 i.
#[inline]
fn spread(x: u32) -> u32 {
    let mut x = x & 0x3ff;
    x = (x | x << 16) & 0x0300_00ff;
    x = (x | x << 8) & 0x0300_f00f;
    x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Moves bit 3 i to bit i.
#[inline]
fn gather(x: u32) -> u32 {
    let mut x = x & 0x0924_9249;
    x = (x | x >> 2) & 0x030c_30c3;
    x = (x | x >> 4) & 0x0300_f00f;
    x = (x | x >> 8) & 0x0300_00ff;
    (x | x >> 16) & 0x3ff
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn codes_invert_and_order_by_octant(x in 0u32..1024, y in 0u32..1024, z in 0u32..1024) {
            let cell = UVec3::new(x, y, z);
            prop_assert_eq!(decode(encode(cell)), cell);
            prop_assert_eq!(encode(cell) >> 3, encode(cell / 2));
        }
    }
}
