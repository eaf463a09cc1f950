//! What each figure shows, and what agrees with the paper.

use crate::{
    assemble::{ray_to_cone, table},
    report::{CaseReport, ConeClass, EstimateCalibration, TrialReport},
};

pub(super) fn first() -> String {
    "The scene as a grey model under an even sky and a lamp, without and with the sky's light dimmed by the true visibility. \
     As in the paper's conference room, creases and what lies under things darken."
        .into()
}

pub(super) fn second(report: &CaseReport) -> String {
    let cones = report.trials.iter().find(|t| t.method == "cones" && t.effort == report.cones.cones);
    let bias = cones.map_or(0.0, |t| t.quality.bias);
    let side = if bias > 0.0 { "too open" } else { "too closed" };
    format!(
        "Rays are noisy where they are few and right on average; cones have no noise and are wrong by their voxels: here on average {bias:+.4}, {side}."
    )
}

pub(super) fn third(report: &CaseReport) -> String {
    let distance = report.distance.map_or("infinite".into(), |d| format!("{d:.4} world units"));
    format!(
        "{} triangles, {} surface points, AO distance {distance}, {} voxels of {:.4} along the longest side. \
         The paper names its scenes but not its cameras, its resolution or its ray length.",
        report.triangles, report.points, report.voxels, report.voxel_size
    )
}

pub(super) fn fourth(report: &CaseReport) -> String {
    let ratio = |label: &str| {
        report
            .table
            .iter()
            .find(|row| row.label == label)
            .and_then(|row| Some((row.blend_ratio?, row.paper_blend_ratio)))
    };
    let mut text = String::from("Blue is too closed, red too open, full colour at 0.3. ");
    for (label, name) in [("cones", "cones"), ("rays, as many as the blend traces", "as many rays")] {
        let Some((ours, theirs)) = ratio(label) else { continue };
        text += &format!("The blend's RMSE is {ours:.2} of that of {name}");
        text += &match theirs {
            Some(theirs) if (ours < 1.0) == (theirs < 1.0) => {
                format!("; the paper has {theirs:.2}, on the same side of 1. ")
            }
            Some(theirs) => format!("; the paper has {theirs:.2}, on the other side of 1. "),
            None => ". ".into(),
        };
    }
    text + "What the paper admits shows in the difference: corners and contacts where epsilon is small and the cone is wrong."
}

pub(super) fn fifth(report: &CaseReport) -> String {
    let blend: Vec<&TrialReport> = report.trials.iter().filter(|t| t.method == "paper").collect();
    let (Some(first), Some(last)) = (blend.first(), blend.last()) else { return String::new() };
    let (a, b) = (first.quality.rmse, last.quality.rmse);
    let mut text = format!(
        "A frame of rays is as many as the blend traces in its first. The blend goes from {a:.4} to {b:.4} in {} frames: its bias does not \
         average out. ",
        last.effort
    );
    let slopes: Vec<String> =
        [("rays", "Sobol"), ("rays-stratified", "stratified"), ("rays-random", "plain random")]
            .into_iter()
            .filter_map(|(method, name)| {
                Some(format!("{name} rays with the power {:.2} of their number", slope(report, method)?))
            })
            .collect();
    if !slopes.is_empty() {
        text += &format!("As the paper found, rays go on falling: {}.", slopes.join(", "));
    }
    text
}

/// By which power of its rays a method's RMSE falls, over the upper half of its curve.
fn slope(report: &CaseReport, method: &str) -> Option<f64> {
    let trials: Vec<&TrialReport> = report.trials.iter().filter(|t| t.method == method).collect();
    let (a, b) = (trials.get(trials.len() / 2)?, trials.last()?);
    let slope = (b.quality.rmse / a.quality.rmse).ln() / (b.rays / a.rays).ln();
    slope.is_finite().then_some(slope)
}

pub(super) fn sixth(alpha: f64, rays: f64, most: f32) -> String {
    format!(
        "As in the paper, dark is where rays are used: outlines, contacts and fine detail, while open surfaces are left to cones. \
         Mean alpha {alpha:.3}; {rays:.1} of at most {most:.0} rays a point."
    )
}

pub(super) fn by_time(report: &CaseReport) -> String {
    let mut text = ray_to_cone::explain(report);
    let best = report
        .equal_time
        .iter()
        .filter_map(|e| Some((e.timing.rmse_ratio?, e)))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((ratio, best)) = best {
        let label = table::find(&report.trials, &best.method, best.effort).map_or("", |t| &t.label);
        text += &format!(
            " Against rays in the same time the best is {} with {label}: RMSE {ratio:.2} of theirs.",
            best.method
        );
    }
    text
}

pub(super) fn builds(report: &CaseReport) -> String {
    format!(
        "The BVH took {:.2} s, the octree {:.2} s.",
        report.timing.bvh_seconds, report.timing.octree_seconds
    )
}

pub(super) fn bias(report: &CaseReport) -> String {
    let floor =
        report.truth.error / report.truth.mean_visibility.max(1e-9) / (report.points.max(1) as f64).sqrt();
    format!(
        "Mean signed error over mean visibility, its size; the sign is in the table of trials. A method that converges goes on \
         falling; one that stays level has a bias that no work removes. The truth's own mean is known to about {floor:.1e}."
    )
}

pub(super) fn cone_calibration(report: &CaseReport) -> String {
    let cones = &report.cones;
    let share = |class| cones.classes.iter().find(|c| c.class == class).map_or(0.0, |c| 100.0 * c.share);
    format!(
        "Each dot is a group of cones of about equal epsilon, by their true error from {} rays each ({} points, {} cones each). On the diagonal \
         epsilon would be the error. Rank correlation {:.2}, with the error of marching itself {:.2}. {:.0} % of cones are certified open, {:.0} % open as marched, {:.0} % closed, \
         {:.0} % trusted, {:.0} % refined by rays. Cones of epsilon 0 that err are those that no blend can mend.",
        cones.rays,
        cones.points,
        cones.cones,
        cones.rank_correlation,
        cones.rank_correlation_marching,
        share(ConeClass::Certified),
        share(ConeClass::Open),
        share(ConeClass::Closed),
        share(ConeClass::Trusted),
        share(ConeClass::Refined),
    )
}

pub(super) fn estimate_calibration(report: &CaseReport) -> String {
    let last = |c: &&EstimateCalibration| {
        !report.calibration.iter().any(|other| other.method == c.method && other.effort > c.effort)
    };
    let ratios: Vec<String> = report
        .calibration
        .iter()
        .filter(last)
        .map(|c| format!("{} with {}: {:.2}", c.method, c.label, c.ratio))
        .collect();
    format!(
        "Deciles of expected error against the true error in each. Above the diagonal a method promises too much, below it too little. \
         Expected over true RMSE of the image: {}.",
        ratios.join("; ")
    )
}
