//! The whole of a vertex bake.

use super::{samples::VertexTarget, values::VertexValues};
use crate::{
    Apart, Facing,
    answers::{Answers, Asked, mark_stopped},
    buried::mostly_outside,
};
use conray::{Budget, Control, Error, Session, Work};
use conray_core::Estimate;
use conray_target::Target;
use std::path::Path;

/// Values, and how they came about.
#[derive(Clone, Debug)]
pub struct VertexBake {
    /// One a slot.
    pub values: VertexValues,
    /// Points inside other geometry, which count for nothing.
    pub buried: u64,
    /// What the points took, object by object where these stand apart.
    pub parts: Vec<Work>,
}

/// Bakes values of vertices within a budget; the work is kept in the folder `state`, to go on with, where there is one: only for method `hybrid`. Where objects stand `apart`, points of other instances count for nothing; `facing` is that of the target's points.
///
/// # Errors
/// What the backend lacks for the plan.
pub fn bake_vertices(
    session: &Session,
    apart: &[Apart],
    target: &VertexTarget,
    facing: &Facing,
    budget: Budget,
    control: Control<'_>,
    state: Option<&Path>,
) -> Result<VertexBake, Error> {
    let instances = target.instances();
    let asked = Asked { session, apart, looks_inside: facing.inside };
    let kept = state.map(|folder| folder.join("vertices.state"));
    let Answers { mut estimates, mut inside, mut works } =
        asked.answers(target, &instances, budget, control, kept.as_deref())?;
    mark_stopped(&mut works, control);
    mostly_outside(&mut inside, &instances);
    for (estimate, _) in estimates.iter_mut().zip(&inside).filter(|(_, inside)| **inside) {
        *estimate = Estimate::PENDING;
    }
    let buried = inside.iter().filter(|inside| **inside).count() as u64;
    let values = session.install(|| target.resolve(&estimates))?;
    Ok(VertexBake { values, buried, parts: works })
}
