//! Why the blend wins or loses on this machine, and what it would take: the price of a cone in rays.

use super::table;
use crate::{curve, report::CaseReport};

/// The paper's claim: RMSE of the blend over that of rays on its Cornell box.
const CLAIMED: f64 = 0.80;

/// Sentences about the price of a cone; empty where blend or rays did not take part. They depend on the clock.
pub(super) fn explain(case: &CaseReport) -> String {
    let Some(blend) = table::find(&case.trials, "paper", 1) else { return String::new() };
    let Some(last) = case.trials.iter().rfind(|t| t.method == "rays") else { return String::new() };
    let points = case.points.max(1) as f64;
    let ray_us = 1e6 * last.timing.seconds / (points * last.rays);
    let cone_us = (1e6 * (blend.timing.seconds / points) - blend.rays * ray_us) / blend.cones.max(1.0);
    let mut text = format!(
        "A ray costs {ray_us:.3} microseconds here and a cone about {cone_us:.3}, as much as {:.0} rays. ",
        cone_us / ray_us
    );
    // Rays that come to the error at which the blend would be 0.80 of theirs.
    let by_count = table::rays_by_count(&case.trials);
    match curve::where_it_reaches(&by_count, blend.quality.rmse / CLAIMED) {
        Some(count) if count > blend.rays => {
            let affordable_us = (count - blend.rays) * ray_us / blend.cones.max(1.0);
            text += &format!(
                "Rays reach the blend's RMSE over {CLAIMED} with {count:.0} a point; the blend traces {:.0} and marches {:.0} cones. \
                 To win by the paper's {CLAIMED} at equal time a cone may cost {affordable_us:.3} microseconds, \
                 {:.1} times less than now.",
                blend.rays,
                blend.cones,
                cone_us / affordable_us
            );
        }
        Some(count) => {
            text += &format!(
                "Rays reach the blend's RMSE over {CLAIMED} with {count:.0} a point, fewer than the {:.0} that the blend traces: \
                 not even free cones would make it win by the paper's {CLAIMED} with these constants.",
                blend.rays
            );
        }
        None => {
            text += &format!("The blend's RMSE over {CLAIMED} is outside the curve of rays.");
        }
    }
    text
}
