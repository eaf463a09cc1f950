//! The waist of conray: surface points in, estimates out.

use crate::{AoPlan, HybridDevice};
use conray_core::{Estimate, SurfacePoint};
use std::{
    ops::Range,
    sync::atomic::{AtomicBool, Ordering},
};
use thiserror::Error;

/// Why a backend could not carry out a plan.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BackendError {
    /// The method marches cones and there is no octree.
    #[error("method {0} needs an octree, and none was built")]
    NoOctree(crate::Method),
    /// A device does not do what is asked, or failed: what was estimated before stays.
    #[error("{0}")]
    Device(String),
    /// The slices differ in length.
    #[error("{points} points but room for {estimates} estimates")]
    LengthMismatch {
        /// Points asked about.
        points: usize,
        /// Places for answers.
        estimates: usize,
    },
}

impl BackendError {
    /// Refuses slices that differ in length.
    ///
    /// # Errors
    /// [`BackendError::LengthMismatch`].
    pub fn check_lengths(points: &[SurfacePoint], estimates: &[Estimate]) -> Result<(), Self> {
        let (points, estimates) = (points.len(), estimates.len());
        if points == estimates { Ok(()) } else { Err(Self::LengthMismatch { points, estimates }) }
    }
}

/// How a caller follows and stops long work.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Set to stop: points not reached stay [`Estimate::PENDING`].
    pub cancelled: &'a AtomicBool,
    /// Called from any thread with the number of points done since its last call.
    pub progress: &'a (dyn Fn(usize) + Sync),
}

impl Control<'static> {
    /// Never stops and tells nobody.
    pub fn none() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { cancelled: &NEVER, progress: &|_| {} }
    }
}

impl Control<'_> {
    /// True once the caller wants the work to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Carries out plans.
pub trait Backend: Send + Sync {
    /// Estimates every point, into the place of the same index.
    ///
    /// `samples` says which part of each point's sample sequence to use: ray indices for methods `rays` and
    /// `hybrid`, which is `rays` where points are taken one by one; frame numbers for the others. Estimates of disjoint ranges are merged by [`merge`]. The result depends on the plan,
    /// the range and each point alone, not on threads, order or neighbours. Points that are not valid
    /// ([`SurfacePoint::is_valid`]) get visibility 0 and an infinite error.
    ///
    /// # Errors
    /// What the backend lacks for the plan; then no estimate was written.
    fn estimate(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        estimates: &mut [Estimate],
        control: Control<'_>,
    ) -> Result<(), BackendError>;

    /// Where method `hybrid` has its rays traced and weighed, if that is not on the CPU.
    fn hybrid_device(&self) -> Option<&dyn HybridDevice> {
        None
    }
}

/// The estimate from `a_samples` and `b_samples` samples together, each told in `a` and `b`.
///
/// Means are weighted by samples; errors add as those of independent samples do.
pub fn merge(a: &Estimate, a_samples: u32, b: &Estimate, b_samples: u32) -> Estimate {
    if b_samples == 0 || b.is_pending() {
        return *a;
    }
    if a_samples == 0 || a.is_pending() {
        return *b;
    }
    let total = f64::from(a_samples) + f64::from(b_samples);
    let (wa, wb) = (f64::from(a_samples) / total, f64::from(b_samples) / total);
    Estimate {
        visibility: (wa * f64::from(a.visibility) + wb * f64::from(b.visibility)) as f32,
        error: (wa * f64::from(a.error)).hypot(wb * f64::from(b.error)) as f32,
        rays: a.rays.saturating_add(b.rays),
        bent: a.bent * wa as f32 + b.bent * wb as f32,
        cone: a.cone.or(b.cone),
    }
}
