//! Kernels timed against each other on the same rays, chunk of points by chunk of points, each in turn.
//!
//! A thread takes a tile of rays over into the kernel's layout, starts the clock, traces, and stops it: making rays,
//! filling structures and reading answers are in no kernel's time, and the rays lie in the nearest caches when it starts.
//! All threads trace the same kernel at the same time; their seconds are added and divided by their number. The tiles
//! of a chunk follow each other, so that a kernel finds its hierarchy as it left it and not as a rival did. Of each tile the
//! median over the rounds counts: a tile takes some ten microseconds, so that what else a machine does hits few of them.

use crate::{
    hemispheres::{CHUNK, Directions, Order, Ordered},
    kernels::{Family, Kernel, Tile},
};
use conray_core::SurfacePoint;
use rayon::prelude::*;
use std::time::Instant;

/// Rays taken over at one go, in Embree's layout 48 kB, and at least so many points as fill a row of the widest packets:
/// the second-level cache holds them.
const TILE_RAYS: usize = 1024;
const TILE_POINTS: usize = 16;

/// What a kernel did in a race.
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// Name in tables.
    pub name: String,
    /// Whose it is.
    pub family: Family,
    /// Seconds for all rays on all threads: for each tile the median over the rounds, added up.
    pub seconds: f64,
    /// The same from the lower and the upper quartiles of the tiles instead of their medians.
    pub quartiles: (f64, f64),
    /// Seconds of the fastest and the slowest round as they were, with all that came between.
    pub rounds: (f64, f64),
    /// Open rays.
    pub open: u64,
    /// Rays on which it and the first kernel do not agree, in the round in which they were most.
    pub differing: u64,
}

/// A race over.
#[derive(Clone, Debug, PartialEq)]
pub struct Race {
    /// Rays of each point.
    pub rays_per_point: usize,
    /// Rays of all points.
    pub rays: u64,
    /// Seconds that making the directions takes on all threads, median of the rounds: in no kernel's time.
    pub directions_seconds: f64,
    /// The kernels in the order given.
    pub finishes: Vec<Finish>,
}

/// Lets kernels trace the hemispheres of all points in `rounds` timed rounds, after one to warm up.
///
/// # Panics
/// If there is no kernel or no round.
pub fn race(
    points: &[SurfacePoint],
    rays_per_point: usize,
    kernels: &[Box<dyn Kernel + '_>],
    rounds: usize,
) -> Race {
    assert!(!kernels.is_empty() && rounds > 0, "nothing to race");
    let mut tallies = vec![Tally::default(); kernels.len()];
    let mut making = Vec::new();
    let mut directions = Directions::default();
    for round in 0..=rounds {
        let mut seconds = 0.0;
        tallies.iter_mut().for_each(Tally::start_round);
        for points in points.chunks(CHUNK) {
            let start = Instant::now();
            directions.draw(points, rays_per_point);
            seconds += start.elapsed().as_secs_f64();
            let orders = Orders::new(&directions, kernels);
            let mut runs: Vec<Option<Run>> = kernels.iter().map(|_| None).collect();
            for step in 0..kernels.len() {
                // Another kernel starts in each round.
                let k = (step + round) % kernels.len();
                runs[k] = Some(Run::new(&*kernels[k], points, orders.of(&*kernels[k])));
            }
            let runs: Vec<Run> = runs.into_iter().flatten().collect();
            for (tally, run) in tallies.iter_mut().zip(&runs) {
                tally.add(run, &runs[0]);
            }
        }
        making.push(seconds);
    }
    Race {
        rays_per_point,
        rays: (points.len() * rays_per_point) as u64,
        directions_seconds: median(&mut making[1..]),
        finishes: tallies.into_iter().zip(kernels).map(|(tally, kernel)| tally.finish(&**kernel)).collect(),
    }
}

/// The rays of a chunk in each order that a kernel asks for.
struct Orders(Vec<(Order, Ordered)>);

impl Orders {
    fn new(directions: &Directions, kernels: &[Box<dyn Kernel + '_>]) -> Self {
        let asked = Order::ALL.into_iter().filter(|order| kernels.iter().any(|k| k.order() == *order));
        Self(asked.map(|order| (order, directions.ordered(order))).collect())
    }

    fn of(&self, kernel: &dyn Kernel) -> &Ordered {
        &self
            .0
            .iter()
            .find(|(order, _)| *order == kernel.order())
            .expect("all that are asked for are there")
            .1
    }
}

/// A kernel's run over a chunk.
struct Run {
    /// Seconds of each tile on its thread.
    seconds: Vec<f64>,
    /// Of each ray, in the order in which they were drawn.
    open: Vec<bool>,
}

impl Run {
    fn new(kernel: &dyn Kernel, points: &[SurfacePoint], rays: &Ordered) -> Self {
        let per_point = rays.directions.len() / points.len();
        let tile_points = (TILE_RAYS / per_point).max(TILE_POINTS);
        let tile_rays = tile_points * per_point;
        let mut open = vec![false; rays.directions.len()];
        let tiles = points.par_chunks(tile_points).zip(rays.directions.par_chunks(tile_rays));
        let places = rays.drawn.par_chunks(tile_rays).zip(open.par_chunks_mut(tile_rays));
        let seconds = tiles
            .zip(places)
            .map_init(
                || (kernel.tracer(), Vec::new()),
                |(tracer, answers), ((points, directions), (drawn, open))| {
                    tracer.prepare(Tile { points, directions });
                    let start = Instant::now();
                    tracer.trace();
                    let seconds = start.elapsed().as_secs_f64();
                    answers.clear();
                    tracer.answers(answers);
                    for (i, (&drawn, &answer)) in drawn.iter().zip(answers.iter()).enumerate() {
                        open[i / per_point * per_point + drawn as usize] = answer;
                    }
                    seconds
                },
            )
            .collect();
        Self { seconds, open }
    }
}

/// Times and answers of a kernel so far.
#[derive(Clone, Default)]
struct Tally {
    /// By tile, then by timed round.
    tiles: Vec<Vec<f64>>,
    /// By round, the first to warm up.
    totals: Vec<f64>,
    /// Tiles of this round so far.
    tile: usize,
    open: u64,
    now_differing: u64,
    differing: u64,
}

impl Tally {
    fn start_round(&mut self) {
        self.totals.push(0.0);
        (self.tile, self.open, self.now_differing) = (0, 0, 0);
    }

    fn add(&mut self, run: &Run, reference: &Run) {
        self.open += run.open.iter().filter(|o| **o).count() as u64;
        self.now_differing += run.open.iter().zip(&reference.open).filter(|(a, b)| a != b).count() as u64;
        self.differing = self.differing.max(self.now_differing);
        let round = self.totals.len() - 1;
        self.totals[round] += run.seconds.iter().sum::<f64>();
        for &seconds in run.seconds.iter().filter(|_| round > 0) {
            if self.tile == self.tiles.len() {
                self.tiles.push(Vec::new());
            }
            self.tiles[self.tile].push(seconds);
            self.tile += 1;
        }
    }

    fn finish(mut self, kernel: &dyn Kernel) -> Finish {
        let threads = rayon::current_num_threads() as f64;
        let totals = self.totals[1..].iter().map(|seconds| seconds / threads);
        self.tiles.iter_mut().for_each(|rounds| rounds.sort_by(f64::total_cmp));
        let at = |share: f64| {
            let place = |rounds: &Vec<f64>| rounds[(share * (rounds.len() - 1) as f64).round() as usize];
            self.tiles.iter().map(place).sum::<f64>() / threads
        };
        Finish {
            name: kernel.name(),
            family: kernel.family(),
            seconds: at(0.5),
            quartiles: (at(0.25), at(0.75)),
            rounds: (totals.clone().fold(f64::INFINITY, f64::min), totals.fold(0.0, f64::max)),
            open: self.open,
            differing: self.differing,
        }
    }
}

/// The middle value, of an even number the upper of the two; sorts them. 0 for none.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

impl Race {
    /// Million rays a second of a kernel, all threads together.
    pub fn mrays(&self, finish: &Finish) -> f64 {
        self.rays as f64 / finish.seconds / 1e6
    }

    /// The fastest kernel of a family.
    pub fn best(&self, family: Family) -> Option<&Finish> {
        let own = self.finishes.iter().filter(|f| f.family == family);
        own.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }

    /// How many times as fast as Embree's best mode a kernel is; `None` where Embree took no part.
    pub fn ratio(&self, finish: &Finish) -> Option<f64> {
        self.best(Family::Embree).map(|best| best.seconds / finish.seconds)
    }
}
