//! Work kept for later: what whole rounds found and what an interrupted one did, with marks of what it belongs to.
//!
//! | bytes | what |
//! | --- | --- |
//! | 8 | `conrayhy` |
//! | 4 | version |
//! | 16 each | fingerprints: scene, points, distance, what rays count and where they go, seed |
//! | 8 | places |
//! | 4, 4, 4, 1, 1, 8 | units of the lattice, how units and bundles err, started, evenly, rays in no tally |
//! | 8 | rounds before work began anew, plus 1; 0 where it did not |
//! | 8 + 24 n | rounds: rays a point, expected RMSE, seconds |
//! | 28 each | tallies: units, sum, two variances, open direction |
//! | 1, 28 each | whether a round was interrupted, and its tallies |
//! | 16 | XXH3 checksum, 128 bits, of all bytes before it |
//!
//! All numbers are little-endian. No length in the file is believed: the points say how long it is.

mod bytes;

use super::{Hybrid, tallies::FULL, units_in, weighing::Weighed};
use crate::{AoPlan, Choice, Round};
use bytes::{Cursor, TALLY_BYTES, put};
use conray_bvh::Level;
use conray_core::{Feed, Fingerprint, SurfacePoint};
use std::io::{self, Write};
use thiserror::Error;
use twox_hash::XxHash3_128;

const MAGIC: &[u8; 8] = b"conrayhy";
/// Raised whenever the layout changes.
const VERSION: u32 = 2;
const CHECKSUM_BYTES: usize = 16;
const ROUND_BYTES: usize = 24;
/// More rounds than any work takes.
const MOST_ROUNDS: usize = 10_000;
/// Bytes besides rounds and tallies, and some to spare.
const HEAD_BYTES: usize = 256;

/// Why kept work cannot be gone on with.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum StateError {
    /// It is no kept work of this version, cut short or damaged.
    #[error("{0}; delete it to begin anew")]
    Damaged(String),
    /// It is work on something else.
    #[error("it is work with another {0}; ask for the same, or delete it to begin anew")]
    Other(&'static str),
}

fn damaged(what: &str) -> StateError {
    StateError::Damaged(what.into())
}

/// All that results depend on, by the names that people know it by.
fn belongs_to(
    plan: &AoPlan,
    scene: Fingerprint,
    points: &[SurfacePoint],
) -> [(&'static str, Fingerprint); 5] {
    let seen = |feed: &mut Feed| {
        feed.points(points);
        points.iter().for_each(|point| feed.f32(point.footprint));
    };
    let look = |feed: &mut Feed| {
        feed.text(&plan.falloff.to_string());
        feed.f32(plan.reach);
        feed.f32(plan.bias);
    };
    [
        ("scene or --alpha", scene),
        ("view or --size", Fingerprint::of(seen)),
        ("--distance", Fingerprint::of(|feed| feed.f32(plan.distance))),
        ("--falloff, --spread or --bias-angle", Fingerprint::of(look)),
        ("--seed", Fingerprint::of(|feed| feed.u32(plan.seed))),
    ]
}

impl Hybrid {
    /// Writes all that is needed to go on: [`Hybrid::load`] and the same budget then give the bits of unbroken work, wherever it
    /// was stopped. `scene` stands for what occludes.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn save(
        &self,
        plan: &AoPlan,
        scene: Fingerprint,
        points: &[SurfacePoint],
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        for (_, fingerprint) in belongs_to(plan, scene, points) {
            bytes.extend(fingerprint.to_le_bytes());
        }
        bytes.extend((self.tallies.len() as u64).to_le_bytes());
        bytes.extend(self.rays.first.to_le_bytes());
        bytes.extend(self.rays.unit.to_le_bytes());
        bytes.extend(self.rays.full.to_le_bytes());
        bytes.extend([u8::from(self.started), u8::from(self.choice == Choice::Evenly)]);
        bytes.extend(self.pilot_rays.to_le_bytes());
        bytes.extend(self.begun_anew.map_or(0, |rounds| rounds as u64 + 1).to_le_bytes());
        bytes.extend((self.rounds.len() as u64).to_le_bytes());
        for round in &self.rounds {
            for value in [round.rays_per_point, round.expected_rmse, round.seconds] {
                bytes.extend(value.to_le_bytes());
            }
        }
        put(&mut bytes, &self.tallies);
        bytes.push(u8::from(!self.unfinished.is_empty()));
        put(&mut bytes, &self.unfinished);
        let checksum = XxHash3_128::oneshot(&bytes);
        bytes.extend(checksum.to_le_bytes());
        out.write_all(&bytes)
    }

    /// Most bytes that kept work on so many points takes: read no more than that, and one.
    pub fn most_saved_bytes(&self) -> u64 {
        (HEAD_BYTES + MOST_ROUNDS * ROUND_BYTES + 2 * TALLY_BYTES * self.tallies.len()) as u64
    }

    /// Takes up kept work in place of this, which must be without a ray yet.
    ///
    /// # Errors
    /// Bytes that are no kept work, or work on something else.
    pub fn load(
        mut self,
        plan: &AoPlan,
        scene: Fingerprint,
        points: &[SurfacePoint],
        level: Level,
        bytes: &[u8],
    ) -> Result<Self, StateError> {
        let mut head = Cursor(bytes);
        if head.array::<8>()? != *MAGIC {
            return Err(damaged("it is no kept work of this program"));
        }
        // The version goes first: another one may keep its checksum elsewhere.
        let version = u32::from_le_bytes(head.array()?);
        if version != VERSION {
            return Err(StateError::Damaged(format!(
                "it has version {version} where this program reads {VERSION}"
            )));
        }
        let end = bytes.len().checked_sub(CHECKSUM_BYTES).ok_or_else(bytes::cut_short)?;
        let (content, checksum) = bytes.split_at(end);
        if XxHash3_128::oneshot(content).to_le_bytes() != checksum {
            return Err(damaged("its checksum does not match: it is damaged or cut short"));
        }
        let mut rest = Cursor(content);
        rest.take(MAGIC.len() + size_of::<u32>())?;
        for (name, expected) in belongs_to(plan, scene, points) {
            if Fingerprint::from_le_bytes(rest.array()?) != expected {
                return Err(StateError::Other(name));
            }
        }
        self.read(&mut rest)?;
        if !rest.is_empty() {
            return Err(damaged("it goes on after its end"));
        }
        if self.rays_of_rounds() > 0 || !self.unfinished.is_empty() {
            self.weigh(&None, level, Weighed::Shown);
        }
        Ok(self)
    }

    fn read(&mut self, rest: &mut Cursor<'_>) -> Result<(), StateError> {
        if u64::from_le_bytes(rest.array()?) != self.tallies.len() as u64 {
            return Err(damaged("its size is not that of the image"));
        }
        self.rays.first = u32::from_le_bytes(rest.array()?);
        if ![1, FULL].contains(&self.rays.first) {
            return Err(damaged("its lattice is none that there is"));
        }
        let factors: [f32; 2] = [rest.array()?, rest.array()?].map(f32::from_le_bytes);
        if factors.iter().any(|factor| !factor.is_finite() || *factor < 0.0) {
            return Err(damaged("it says of rays what cannot be"));
        }
        [self.rays.unit, self.rays.full] = factors;
        let [started, evenly] = rest.array()?;
        self.started = started != 0;
        self.choice = if evenly == 0 { Choice::Hybrid } else { Choice::Evenly };
        self.pilot_rays = u64::from_le_bytes(rest.array()?);
        let [begun_anew, rounds] = [rest.array()?, rest.array()?].map(u64::from_le_bytes);
        if rounds > MOST_ROUNDS as u64 || begun_anew > rounds + 1 {
            return Err(damaged("it has too many rounds"));
        }
        self.begun_anew = begun_anew.checked_sub(1).map(|rounds| rounds as usize);
        for _ in 0..rounds {
            let [rays_per_point, expected_rmse, seconds] =
                [rest.array()?, rest.array()?, rest.array()?].map(f64::from_le_bytes);
            self.rounds.push(Round { rays_per_point, expected_rmse, seconds });
        }
        let places = self.tallies.len();
        self.tallies = rest.tallies(places)?;
        self.units = units_in(&self.tallies);
        let [interrupted] = rest.array()?;
        self.unfinished = if interrupted == 0 { Vec::new() } else { rest.tallies(places)? };
        Ok(())
    }
}
