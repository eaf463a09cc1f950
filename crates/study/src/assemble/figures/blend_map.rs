//! What the published blend does at every point: where it trusts cones.

use crate::{Case, StudyError};
use conray::{AoSettings, ConeViews, Method};
use rayon::prelude::*;

/// The blend at one point, summed over its cones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blend {
    /// Visibility that comes from cones alone: weights times alpha times what was marched.
    pub(super) by_cones: f32,
    /// Mean share of the cones.
    pub(super) alpha: f32,
    /// Rays asked for.
    pub(super) rays: u32,
}

/// The blend of every point, with the study's constants.
pub(super) fn map(case: &Case) -> Result<Vec<Blend>, StudyError> {
    let plan = case.session.plan_for(&AoSettings { method: Method::Paper, ..case.settings.clone() })?;
    let Some(octree) = case.session.octree() else { return Ok(Vec::new()) };
    let views = ConeViews::new(&plan, octree);
    let blend = |point| {
        views.at(point).fold(Blend::default(), |sum, view| {
            let alpha = if view.rays > 0 { view.alpha } else { 1.0 };
            Blend {
                by_cones: sum.by_cones + view.cone.weight * alpha * view.visibility,
                alpha: sum.alpha + view.cone.weight * alpha,
                rays: sum.rays + view.rays,
            }
        })
    };
    Ok(case.session.install(|| case.points().par_iter().map(blend).collect()))
}
