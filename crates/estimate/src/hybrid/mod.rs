//! Method `hybrid`: rays where they help most, neighbours where they agree, each weighed by its expected squared error.
//!
//! ```text
//! start.rs: a lattice of points gets a bundle of rays each ----> Tally of each pixel (bundles.rs, tallies.rs)
//!    ^                                                                |
//!    |            cells.rs: tallies of like neighbours merged  <------+
//!    |            regress.rs: two guesses from the neighbours, a pixel's own rays left out
//!    |            residuals.rs: how wrong such guesses are, found where rays tell
//!    |            weigh.rs: guess and own rays, weighed ----> Known: visibility, expected error
//!    +---- choose.rs: more bundles where they lower the error most <--+
//! ```
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
mod costs;
mod evenly;
mod forecast;
mod likeness;
mod pixels;
mod refine;
mod regress;
mod residuals;
mod start;
mod state;
mod tallies;
mod weigh;
mod window;

pub use state::StateError;

use crate::{Choice, Explanation, Round, cpu::INVALID};
use choose::Order;
use conray_bvh::Level;
use conray_core::{Estimate, SurfacePoint};
use costs::Costs;
use pixels::{NO_POINT, Pixels};
use rayon::prelude::*;
use std::{borrow::Cow, time::Instant};
use tallies::{Bundle, Rays, Tally};
use weigh::Known;

/// A target under work by method `hybrid`: refined as often as one likes, the same points handed in each time.
#[derive(Clone, Debug)]
pub struct Hybrid {
    pixels: Pixels,
    /// Places that have a point.
    covered: u64,
    /// Of whole rounds.
    tallies: Vec<Tally>,
    /// What an interrupted round found, one a place; empty where there was none.
    unfinished: Vec<Tally>,
    rays: Rays,
    /// True once the lattice is whole.
    started: bool,
    /// Rays traced to find out how rays err and what they cost, or left behind; they are in no tally.
    pilot_rays: u64,
    known: Vec<Known>,
    rounds: Vec<Round>,
    choice: Choice,
    costs: Costs,
    /// Rays a point that the plan reckons with.
    foreseen: f64,
    foreseen_rmse: Option<[f64; 2]>,
}

impl Hybrid {
    /// Work on the points of an image of that size: the `id` of each is its pixel, `y * width + x`.
    pub fn of_image(plan: &crate::AoPlan, points: &[SurfacePoint], width: u32, height: u32) -> Self {
        let pixels = Pixels::new(points, width, height, plan.distance);
        Self {
            covered: pixels.place_of.iter().filter(|&&at| at != NO_POINT).count() as u64,
            tallies: vec![Tally::default(); pixels.len()],
            unfinished: Vec::new(),
            rays: Rays { unit: Bundle::of(0.0), stratified: start::STRATIFIED as f32 },
            started: false,
            pilot_rays: 0,
            known: Vec::new(),
            rounds: Vec::new(),
            choice: Choice::Hybrid,
            costs: Costs::default(),
            foreseen: 0.0,
            foreseen_rmse: None,
            pixels,
        }
    }

    /// Rays traced so far.
    pub fn rays(&self) -> u64 {
        let bundles: u64 = self.unfinished.iter().map(|t| u64::from(t.bundles)).sum();
        self.rays_of_rounds() + bundles * u64::from(self.rays.unit.rays)
    }

    /// Those of whole rounds and pilots.
    fn rays_of_rounds(&self) -> u64 {
        let bundles: u64 = self.tallies.iter().map(|t| u64::from(t.bundles)).sum();
        bundles * u64::from(self.rays.unit.rays) + self.pilot_rays
    }

    /// Expected root mean square error over all points; infinite before the first rays.
    pub fn expected_rmse(&self) -> f64 {
        let errors = self.pixels.place_of.iter().filter(|&&at| at != NO_POINT && !self.known.is_empty());
        let (sum, count) = errors.fold((0.0, 0u64), |(sum, count), &at| {
            (sum + f64::from(self.known[at as usize].error2), count + 1)
        });
        if count > 0 { (sum / count as f64).sqrt() } else { f64::INFINITY }
    }

    /// The plan as carried out so far, and why.
    pub fn explanation(&self) -> Explanation {
        Explanation {
            points: self.covered,
            choice: self.choice,
            bundle_rays: self.rays.unit.rays,
            foreseen_rays: self.foreseen,
            ray_seconds: self.costs.ray_seconds,
            weighing_seconds: self.costs.weighing_seconds,
            foreseen_rmse: self.foreseen_rmse,
            rounds: self.rounds.clone(),
        }
    }

    /// What all rays found, those of an interrupted round too.
    fn shown(&self) -> Cow<'_, [Tally]> {
        if self.unfinished.is_empty() {
            return Cow::Borrowed(&self.tallies);
        }
        let mut all = self.tallies.clone();
        all.iter_mut().zip(&self.unfinished).for_each(|(all, more)| all.merge(more));
        Cow::Owned(all)
    }

    /// Weighs all that is shown.
    fn weigh(&mut self, level: Level) {
        let start = Instant::now();
        self.known = weigh::weigh(level, &self.pixels, &self.shown(), &self.rays);
        self.costs.weighing_seconds = Some(start.elapsed().as_secs_f64());
    }

    /// The estimates so far, one a point: pending before the first rays, and of infinite error where a point is not valid.
    pub fn estimates(&self) -> Vec<Estimate> {
        self.estimates_of(1)
    }

    /// Those of every so manieth point.
    fn estimates_of(&self, every: usize) -> Vec<Estimate> {
        let tallies = self.shown();
        let one = |&at: &u32| {
            if at == NO_POINT {
                return INVALID;
            }
            let Some(known) = self.known.get(at as usize) else { return Estimate::PENDING };
            let tally = &tallies[at as usize];
            Estimate {
                visibility: known.value,
                error: known.error2.sqrt(),
                rays: tally.bundles * self.rays.unit.rays,
                bent: bent::bent(&self.pixels, &tallies, at as usize, known.value),
                cone: None,
            }
        };
        self.pixels.place_of.par_iter().step_by(every).with_min_len((1 << 12) / every).map(one).collect()
    }
}
