//! The seam between who asks for AO and who computes it.

use crate::TargetError;
use conray_core::{Estimate, Layout, SurfacePoint};

/// Something that asks for AO at surface points and receives estimates.
pub trait Target {
    /// What the estimates become: image layers, values per vertex, ...
    type Output;

    /// Where AO is asked for. The order is the target's own and never changes.
    fn points(&self) -> &[SurfacePoint];

    /// How the points lie to each other.
    fn layout(&self) -> Layout {
        Layout::Scattered
    }

    /// Puts the estimates, one per point in the order of [`Target::points`], where they belong.
    ///
    /// Fails with [`TargetError::EstimateCount`] unless there is exactly one estimate per point.
    fn resolve(&self, estimates: &[Estimate]) -> Result<Self::Output, TargetError>;
}

/// Points in no order: the estimates are what they become.
impl Target for Vec<SurfacePoint> {
    type Output = Vec<Estimate>;

    fn points(&self) -> &[SurfacePoint] {
        self
    }

    fn resolve(&self, estimates: &[Estimate]) -> Result<Vec<Estimate>, TargetError> {
        check_count(self, estimates)?;
        Ok(estimates.to_vec())
    }
}

/// The check that every [`Target::resolve`] begins with.
pub(crate) fn check_count(points: &[SurfacePoint], estimates: &[Estimate]) -> Result<(), TargetError> {
    let (expected, found) = (points.len(), estimates.len());
    if expected == found { Ok(()) } else { Err(TargetError::EstimateCount { expected, found }) }
}
