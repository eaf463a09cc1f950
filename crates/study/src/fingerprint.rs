//! What the truth of a case depends on, as a fingerprint.

use crate::{Case, StudyError};
use conray::Method;
pub use conray_core::{Feed, Fingerprint};

/// The fingerprint of all that the truth of a case depends on: what occludes, the surface points, the AO distance
/// in world units, the falloff, what opacity means, and the seed. Names, views and methods do not count.
///
/// # Errors
/// Settings out of range.
pub fn fingerprint_of_case(case: &Case) -> Result<Fingerprint, StudyError> {
    let settings = conray::AoSettings { method: Method::Rays, ..case.settings.clone() };
    let plan = case.session.plan_for(&settings)?;
    Ok(Fingerprint::of(|feed| {
        feed.text("case 1");
        feed.geometry(case.session.geometry());
        feed.points(case.points());
        feed.f32(plan.distance);
        feed.text(&plan.falloff.to_string());
        feed.text(match case.settings.alpha {
            conray::Alpha::Material => "material",
            conray::Alpha::Opaque => "opaque",
        });
        feed.u32(plan.seed);
    }))
}

#[cfg(test)]
mod tests;
