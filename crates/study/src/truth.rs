//! The truth of a case: visibility by very many rays, with its own error found, not assumed.
//!
//! Two halves of the rays are independent: each is a set of Owen-scrambled Sobol points of its own seed. With A and B the
//! means of the halves, E[(A - B)^2] is twice the variance of one half and four times that of their mean, so
//! RMSE(A, B) / 2 is the error of the mean of both. It holds whatever the rays inside a half have to do with each other; a
//! variance taken inside one Sobol sequence would not tell.
//!
//! Rays double until the error is small enough. Each doubling is kept, so a result depends on the case and the options
//! alone and not on what an earlier search left behind; work goes on where an earlier search stopped.

mod state;

use crate::{Case, Fingerprint, StudyError, fingerprint_of_case, kept};
use conray::{AoSettings, Control, Method, Sampling, limits, target::check_writable};
use conray_core::hash_u32;
use state::State;
use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

/// Visibility of every point of a case, as good as it was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Visibility of each point, in the case's order.
    pub visibility: Vec<f32>,
    /// Rays per point, over both halves.
    pub rays: u32,
    /// Root mean square error over the points, as the difference of the halves tells it.
    pub error: f64,
}

/// How good a truth is to be.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthOptions {
    /// Root mean square error wanted.
    pub error: f64,
    /// Rays per point at most, over both halves; counts as the power of two at or below it, at least [`LEAST_RAYS`].
    pub max_rays: u32,
    /// Rays per point at least, over both halves; counts as the power of two at or above it, if `max_rays` allows.
    pub min_rays: u32,
    /// Where truths are kept; `None` keeps none.
    pub folder: Option<PathBuf>,
}

/// Rays per point of the first rung, over both halves.
pub const LEAST_RAYS: u32 = 32;

/// Rays of a slice: an interruption loses no more.
const SLICE_RAYS: u64 = 1 << 26;

/// Rays per point of a slice at most: sums in single precision stay good.
const SLICE_RAYS_PER_POINT: u32 = 4096;

/// What the seeds of the halves are made from: digits of pi.
const SEED_SALT: u32 = 0x243f_6a88;

impl Truth {
    /// Finds the truth of a case: at the fewest rays, doubling, whose error is at most that wanted, or at the most rays.
    ///
    /// `control` stops it; `progress` is told rays done and rays in all as far as can be foreseen.
    ///
    /// # Errors
    /// Settings out of range; a kept file that is damaged; a folder that cannot be written, before any ray;
    /// [`StudyError::Interrupted`] after keeping what is done.
    pub fn find(
        case: &Case,
        options: &TruthOptions,
        control: Control<'_>,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> Result<Self, StudyError> {
        find_with_seeds(case, options, half_seeds(case.settings.seed), control, progress)
    }
}

/// Seeds of the two halves, other than each other's and the judged runs'.
fn half_seeds(judged: u32) -> [u32; 2] {
    // The hash is a permutation, so different inputs never agree.
    let mut seeds = (0..).map(|i| hash_u32(judged ^ SEED_SALT ^ i)).filter(|&seed| seed != judged);
    [(); 2].map(|()| seeds.next().unwrap_or(SEED_SALT))
}

/// As [`Truth::find`]; the seeds must differ, or the error found is 0.
fn find_with_seeds(
    case: &Case,
    options: &TruthOptions,
    seeds: [u32; 2],
    control: Control<'_>,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Truth, StudyError> {
    let points = case.points().len();
    let slice = slice_rays(points);
    let case_fingerprint = fingerprint_of_case(case)?;
    let fingerprint = Fingerprint::of(|feed| {
        feed.fingerprint(case_fingerprint);
        seeds.into_iter().chain([slice]).for_each(|value| feed.u32(value));
    });
    let file = options.folder.as_ref().map(|folder| folder.join(format!("truth-{fingerprint}.kept")));
    let kept = match &file {
        Some(path) => State::read(path, fingerprint, points)?,
        None => None,
    };
    let mut state = kept.unwrap_or_else(|| State::new(points));
    let [least, most] = rungs(options);
    if let Some(truth) = state.answer(options.error, least, most) {
        return Ok(truth);
    }
    if let Some(path) = &file {
        prepare(path)?;
    }
    loop {
        let (half, samples) = state.next_slice(slice);
        let now = samples.end - samples.start;
        let total = u64::from(state.foreseen_rays(options.error, most)) * points as u64;
        let done = AtomicU64::new(u64::from(state.rays()) * points as u64);
        let tell = |points: usize| {
            let new = points as u64 * u64::from(now);
            progress(done.fetch_add(new, Ordering::Relaxed) + new, total);
        };
        let settings = AoSettings {
            method: Method::Rays,
            sampling: Sampling::Sobol,
            seed: seeds[half],
            ..case.settings.clone()
        };
        let plan = case.session.plan_for(&settings)?;
        let slice_control = Control { progress: &tell, ..control };
        let estimates = case.session.estimate_plan(&plan, samples, case.points(), slice_control)?;
        if control.is_cancelled() {
            // Every slice before this one is kept.
            return Err(StudyError::Interrupted);
        }
        state.add(half, now, estimates.iter().map(|e| e.visibility));
        if let Some(path) = &file {
            state.write(path, fingerprint)?;
        }
        if let Some(truth) = state.answer(options.error, least, most) {
            return Ok(truth);
        }
    }
}

/// The fewest and the most rays of the options, as powers of two over both halves.
fn rungs(options: &TruthOptions) -> [u32; 2] {
    let most = 1 << options.max_rays.clamp(LEAST_RAYS, 2 * limits::RAYS.end()).ilog2();
    [options.min_rays.clamp(LEAST_RAYS, most).next_power_of_two(), most]
}

/// Rays per point of a slice: a power of two that depends on the number of points alone, so that an interrupted search
/// adds up the same slices as an unbroken one.
fn slice_rays(points: usize) -> u32 {
    let rays = SLICE_RAYS / (points as u64).max(1);
    1 << rays.clamp(1, SLICE_RAYS_PER_POINT.into()).ilog2()
}

/// Makes the folder and finds out whether the file can be written, before any work.
fn prepare(path: &Path) -> Result<(), StudyError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)
            .map_err(|e| StudyError::Output { path: folder.into(), reason: e.to_string() })?;
    }
    check_writable(path).map_err(|e| kept::output(path, e))
}

#[cfg(test)]
mod tests;
