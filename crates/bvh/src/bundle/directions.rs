//! The directions of a bundle, axis by axis.

use super::BUNDLE_RAYS;
use crate::lanes::{Lanes, WIDTH};
use conray_core::Vec3;
use fearless_simd::{Simd, f32x16, prelude::*};

/// Groups of sixteen rays in a bundle.
pub(super) const GROUPS: usize = BUNDLE_RAYS / WIDTH;

/// Directions of up to [`BUNDLE_RAYS`] rays, stored axis by axis so that sixteen are read at once.
///
/// Neighbours should look about the same way: sixteen in a row are tested together where many rays are alive.
#[derive(Clone, Debug)]
pub struct Directions {
    /// By group, then axis.
    pub(super) groups: [[Lanes; 3]; GROUPS],
    count: usize,
}

impl Default for Directions {
    fn default() -> Self {
        Self::new()
    }
}

impl Directions {
    /// None yet.
    pub fn new() -> Self {
        // Lanes without a ray hold a direction too: a number that is none would be tested and dropped sixteen times.
        Self { groups: [[Lanes::ZERO, Lanes::ZERO, Lanes([1.0; WIDTH])]; GROUPS], count: 0 }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds one, a unit vector.
    ///
    /// # Panics
    /// Where there are [`BUNDLE_RAYS`] already.
    #[inline]
    pub fn push(&mut self, direction: Vec3) {
        assert!(self.count < BUNDLE_RAYS, "a bundle holds {BUNDLE_RAYS} rays");
        let (group, lane) = (self.count / WIDTH, self.count % WIDTH);
        let [x, y, z] = &mut self.groups[group];
        (x.0[lane], y.0[lane], z.0[lane]) = (direction.x, direction.y, direction.z);
        self.count += 1;
    }

    /// Adds sixteen, axis by axis; of them only the first `count`, above 0, are taken.
    ///
    /// # Panics
    /// Where the number so far is no multiple of sixteen, or there is no room.
    #[inline(always)]
    pub fn push_group<S: Simd>(&mut self, axes: &[f32x16<S>; 3], count: usize) {
        assert!(self.count.is_multiple_of(WIDTH) && (1..=WIDTH).contains(&count));
        let group = &mut self.groups[self.count / WIDTH];
        for axis in 0..3 {
            axes[axis].store_slice(&mut group[axis].0);
        }
        self.count += count;
    }

    /// Sixteen of them, axis by axis; those past the last have any direction.
    #[inline(always)]
    pub fn group<S: Simd>(&self, simd: S, group: usize) -> [f32x16<S>; 3] {
        let [x, y, z] = &self.groups[group];
        [f32x16::from_slice(simd, &x.0), f32x16::from_slice(simd, &y.0), f32x16::from_slice(simd, &z.0)]
    }

    /// One of them.
    ///
    /// # Panics
    /// Where there is none of that number.
    #[inline]
    pub fn get(&self, index: usize) -> Vec3 {
        assert!(index < self.count);
        let (group, lane) = (index / WIDTH, index % WIDTH);
        let [x, y, z] = &self.groups[group];
        Vec3::new(x.0[lane], y.0[lane], z.0[lane])
    }

    /// Groups of sixteen in use.
    pub fn group_count(&self) -> usize {
        self.count.div_ceil(WIDTH)
    }

    /// A bit for each.
    pub(super) fn all(&self) -> u64 {
        if self.count == BUNDLE_RAYS { !0 } else { (1 << self.count) - 1 }
    }
}

impl Extend<Vec3> for Directions {
    fn extend<T: IntoIterator<Item = Vec3>>(&mut self, directions: T) {
        directions.into_iter().for_each(|d| self.push(d));
    }
}
