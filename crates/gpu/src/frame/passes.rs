//! Which places of a picture get rays, and which of their sequences.

use std::ops::Range;

/// Pixels on each side of a block of the lattice.
pub(super) const BLOCK: u32 = 16;
/// Rays of a unit.
pub(super) const UNIT: u32 = 16;
/// Places of a block.
const RANKS: u32 = BLOCK * BLOCK;

/// One unit of rays at some places of each block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pass {
    /// Which of each place's sequence.
    pub(super) unit: u32,
    /// The places, as `spread` ranks them.
    pub(super) ranks: Range<u32>,
}

impl Pass {
    /// The first one, of about so many rays a pixel: one place in 256 at least, all at most.
    pub(super) fn first(rays_per_pixel: f32) -> Self {
        Self { unit: 0, ranks: 0..ranks_of(rays_per_pixel) }
    }

    /// The next one, of about so many rays a pixel more: a place has its first unit before another has its second.
    pub(super) fn next(&self, rays_per_pixel: f32) -> Self {
        let end = self.ranks.end;
        let (unit, first) = if end < RANKS { (self.unit, end) } else { (self.unit + 1, 0) };
        Self { unit, ranks: first..(first + ranks_of(rays_per_pixel)).min(RANKS) }
    }

    /// Rays of a picture of that size, of places that see something at most.
    pub(super) fn units(&self, [width, height]: [u32; 2]) -> u32 {
        width.div_ceil(BLOCK) * height.div_ceil(BLOCK) * self.ranks.len() as u32
    }
}

/// Places of a block that have rays where there are so many a pixel.
fn ranks_of(rays_per_pixel: f32) -> u32 {
    let part = (rays_per_pixel / UNIT as f32).max(1.0 / RANKS as f32);
    (0..RANKS).filter(|&rank| (rank as f32 + 0.5) / (RANKS as f32) < part).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn so_many_places_of_a_block_have_rays() {
        let ranks = |rays| Pass::first(rays).ranks.end;
        assert_eq!([0.0, 1.0 / 16.0, 1.0, 4.0, 16.0, 99.0].map(ranks), [1, 1, 16, 64, 256, 256]);
    }

    #[test]
    fn passes_leave_no_place_out_and_take_none_twice() {
        let mut pass = Pass::first(0.7);
        let mut had = vec![0u32; RANKS as usize];
        for more in [0.0, 1.0, 3.0, 0.3, 99.0, 16.0, 5.0, 16.0, 16.0] {
            pass.ranks.clone().for_each(|rank| {
                assert_eq!(had[rank as usize], pass.unit);
                had[rank as usize] += 1;
            });
            pass = pass.next(more);
        }
        assert!(had.iter().all(|&units| units.abs_diff(had[0]) < 2 && units > 1), "{had:?}");
    }
}
