//! Samples sorted into bundles by the quarter of the square that they lie in.

use super::squares::Drawn;
use conray_bvh::{BUNDLE_RAYS, Directions};
use conray_core::Vec3;

/// A bundle for each quarter of the unit square, which the cosine-weighted map takes to a quarter of the hemisphere.
pub(super) struct Quarters {
    bundles: [Directions; 4],
}

impl Quarters {
    pub(super) fn new() -> Self {
        Self { bundles: std::array::from_fn(|_| Directions::new()) }
    }

    /// Adds the first `count` of sixteen samples; `trace` gets each bundle that is full, to empty it.
    pub(super) fn push(&mut self, drawn: &Drawn, count: usize, mut trace: impl FnMut(&mut Directions)) {
        let Drawn { quarter, world: [x, y, z] } = drawn;
        for lane in 0..count {
            let bundle = &mut self.bundles[quarter[lane] as usize % 4];
            bundle.push(Vec3::new(x[lane], y[lane], z[lane]));
            if bundle.len() == BUNDLE_RAYS {
                trace(bundle);
            }
        }
    }

    /// Hands over the rest.
    pub(super) fn finish(&mut self, trace: impl FnMut(&mut Directions)) {
        self.bundles.iter_mut().filter(|bundle| !bundle.is_empty()).for_each(trace);
    }
}
