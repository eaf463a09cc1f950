//! From settings to estimates: what a person asks for, the plan made from it, and the methods that carry it out.
//!
//! ```text
//! AoSettings --validate, with the scene's bounds--> AoPlan --Backend::estimate(points)--> [Estimate]
//! ```
//!
//! A [`Backend`] is a slice of surface points in and a slice of estimates out. [`CpuBackend`] carries out every
//! [`Method`] with a BVH and, where the method marches cones, an octree.

mod backend;
mod budget;
mod cone_view;
mod cpu;
mod distance;
mod epsilon;
mod explanation;
mod hybrid;
mod meter;
mod methods;
mod plan;
mod settings;

pub use backend::{Backend, BackendError, Control, merge};
pub use budget::{Budget, Ended, HARDLY_SEEN};
pub use cone_view::{ConeView, ConeViews};
pub use conray_bvh::Level;
pub use cpu::CpuBackend;
pub use distance::{AUTO_DISTANCE_SHARE, Distance};
pub use epsilon::Epsilon;
pub use explanation::{Choice, Explanation, Round};
pub use hybrid::{
    Batch, BatchFound, Hybrid, HybridConstants, HybridDevice, Known, PlaceTally, PlaceWeigher, Places,
    RayErrors, StateError, UnitFound,
};
pub use meter::{Meter, PROGRESS_UNITS};
pub use methods::{BlendAnswers, ConeAnswers, RayTally};
pub use plan::AoPlan;
pub use settings::{Alpha, AoSettings, Method, Sampling, SettingsError, limits};
