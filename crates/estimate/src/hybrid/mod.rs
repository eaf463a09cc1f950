//! Method `hybrid`: rays where they help most, neighbours where they agree, each weighed by its expected squared error.
//!
//! ```text
//! pixels.rs: points side by side, scattered ones too (scattered.rs)
//!    |
//! start.rs: a lattice of points gets a bundle of rays each ----> Tally of each pixel (bundles.rs, tallies.rs)
//!    ^                                                                |
//!    |            cells.rs: tallies of like neighbours merged  <------+
//!    |            guesses.rs, regress.rs: two guesses from the neighbours, a pixel's own rays left out
//!    |            told.rs, residuals.rs: how wrong such guesses are, found where rays tell
//!    |            weigh.rs: guess and own rays, weighed ----> Known: visibility, expected error
//!    +---- choose.rs: more bundles where they lower the error most <--+
//! ```
//!
//! device.rs traces the bundles on a device instead, many points at a time, and weighing.rs weighs there.
//!
//! refine.rs goes round until a budget is spent: forecast.rs foresees rays and errors, costs.rs knows what time they take, evenly.rs
//! leaves the weighing out where it does not pay, state.rs keeps the work for later.
//!
//! A pixel's own rays are unbiased and their variance is known; the guess's squared error is what it was found to be. So the
//! guess fades as rays come in and the result converges to the truth. `docs/method.md` derives it.

mod bent;
mod bundles;
mod cells;
mod choose;
mod columns;
mod constants;
mod costs;
mod device;
mod evenly;
mod forecast;
mod guesses;
mod likeness;
mod pixels;
mod refine;
mod regress;
mod residuals;
mod scattered;
mod spread;
mod start;
mod state;
mod tallies;
mod told;
mod weigh;
mod weighing;
mod window;

pub use constants::HybridConstants;
pub use device::{Batch, BatchFound, HybridDevice, UnitFound};
pub use state::StateError;
pub use tallies::{Rays as RayErrors, Tally as PlaceTally};
pub use weigh::Known;
pub use weighing::{PlaceWeigher, Places};

use crate::{AoPlan, BackendError, Choice, Explanation, Round};
use choose::Order;
use columns::PART;
use conray_core::{Estimate, SurfacePoint};
use costs::Costs;
use pixels::{NO_POINT, Pixels};
use rayon::prelude::*;
use std::borrow::Cow;
use tallies::{Rays, Tally, UNIT};
use weigh::Weigher;

/// A target under work by method `hybrid`: refined as often as one likes, the same points handed in each time.
#[derive(Clone, Debug)]
pub struct Hybrid {
    constants: HybridConstants,
    pixels: Pixels,
    /// Places that have a point.
    covered: u64,
    /// Of whole rounds.
    tallies: Vec<Tally>,
    /// Units of rays in them: summed once, not at every question.
    units: u64,
    /// What an interrupted round found, one a place; empty where there was none.
    unfinished: Vec<Tally>,
    rays: Rays,
    /// True once the lattice is whole.
    started: bool,
    /// Rays traced to find out how rays err and what they cost, or left behind; they are in no tally.
    pilot_rays: u64,
    known: Known,
    /// True where a device weighed it.
    known_on_device: bool,
    /// True where it holds what an interrupted round found.
    known_of_unfinished: bool,
    weigher: Weigher,
    rounds: Vec<Round>,
    /// How many rounds there were when work began anew with full bundles, if it did.
    begun_anew: Option<usize>,
    choice: Choice,
    costs: Costs,
    /// Rays a point that the plan reckons with.
    foreseen: f64,
    foreseen_rmse: Option<[f64; 2]>,
    /// What a device said when it failed.
    failure: Option<BackendError>,
    /// True where what an interrupted round found is not weighed before work goes on.
    weighs_later: bool,
}

impl Hybrid {
    /// Work on the points of an image of that width and height: the `id` of each is its pixel, `first + y * width + x`.
    pub fn of_image(plan: &AoPlan, points: &[SurfacePoint], first: u32, size: [u32; 2]) -> Self {
        Self::new(Pixels::of_image(points, first, size, plan.distance))
    }

    /// Work on points that lie in no image: vertices, texels of many charts, places of a file. Neighbours are found in the world.
    pub fn of_scattered(plan: &AoPlan, points: &[SurfacePoint]) -> Self {
        Self::new(Pixels::of_scattered(points, plan.distance))
    }

    fn new(pixels: Pixels) -> Self {
        Self {
            constants: HybridConstants::default(),
            covered: pixels.covered().count() as u64,
            tallies: vec![Tally::default(); pixels.len()],
            units: 0,
            unfinished: Vec::new(),
            rays: start::unknown(1),
            started: false,
            pilot_rays: 0,
            known: Known::default(),
            known_on_device: false,
            known_of_unfinished: false,
            weigher: Weigher::default(),
            rounds: Vec::new(),
            begun_anew: None,
            choice: Choice::Hybrid,
            costs: Costs::default(),
            foreseen: 0.0,
            foreseen_rmse: None,
            failure: None,
            weighs_later: false,
            pixels,
        }
    }

    /// The same work by other constants, for experiments: to be set before the first rays.
    pub fn with_constants(self, constants: HybridConstants) -> Self {
        Self { constants, ..self }
    }

    /// From now on what an interrupted round found is weighed when work goes on, and estimates are those before it: for those who show nothing of work
    /// that was stopped, and do not want to wait for it.
    pub fn weigh_later(&mut self) {
        self.weighs_later = true;
    }

    /// Rays traced so far.
    pub fn rays(&self) -> u64 {
        self.rays_of_rounds() + units_in(&self.unfinished) * u64::from(UNIT)
    }

    /// Those of whole rounds and pilots.
    fn rays_of_rounds(&self) -> u64 {
        self.units * u64::from(UNIT) + self.pilot_rays
    }

    /// How rays err here, as the pilot found; a guess before the first rays.
    pub fn ray_errors(&self) -> RayErrors {
        self.rays
    }

    /// Expected root mean square error over all points; infinite before the first rays.
    pub fn expected_rmse(&self) -> f64 {
        // In parts, so that the sum does not depend on threads.
        let part = |(points, errors): (&[u32], &[f32])| {
            let errors = points.iter().zip(errors).filter(|(point, _)| **point != NO_POINT);
            errors.fold((0.0, 0u64), |(sum, count), (_, &error2)| (sum + f64::from(error2), count + 1))
        };
        let parts = self.pixels.point.par_chunks(PART).zip(self.known.error2.par_chunks(PART));
        let parts: Vec<(f64, u64)> = parts.map(part).collect();
        let (sum, count) = parts.into_iter().fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        if count > 0 { (sum / count as f64).sqrt() } else { f64::INFINITY }
    }

    /// Why a device failed in the last refinement, if it did.
    pub fn failure(&self) -> Option<&BackendError> {
        self.failure.as_ref()
    }

    /// The plan as carried out so far, and why.
    pub fn explanation(&self) -> Explanation {
        Explanation {
            points: self.covered,
            choice: self.choice,
            bundle_rays: self.rays.first * UNIT,
            foreseen_rays: self.foreseen,
            ray_seconds: self.costs.ray_seconds,
            weighing_seconds: self.costs.weighing_seconds,
            foreseen_rmse: self.foreseen_rmse,
            rounds: self.rounds.clone(),
        }
    }

    /// The estimates so far, one a point: pending before the first rays, and of infinite error where a point is not valid.
    pub fn estimates(&self) -> Vec<Estimate> {
        self.estimates_of(1)
    }

    /// Those of every so manieth point.
    fn estimates_of(&self, every: usize) -> Vec<Estimate> {
        let tallies = shown(&self.tallies, &self.unfinished);
        let one = |&at: &u32| {
            if at == NO_POINT {
                return Estimate::INVALID;
            }
            let at = at as usize;
            let Some(&visibility) = self.known.value.get(at) else { return Estimate::PENDING };
            let tally = &tallies[at];
            Estimate {
                visibility,
                error: self.known.error2[at].sqrt(),
                rays: tally.units * UNIT,
                bent: bent::bent(&self.pixels, &tallies, at, visibility),
                cone: None,
            }
        };
        self.pixels.place_of.par_iter().step_by(every).with_min_len((1 << 12) / every).map(one).collect()
    }
}

/// What all rays found, those of an interrupted round too.
fn shown<'a>(tallies: &'a [Tally], unfinished: &[Tally]) -> Cow<'a, [Tally]> {
    if unfinished.is_empty() {
        return Cow::Borrowed(tallies);
    }
    let mut all = tallies.to_vec();
    all.iter_mut().zip(unfinished).for_each(|(all, more)| all.merge(more));
    Cow::Owned(all)
}

/// Units of rays in all of them.
fn units_in(tallies: &[Tally]) -> u64 {
    tallies.iter().map(|tally| u64::from(tally.units)).sum()
}
