//! Equal positions found by their bits.

use conray_core::Vec3;
use std::collections::HashMap;

/// Bits by which two positions are equal exactly where their coordinates are: both zeros count as one.
#[inline]
pub(crate) fn key(p: Vec3) -> [u32; 3] {
    // Adding zero turns -0 into +0 and changes nothing else.
    [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f32::to_bits)
}

/// For each position the index of the first one equal to it.
pub(super) fn first_equal(positions: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    positions.iter().enumerate().map(|(i, &p)| *first.entry(key(p)).or_insert(i as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_equal_positions_are_welded() {
        let one_up = Vec3::new(1.0f32.next_up(), 0.0, 0.0);
        let positions = [Vec3::X, Vec3::ZERO, one_up, Vec3::new(1.0, -0.0, 0.0), Vec3::splat(-0.0)];
        assert_eq!(first_equal(&positions), [0, 1, 2, 0, 1]);
    }
}
