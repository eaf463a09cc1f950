//! A search for a truth, as far as it has come: the mean of each half, and what every doubling said.

use super::{LEAST_RAYS, Truth};
use crate::{Fingerprint, StudyError, kept::Kept, kept::damaged};
use serde_json::json;
use std::{collections::BTreeMap, ops::Range, path::Path};

/// What kept truths are called in their files.
const KIND: &str = "truth";

/// Names of the arrays of each half: the means in single precision, and what that leaves.
const HALVES: [[&str; 2]; 2] = [["half-a", "half-a-rest"], ["half-b", "half-b-rest"]];

/// As far as a search has come.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    halves: [Half; 2],
    /// What was known after [`LEAST_RAYS`], twice, four times as many rays over both halves, and so on.
    rungs: Vec<Rung>,
}

/// Half of the rays.
#[derive(Clone, Debug, PartialEq)]
struct Half {
    /// Rays per point.
    rays: u32,
    /// Mean visibility of each point, rounded to the sum of two single-precision numbers so that a file holds it.
    means: Vec<f64>,
}

/// What was known when both halves had as many rays.
#[derive(Clone, Debug, PartialEq)]
struct Rung {
    /// In single precision, so that a file holds it.
    error: f32,
    visibility: Vec<f32>,
}

impl State {
    pub(super) fn new(points: usize) -> Self {
        let half = Half { rays: 0, means: vec![0.0; points] };
        Self { halves: [half.clone(), half], rungs: Vec::new() }
    }

    /// The first rung from `least` rays on whose error is at most that, or the one of `most` rays.
    pub(super) fn answer(&self, error: f64, least: u32, most: u32) -> Option<Truth> {
        let rays = (0..).map(|k| LEAST_RAYS << k);
        let enough =
            |(rung, rays): &(&Rung, u32)| *rays >= least && (f64::from(rung.error) <= error || *rays >= most);
        self.rungs.iter().zip(rays).find(enough).map(|(rung, rays)| Truth {
            visibility: rung.visibility.clone(),
            rays,
            error: rung.error.into(),
        })
    }

    /// Rays per point so far, over both halves.
    pub(super) fn rays(&self) -> u32 {
        self.halves.iter().map(|half| half.rays).sum()
    }

    /// Rays per point that reaching an error will take, over both halves, as far as can be told: at least the next
    /// rung, at most `most`.
    ///
    /// With scrambled nets and edges in the plane the error falls with about the 3/4th power of the rays: He and Wang,
    /// "On the Convergence Rate of Randomized Quasi-Monte Carlo for Discontinuous Functions", 2015.
    pub(super) fn foreseen_rays(&self, error: f64, most: u32) -> u32 {
        let next = 2 * self.rung_rays();
        let last = self.rungs.last().map_or(f64::INFINITY, |rung| rung.error.into());
        let factor = (last / error).powf(4.0 / 3.0);
        let foreseen = f64::from(next / 2) * factor;
        // The conversion holds infinity at the largest integer.
        (foreseen as u32).clamp(next.min(most), most)
    }

    /// Rays of each half at the next rung.
    fn rung_rays(&self) -> u32 {
        (LEAST_RAYS / 2) << self.rungs.len()
    }

    /// Which half is due, and which of its rays, at most that many.
    pub(super) fn next_slice(&self, most: u32) -> (usize, Range<u32>) {
        let half = usize::from(self.halves[1].rays < self.halves[0].rays);
        let start = self.halves[half].rays;
        (half, start..self.rung_rays().min(start + most))
    }

    /// Adds a slice to a half; where both halves are complete, a rung.
    pub(super) fn add(&mut self, half: usize, rays: u32, visibility: impl Iterator<Item = f32>) {
        let Half { rays: before, means } = &mut self.halves[half];
        let share = f64::from(rays) / f64::from(*before + rays);
        for (mean, new) in means.iter_mut().zip(visibility) {
            *mean = join(split(*mean + share * (f64::from(new) - *mean)));
        }
        *before += rays;
        if self.halves.iter().all(|half| half.rays == self.rung_rays()) {
            self.rungs.push(self.rung());
        }
    }

    /// Mean of the halves, and half the root mean square of their difference.
    fn rung(&self) -> Rung {
        let [a, b] = &self.halves;
        let pairs = || a.means.iter().zip(&b.means);
        let squares: f64 = pairs().map(|(a, b)| (a - b).powi(2)).sum();
        let error = 0.5 * (squares / a.means.len().max(1) as f64).sqrt();
        Rung { error: error as f32, visibility: pairs().map(|(a, b)| (0.5 * (a + b)) as f32).collect() }
    }

    /// Reads what an earlier search kept; `None` where there is none.
    pub(super) fn read(
        path: &Path,
        fingerprint: Fingerprint,
        points: usize,
    ) -> Result<Option<Self>, StudyError> {
        let Some(kept) = Kept::read(path, KIND, fingerprint)? else { return Ok(None) };
        let state = Self::from_kept(kept, points);
        state.map(Some).ok_or_else(|| damaged(path, "its numbers do not belong together"))
    }

    pub(super) fn write(&self, path: &Path, fingerprint: Fingerprint) -> Result<(), StudyError> {
        let mut arrays = BTreeMap::new();
        for (half, [name, rest]) in self.halves.iter().zip(HALVES) {
            let (values, rests) = half.means.iter().map(|&mean| split(mean)).unzip();
            arrays.insert(name.into(), values);
            arrays.insert(rest.into(), rests);
        }
        for (k, rung) in self.rungs.iter().enumerate() {
            arrays.insert(rung_name(k), rung.visibility.clone());
        }
        arrays.insert("errors".into(), self.rungs.iter().map(|rung| rung.error).collect());
        let header = json!({ "rays": [self.halves[0].rays, self.halves[1].rays] });
        Kept { header, arrays }.write(path, KIND, fingerprint)
    }

    /// `None` where something is missing or does not fit.
    fn from_kept(mut kept: Kept, points: usize) -> Option<Self> {
        let mut array = |name: &str| kept.arrays.remove(name);
        let rungs = array("errors")?
            .into_iter()
            .enumerate()
            .map(|(k, error)| Some(Rung { error, visibility: array(&rung_name(k))? }))
            .collect::<Option<Vec<_>>>()?;
        let mut half = |index: usize| {
            let [values, rests] = HALVES[index].map(&mut array);
            let means = values?.into_iter().zip(rests?).map(join).collect();
            Some(Half { rays: u32::try_from(kept.header["rays"][index].as_u64()?).ok()?, means })
        };
        let state = Self { halves: [half(0)?, half(1)?], rungs };
        state.is_sound(points).then_some(state)
    }

    /// Every array has its length, and the halves stand between the last rung and the next.
    fn is_sound(&self, points: usize) -> bool {
        if self.rungs.len() > (u32::BITS - LEAST_RAYS.ilog2() - 1) as usize {
            return false;
        }
        let next = self.rung_rays();
        let last = if self.rungs.is_empty() { 0 } else { next / 2 };
        let [a, b] = [self.halves[0].rays, self.halves[1].rays];
        self.rungs.iter().all(|rung| rung.visibility.len() == points)
            && self.halves.iter().all(|half| half.means.len() == points)
            && (last..=next).contains(&a)
            && (last..next).contains(&b)
    }
}

fn rung_name(k: usize) -> String {
    format!("visibility-{}", u64::from(LEAST_RAYS) << k)
}

/// A number as single precision and what that leaves.
fn split(value: f64) -> (f32, f32) {
    let near = value as f32;
    (near, (value - f64::from(near)) as f32)
}

fn join((near, rest): (f32, f32)) -> f64 {
    f64::from(near) + f64::from(rest)
}

#[cfg(test)]
mod tests;
