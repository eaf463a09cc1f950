//! A case in a few lines of text.

use crate::report::CaseReport;

/// What was found for a case, for a terminal: its truth, then each method's least error and what it took.
pub fn summary(case: &CaseReport) -> Vec<String> {
    let truth = &case.truth;
    let mut lines = vec![format!(
        "{}: {} triangles, {} points; truth by {} rays a point, its own error {:.5} ({:.1} times under the least judged)",
        case.id, case.triangles, case.points, truth.rays, truth.error, truth.ratio
    )];
    let mut names: Vec<&str> = case.trials.iter().map(|t| &t.method[..]).collect();
    names.dedup();
    for name in names {
        let trials = || case.trials.iter().filter(|t| t.method == name);
        let Some(best) = trials().min_by(|a, b| a.quality.rmse.total_cmp(&b.quality.rmse)) else { continue };
        let against = case.equal_time.iter().find(|e| e.method == name && e.effort == best.effort);
        let ratio = against.and_then(|e| e.timing.rmse_ratio);
        lines.push(format!(
            "  {name:16} {:14} RMSE {:.4}  bias {:+.4}  FLIP {:.4}  {:8.3} s{}",
            best.label,
            best.quality.rmse,
            best.quality.bias,
            best.quality.flip,
            best.timing.seconds,
            ratio.map_or(String::new(), |r| format!("  {r:.2} of rays in the same time"))
        ));
    }
    lines
}
