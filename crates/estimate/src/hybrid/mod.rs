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
//! A pixel's own rays are unbiased and their variance is known; the guess's squared error is what it was found to be. So the
//! guess fades as rays come in and the result converges to the truth. `docs/method.md` derives it.

mod bent;
mod bundles;
mod cells;
mod choose;
mod columns;
mod likeness;
mod look;
mod pixels;
mod regress;
mod residuals;
mod start;
mod tallies;
mod weigh;
mod window;

use crate::{AoPlan, Control, cpu::INVALID};
use choose::Order;
use conray_bvh::{Bvh, Level};
use conray_core::{Estimate, SurfacePoint};
use pixels::{NO_POINT, Pixels};
use rayon::prelude::*;
use tallies::{Rays, Tally, UNIT};
use weigh::{Known, Weigher};

/// Bundles of the next round, of those left. Late rounds choose better, early ones cost more than their rays.
fn this_round(had: u64, left: u64, points: u64) -> u64 {
    let much = if EARLY * had < points { 4 * had } else { 2 * had };
    if left > much { had.max(left.div_ceil(3)) } else { left }
}

/// Below a bundle for so many points it is early.
const EARLY: u64 = 8;

/// A target under work by method `hybrid`: refined as often as one likes, the same points handed in each time.
#[derive(Clone, Debug)]
pub struct Hybrid {
    pixels: Pixels,
    tallies: Vec<Tally>,
    rays: Rays,
    /// Rays traced to find out how rays err; they are in no tally.
    pilot_rays: u64,
    known: Known,
    weigher: Weigher,
}

impl Hybrid {
    /// Work on the points of an image of that size: the `id` of each is its pixel, `y * width + x`.
    pub fn of_image(plan: &AoPlan, points: &[SurfacePoint], width: u32, height: u32) -> Self {
        let pixels = Pixels::new(points, width, height, plan.distance);
        let tallies = vec![Tally::default(); pixels.len()];
        let rays = Rays { unit: 1.0, full: 1.0, first: 1 };
        Self { pixels, tallies, rays, pilot_rays: 0, known: Known::default(), weigher: Weigher::default() }
    }

    /// Rays traced so far.
    pub fn rays(&self) -> u64 {
        let units: u64 = self.tallies.iter().map(|t| u64::from(t.units)).sum();
        units * u64::from(UNIT) + self.pilot_rays
    }

    /// Expected root mean square error over all points; infinite before the first rays.
    pub fn expected_rmse(&self) -> f64 {
        let errors = self.pixels.place_of.iter().filter(|&&at| at != NO_POINT && !self.known.value.is_empty());
        let (sum, count) = errors.fold((0.0, 0u64), |(sum, count), &at| {
            (sum + f64::from(self.known.error2[at as usize]), count + 1)
        });
        if count > 0 { (sum / count as f64).sqrt() } else { f64::INFINITY }
    }

    /// Adds rays until there are so many a point on average, in rounds; stops after any round when cancelled.
    ///
    /// `points` are those that the work began with. The result depends on the plan, the points and the calls so far, not on
    /// threads.
    ///
    /// # Panics
    /// If there are fewer points than the work began with.
    pub fn refine(
        &mut self,
        plan: &AoPlan,
        bvh: &Bvh,
        points: &[SurfacePoint],
        rays_per_point: f64,
        control: Control<'_>,
    ) {
        let covered = self.pixels.place_of.iter().filter(|&&at| at != NO_POINT).count();
        if covered == 0 || control.is_cancelled() {
            return;
        }
        if self.known.value.is_empty() {
            self.start(plan, bvh, points, rays_per_point, control);
        }
        let unit = u64::from(UNIT);
        let goal = (rays_per_point * covered as f64 / unit as f64).round() as u64;
        while !control.is_cancelled() {
            let had = self.rays() / unit;
            let left = goal.saturating_sub(had);
            // A round costs some time of its own: none for a fiftieth.
            if left * 50 <= goal {
                break;
            }
            let now = this_round(had, left, covered as u64);
            let orders = choose::choose(&self.pixels, &self.tallies, &self.known, self.rays.first, now);
            if orders.is_empty() {
                break;
            }
            self.trace(plan, bvh, points, &orders, control);
            self.weigh(bvh.level());
        }
        if self.known.value.is_empty() {
            self.weigh(bvh.level());
        }
    }

    /// Carries out orders.
    fn trace(
        &mut self,
        plan: &AoPlan,
        bvh: &Bvh,
        points: &[SurfacePoint],
        orders: &[Order],
        control: Control<'_>,
    ) {
        let one = |order: &Order| {
            if control.is_cancelled() {
                return Tally::default();
            }
            let at = order.at as usize;
            let (point, had) = (self.pixels.point[at] as usize, self.tallies[at].units);
            let found = bundles::trace(plan, bvh, &points[point], had..had + order.units, 0);
            (control.progress)((order.units * UNIT) as usize);
            found
        };
        let found: Vec<Tally> = orders.par_iter().with_min_len(64).map(one).collect();
        for (order, found) in orders.iter().zip(&found) {
            self.tallies[order.at as usize].merge(found);
        }
    }

    fn weigh(&mut self, level: Level) {
        self.weigher.weigh(level, &self.pixels, &self.tallies, &self.rays, &mut self.known);
    }

    /// The estimates so far, one a point: pending before the first rays, and of infinite error where a point is not valid.
    pub fn estimates(&self) -> Vec<Estimate> {
        let one = |&at: &u32| {
            if at == NO_POINT {
                return INVALID;
            }
            let at = at as usize;
            let Some(&visibility) = self.known.value.get(at) else { return Estimate::PENDING };
            let tally = &self.tallies[at];
            Estimate {
                visibility,
                error: self.known.error2[at].sqrt(),
                rays: tally.units * UNIT,
                bent: bent::bent(&self.pixels, &self.tallies, at, visibility),
                cone: None,
            }
        };
        self.pixels.place_of.par_iter().with_min_len(1 << 12).map(one).collect()
    }
}
