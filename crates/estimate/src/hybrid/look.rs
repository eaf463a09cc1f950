//! A first look, from the lattice alone: enough to choose who gets rays next, in a small part of the time of a weighing.

use super::{
    columns::in_parts,
    pixels::Pixels,
    tallies::{Rays, Tally, UNIT},
    weigh::{Known, UNKNOWN, Weigher},
};
use conray_bvh::Level;
use rayon::prelude::*;

/// Most pixels between points of a lattice that can stand for all.
pub(super) const NEAR: u32 = 2;
/// Variance of a unit where nothing is known.
const MOST_VARIANCE: f32 = 0.25 / UNIT as f32;

/// Weighs the points of a lattice, those in the middle of squares of `step` pixels a side; every pixel is then as uncertain as that
/// of its square. No visibility is told.
pub(super) fn look(
    level: Level,
    pixels: &Pixels,
    tallies: &[Tally],
    rays: &Rays,
    step: usize,
    weigher: &mut Weigher,
) -> Known {
    let (lattice, from) = pixels.lattice(step);
    let tallies: Vec<Tally> = from.iter().map(|&at| tallies.get(at).copied().unwrap_or_default()).collect();
    let mut known = Known::default();
    weigher.weigh(level, &lattice, &tallies, rays, &mut known);
    let mut all = Known::default();
    let mut out = [&mut all.guess_error2, &mut all.unit_variance];
    out.iter_mut().for_each(|out| out.resize(pixels.len(), 0.0));
    in_parts(&mut out, pixels.stride).into_par_iter().enumerate().for_each(|(y, mut out)| {
        for x in 0..pixels.width {
            let (cx, cy) = (x / step, y / step);
            let at = cy * lattice.stride + cx;
            let told = cx < lattice.width && cy < lattice.height && lattice.is_covered(at);
            out[0][x] = if told { known.guess_error2[at] } else { UNKNOWN };
            out[1][x] = if told { known.unit_variance[at] } else { MOST_VARIANCE };
        }
    });
    // Errors of guesses are the best that can be said of errors.
    all.error2.clone_from(&all.guess_error2);
    all
}
