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

mod case;
mod contender;
mod error;
pub mod picture;
pub mod report;

pub use case::Case;
pub use contender::{Answer, Contender, Effort, Needs, Preparation};
pub use error::StudyError;
pub use report::Report;
