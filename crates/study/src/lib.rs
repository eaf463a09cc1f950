//! The study: estimators of ambient occlusion compared on the same points, against the same truth, in one run.
//!
//! ```text
//! scene, view -> Case -> Truth (kept on disk)
//!                  |
//! Contender x budget -> Trial (answers, interleaved timings) -> Report -> report.json, curves.csv, pictures, report.html
//! ```
//!
//! - A [`Case`] is a scene seen from one view, with its BVH and octree.
//! - A [`Contender`] turns a case and an amount of work into visibilities. A new method joins by implementing that trait.
//! - [`Report`] holds every number; all that depends on the clock is under members named `timing`, so that two runs
//!   with one seed agree in all else.
//! - [`write_report`] turns a report and its pictures into files; the page is a view of the report and knows nothing more.

// The fixture names the crate as its users do, so that an example can share it.
#[cfg(test)]
extern crate self as conray_study;

mod assemble;
mod atrous;
mod case;
mod contender;
mod contenders;
mod csv;
mod curve;
mod error;
mod fingerprint;
#[cfg(test)]
mod fixture;
mod kept;
mod machine;
mod meter;
mod oidn;
mod options;
mod page;
pub mod picture;
mod pilot;
mod plots;
pub mod quality;
pub mod report;
mod search;
mod study;
mod summary;
mod svg;
#[cfg(test)]
mod testing;
mod trials;
pub mod truth;
mod write;

pub use case::{Case, Place};
pub use contender::{Answer, Contender, Effort, Needs, Preparation};
pub use error::StudyError;
pub use fingerprint::{Feed, Fingerprint, fingerprint_of_case};
pub use kept::Kept;
pub use options::{StudyOptions, StudyScene};
pub use pilot::{Pilot, PilotCone, PilotPoint};
pub use report::Report;
pub use study::{Observer, Pictures, Progress, run};
pub use summary::summary;
pub use truth::{Truth, TruthOptions};
pub use write::{check_folder, schema, write_report};
