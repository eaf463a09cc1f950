//! What rays and weighing cost here, in wall-clock seconds with all threads at work.

use super::{
    Batch, Hybrid, HybridDevice, bundles,
    refine::Work,
    start::SALT,
    tallies::{FULL, UNIT},
};
use rayon::prelude::*;
use web_time::Instant;

/// Points of the timed pilot, spread over the target; more where there are many threads.
const POINTS: usize = 256;
/// Of how many points one is timed at most: small targets are not to be traced twice.
const TIMED_OF: u64 = 32;
const POINTS_A_THREAD: usize = 32;
/// Of how many points one is asked to find out what answering takes.
const ANSWER_OF: usize = 31;
/// Seconds that one thread needs to weigh a pixel and answer for it, before it was timed: 20 ms for 512 x 512 on two threads.
const WEIGHING_GUESS: f64 = 1.5e-7;

/// What was timed so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Costs {
    /// Of a ray in bundles of the size in use.
    pub(super) ray_seconds: Option<f64>,
    /// Of weighing all points once.
    pub(super) weighing_seconds: Option<f64>,
    /// Of the final answers.
    pub(super) answer_seconds: Option<f64>,
    /// Of a ray in small and in full bundles, as the pilot found.
    piloted: Option<[f64; 2]>,
}

impl Costs {
    /// Of a ray in such bundles, as the pilot found.
    pub(super) fn piloted(&self, units: u32) -> Option<f64> {
        self.piloted.map(|[small, full]| if units < FULL { small } else { full })
    }
}

impl Hybrid {
    /// Times bundles of both sizes at spread points.
    pub(super) fn time_rays(&mut self, work: &Work<'_>) {
        let threads = rayon::current_num_threads();
        let wanted = POINTS.max(POINTS_A_THREAD * threads).min(self.covered.div_ceil(TIMED_OF) as usize);
        let places: Vec<u32> = self.pixels.covered().collect();
        let pick = |k: usize| self.pixels.point[places[k * places.len() / wanted] as usize];
        let picked: Vec<u32> = (0..wanted).map(pick).collect();
        let on_device = |device: &dyn HybridDevice, units: u32| {
            let batch = |&point: &u32| Batch { point, first: 0, count: units };
            let batches: Vec<Batch> = picked.iter().map(batch).collect();
            device.trace(work.plan, work.points, &batches, SALT).err()
        };
        let here = |units: u32| {
            picked.par_iter().with_min_len(wanted.div_ceil(4 * threads)).for_each(|&point| {
                bundles::trace(work.plan, work.bvh, &work.points[point as usize], 0..units, SALT);
            });
        };
        let mut failure = None;
        let mut time = |units: u32| {
            let start = Instant::now();
            match work.device {
                Some(device) => failure = failure.take().or(on_device(device, units)),
                None => here(units),
            }
            start.elapsed().as_secs_f64() / (wanted as f64 * f64::from(units * UNIT))
        };
        // The first time warms caches up.
        time(1);
        self.costs.piloted = Some([time(1), time(FULL)]);
        self.failure = self.failure.take().or(failure);
        self.pilot_rays += wanted as u64 * u64::from((1 + 1 + FULL) * UNIT);
    }

    /// Times the answers for some of the points.
    pub(super) fn time_answers(&mut self) {
        let start = Instant::now();
        let asked = self.estimates_of(ANSWER_OF).len().max(1);
        let seconds = start.elapsed().as_secs_f64();
        self.costs.answer_seconds = Some(seconds * self.pixels.place_of.len() as f64 / asked as f64);
    }

    /// Seconds from the last ray to the last answer.
    pub(super) fn tail_seconds(&self) -> f64 {
        let guess = WEIGHING_GUESS * self.pixels.len() as f64 / rayon::current_num_threads() as f64;
        let weighing = match self.choice {
            crate::Choice::Hybrid => self.costs.weighing_seconds.unwrap_or(guess),
            crate::Choice::Evenly => 0.0,
        };
        weighing + self.costs.answer_seconds.unwrap_or(guess)
    }
}
