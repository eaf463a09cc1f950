//! The whole of a vertex bake.

use super::{samples::VertexTarget, values::VertexValues};
use crate::{Apart, Facing, answers::Answers, buried::mostly_outside};
use conray::{Budget, Control, Error, Session, Work};
use conray_core::Estimate;
use conray_target::Target;

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

/// Bakes values of vertices within a budget. Where objects stand `apart`, points of other instances count for nothing; `facing` is that of the target's points.
///
/// # Errors
/// What the backend lacks for the plan.
pub fn bake_vertices(
    session: &Session,
    apart: &[Apart],
    target: &VertexTarget,
    facing: Facing,
    budget: Budget,
    control: Control<'_>,
) -> Result<VertexBake, Error> {
    let instances = target.instances();
    let Answers { mut estimates, mut inside, works } = match apart {
        [] => Answers::of(session, target, budget, control, facing)?,
        _ => Answers::apart(apart, target, &instances, budget, control, facing)?,
    };
    mostly_outside(&mut inside, &instances);
    for (estimate, _) in estimates.iter_mut().zip(&inside).filter(|(_, inside)| **inside) {
        *estimate = Estimate::PENDING;
    }
    let buried = inside.iter().filter(|inside| **inside).count() as u64;
    let values = session.install(|| target.resolve(&estimates))?;
    Ok(VertexBake { values, buried, parts: works })
}
