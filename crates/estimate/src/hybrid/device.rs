//! What of the method is done on a device: bundles of rays, many points at a time, and weighing (weighing.rs). Choosing stays where it is.

use super::{
    Hybrid, HybridConstants, Order, PlaceWeigher, Places,
    bundles::Again,
    refine::Work,
    start::SALT,
    tallies::{FULL, Tally},
};
use crate::{AoPlan, BackendError};
use conray_core::{SurfacePoint, Vec3};

/// Rays that are asked for at once are those of about so many units: enough to fill a device, few enough to stop soon.
const UNITS_AT_ONCE: usize = 1 << 17;

/// Rays of one point's sequence that are traced together: some units of sixteen rays, four of them a full bundle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batch {
    /// Which of the points.
    pub point: u32,
    /// The first unit of the point's sequence; `first % 4 + count` is at most 4.
    pub first: u32,
    /// From 1 to 4.
    pub count: u32,
}

impl Batch {
    /// Units of a full bundle.
    pub const FULL: u32 = FULL;

    /// True where its rays are stratified as those of a full bundle.
    pub fn is_full(&self) -> bool {
        self.count == Self::FULL
    }
}

/// What one unit found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnitFound {
    /// Mean visibility of its rays.
    pub mean: f32,
    /// Variance of that, as if the rays were independent within each of the 2 x 2 quarters of the square of directions.
    pub variance: f32,
    /// Mean of directions times their visibility.
    pub bent: Vec3,
}

/// What a batch found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BatchFound {
    /// Of each unit; zero past the last.
    pub units: [UnitFound; FULL as usize],
    /// Of a full bundle the variance of its mean, as if the rays were independent within each of 4 x 4 cells of the square.
    pub variance: f32,
}

/// A device's part of method `hybrid`.
pub trait HybridDevice: Send + Sync {
    /// What the rays of each batch found, in order. About 131 072 units are asked for at once at most: short enough that no driver takes the device
    /// for stuck. `salt` chooses another sequence of each point: its seed is the hash of its `id` and of the hash of the plan's seed and the
    /// salt, each pair by exclusive or ([`conray_core::hash_u32`]).
    ///
    /// # Errors
    /// [`BackendError::Device`] of a device that fails.
    fn trace(
        &self,
        plan: &AoPlan,
        points: &[SurfacePoint],
        batches: &[Batch],
        salt: u32,
    ) -> Result<Vec<BatchFound>, BackendError>;

    /// Takes in what is known of places without a ray, to weigh there what rays will find. `None` where weighing is left to the CPU, as where
    /// the places do not fit.
    ///
    /// # Errors
    /// [`BackendError::Device`] of a device that fails.
    fn weigher<'a>(
        &'a self,
        constants: &HybridConstants,
        places: &Places<'_>,
    ) -> Result<Option<Box<dyn PlaceWeigher + 'a>>, BackendError>;
}

/// The aligned batches that some units of a point's sequence are.
fn batches_of(point: u32, units: std::ops::Range<u32>) -> impl Iterator<Item = Batch> {
    let mut first = units.start;
    std::iter::from_fn(move || {
        let count = (FULL - first % FULL).min(units.end.saturating_sub(first));
        let batch = Batch { point, first, count };
        first += count;
        (count > 0).then_some(batch)
    })
}

impl BatchFound {
    fn tally(&self, batch: &Batch) -> Tally {
        let units = &self.units[..batch.count as usize];
        let in_units = if batch.is_full() { 0.0 } else { units.iter().map(|unit| unit.variance).sum() };
        Tally {
            units: batch.count,
            sum: units.iter().map(|unit| unit.mean).sum(),
            in_units,
            in_fulls: if batch.is_full() { self.variance } else { 0.0 },
            bent: units.iter().map(|unit| unit.bent).sum(),
        }
    }

    /// Of a full bundle.
    fn again(&self) -> Again {
        let mean = |of: fn(&UnitFound) -> f32| self.units.iter().map(of).sum::<f32>() / FULL as f32;
        Again {
            mean: mean(|unit| unit.mean),
            first: self.units[0].mean,
            in_units: mean(|unit| unit.variance),
            in_full: self.variance,
        }
    }
}

impl Hybrid {
    /// Carries out orders on a device, in parts: the tallies, empty past where it was stopped or failed.
    pub(super) fn trace_on(
        &mut self,
        device: &dyn HybridDevice,
        work: &Work<'_>,
        orders: &[Order],
        until: f64,
        told: impl Fn(u64),
    ) -> Vec<Tally> {
        let mut found = vec![Tally::default(); orders.len()];
        let mut from = 0;
        while from < orders.len() {
            let late = until < f64::INFINITY && work.meter.elapsed() > until;
            if late || work.meter.control.is_cancelled() {
                break;
            }
            let (mut batches, mut owners, mut units) = (Vec::new(), Vec::new(), 0);
            while from < orders.len() && units < UNITS_AT_ONCE {
                let Order { at, units: more } = orders[from];
                let had = self.tallies[at as usize].units;
                let of_order = batches_of(self.pixels.point[at as usize], had..had + more);
                batches.extend(of_order.inspect(|_| owners.push(from)));
                units += more as usize;
                from += 1;
            }
            match device.trace(work.plan, work.points, &batches, 0) {
                Ok(answers) => {
                    for ((answer, batch), owner) in answers.iter().zip(&batches).zip(owners) {
                        found[owner].merge(&answer.tally(batch));
                    }
                    told(units as u64);
                }
                Err(e) => {
                    self.failure = Some(e);
                    break;
                }
            }
        }
        found
    }

    /// Full bundles of another sequence at some of the points; none where the device fails.
    pub(super) fn again_on(
        &mut self,
        device: &dyn HybridDevice,
        work: &Work<'_>,
        points: &[u32],
    ) -> Vec<Again> {
        let batches: Vec<Batch> =
            points.iter().map(|&point| Batch { point, first: 0, count: FULL }).collect();
        match device.trace(work.plan, work.points, &batches, SALT) {
            Ok(found) => found.iter().map(BatchFound::again).collect(),
            Err(e) => {
                self.failure = Some(e);
                Vec::new()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_fall_into_aligned_batches() {
        let told = |units| batches_of(7, units).map(|b| (b.first, b.count)).collect::<Vec<_>>();
        assert_eq!(told(0..1), [(0, 1)]);
        assert_eq!(told(1..10), [(1, 3), (4, 4), (8, 2)]);
        assert_eq!(told(4..12), [(4, 4), (8, 4)]);
        assert!(told(3..3).is_empty());
        assert!(batches_of(7, 1..10).all(|batch| batch.point == 7));
    }
}
