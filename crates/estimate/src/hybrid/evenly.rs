//! The same number of rays at every point, each answered by its own: where weighing costs more time than it saves.

use super::{
    Hybrid, NO_POINT, Order,
    refine::Work,
    shown,
    tallies::{Rays, UNIT},
};

/// Rays grow so many times in a round, so that what they cost is known before most are traced.
const GROWTH: u32 = 4;

impl Hybrid {
    /// Brings all points to as many units as foreseen, step by step; false where nothing was left to do.
    pub(super) fn level(&mut self, work: &Work<'_>, until: f64) -> bool {
        let goal = (self.foreseen / f64::from(UNIT)) as u32;
        let covered = || self.pixels.place_of.iter().filter(|&&at| at != NO_POINT);
        let least = covered().map(|&at| self.tallies[at as usize].units).min().unwrap_or(0);
        let next = goal.min((GROWTH * least).max(self.rays.first));
        let missing = |&at: &u32| {
            let had = self.tallies[at as usize].units;
            (had < next).then(|| Order { at, units: next - had })
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
        let tallies = shown(&self.tallies, &self.unfinished);
        for (at, tally) in tallies.iter().enumerate().filter(|(_, tally)| tally.units > 0) {
            // The variance of few units is itself uncertain: that of like neighbours counts for one more.
            let (units, own) = (tally.units as f32, self.rays.unit_variance(tally));
            let unit_variance = (own * units + self.known.unit_variance[at]) / (units + 1.0);
            self.known.value[at] = tally.mean();
            self.known.error2[at] = Rays::variance(unit_variance, tally.units);
        }
    }
}
