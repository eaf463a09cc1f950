//! The same number of bundles at every point, each answered by its own: where weighing costs more time than it saves.

use super::{Hybrid, Order, refine::Work, weigh::Known};

/// Bundles grow so many times in a round, so that what they cost is known before most are traced.
const GROWTH: u32 = 4;

impl Hybrid {
    /// Brings all points to as many bundles as foreseen, step by step; false where nothing was left to do.
    pub(super) fn level(&mut self, work: &Work<'_>, until: f64) -> bool {
        let goal = (self.foreseen / f64::from(self.rays.unit.rays)) as u32;
        let covered = || self.pixels.place_of.iter().filter(|&&at| at != super::NO_POINT);
        let least = covered().map(|&at| self.tallies[at as usize].bundles).min().unwrap_or(0);
        let next = goal.min((GROWTH * least).max(1));
        let missing = |&at: &u32| {
            let had = self.tallies[at as usize].bundles;
            (had < next).then(|| Order { at, bundles: next - had })
        };
        let orders: Vec<Order> = covered().filter_map(missing).collect();
        if orders.is_empty() {
            return false;
        }
        self.trace(work, &orders, until);
        self.know_by_own_rays();
        true
    }

    /// What each point's own rays tell; what neighbours said stays where it has none.
    fn know_by_own_rays(&mut self) {
        let tallies = self.shown().into_owned();
        for (known, tally) in self.known.iter_mut().zip(&tallies) {
            if tally.bundles > 0 {
                // The variance of few bundles is itself uncertain: that of like neighbours counts for one more.
                let bundles = tally.bundles as f32;
                let cells_variance = (tally.variance + known.cells_variance) / (bundles + 1.0);
                let error2 = self.rays.variance(cells_variance, tally.bundles);
                *known = Known { value: tally.mean(), error2, ..*known };
            }
        }
    }
}
