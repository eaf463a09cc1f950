//! The contenders, one file each.

mod cones;
mod denoised;
mod filtered;
mod hybrid;
mod paper;
mod paper_tuned;
mod rays;
mod selection;

use crate::Contender;
use conray::Sampling;
pub(crate) use selection::{check_names, chosen, default_names};

/// Every contender, in the order of the report.
pub(crate) fn all() -> Vec<Box<dyn Contender>> {
    vec![
        Box::new(rays::Rays::new(Sampling::Sobol)),
        Box::new(rays::Rays::new(Sampling::Stratified)),
        Box::new(rays::Rays::new(Sampling::Random)),
        Box::new(filtered::Filtered::default()),
        Box::new(denoised::Denoised::default()),
        Box::new(cones::Cones),
        Box::new(paper::Paper),
        Box::new(paper_tuned::PaperTuned::default()),
        Box::new(hybrid::Hybrid),
    ]
}
