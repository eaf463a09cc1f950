//! The time of work that is done point by point, on all threads, whatever else the machine does.

use crate::race::median;
use conray_core::SurfacePoint;
use rayon::prelude::*;
use std::{hint::black_box, time::Instant};

/// Seconds that some work takes over all points on all threads, and the sum of what it found.
///
/// The points go to the threads in tiles of that many. Of each tile the median over the rounds counts, after one to warm
/// up; the medians are added and divided by the number of threads.
pub fn time(
    points: &[SurfacePoint],
    tile_points: usize,
    rounds: usize,
    work: impl Fn(&[SurfacePoint]) -> f64 + Sync,
) -> (f64, f64) {
    let mut tiles: Vec<Vec<f64>> = vec![Vec::new(); points.len().div_ceil(tile_points)];
    let mut sum = 0.0;
    for round in 0..=rounds {
        let run = |points: &[SurfacePoint]| {
            let start = Instant::now();
            let found = black_box(work(black_box(points)));
            (start.elapsed().as_secs_f64(), found)
        };
        let found: Vec<(f64, f64)> = points.par_chunks(tile_points).map(run).collect();
        sum = found.iter().map(|tile| tile.1).sum();
        if round > 0 {
            tiles.iter_mut().zip(&found).for_each(|(tile, found)| tile.push(found.0));
        }
    }
    let seconds: f64 = tiles.iter_mut().map(|rounds| median(rounds)).sum();
    (seconds / rayon::current_num_threads() as f64, sum)
}
