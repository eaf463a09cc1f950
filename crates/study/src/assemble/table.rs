//! The paper's Table 1 beside ours, and every method against rays at equal time.

use crate::{
    curve,
    report::{CaseReport, EqualTime, EqualTimeTiming, TableRow, TableTiming, TrialReport},
};

/// RMSE and milliseconds of the paper's Table 1.
struct Published {
    blend: (f64, f64),
    cones: (f64, f64),
    rays: (f64, f64),
}

/// Podee, Dobashi, Yamamoto, Table 1, for the scenes that the paper shows.
fn published(scene: &str) -> Option<Published> {
    let scene = scene.to_ascii_lowercase();
    if scene.contains("sponza") {
        let (blend, cones, rays) = ((0.52953, 285.0), (0.79895, 63.0), (0.47633, 316.0));
        Some(Published { blend, cones, rays })
    } else if scene.starts_with("cornell") {
        let (blend, cones, rays) = ((0.22815, 60.0), (0.34017, 30.0), (0.28343, 66.0));
        Some(Published { blend, cones, rays })
    } else {
        None
    }
}

pub(super) fn find<'a>(trials: &'a [TrialReport], method: &str, effort: u32) -> Option<&'a TrialReport> {
    trials.iter().find(|t| t.method == method && t.effort == effort)
}

/// RMSE of `rays` by rays per point.
pub(super) fn rays_by_count(trials: &[TrialReport]) -> Vec<(f64, f64)> {
    trials.iter().filter(|t| t.method == "rays").map(|t| (t.rays, t.quality.rmse)).collect()
}

/// RMSE of a method by seconds of estimation.
pub(super) fn by_time(trials: &[TrialReport], method: &str) -> Vec<(f64, f64)> {
    trials.iter().filter(|t| t.method == method).map(|t| (t.timing.seconds, t.quality.rmse)).collect()
}

/// The rows, as far as the methods took part: blend, cones, rays as many as the blend's, rays in the blend's time.
pub(super) fn rows(case: &CaseReport) -> Vec<TableRow> {
    let trials = &case.trials;
    let Some(blend) = find(trials, "paper", 1) else { return Vec::new() };
    let theirs = published(&case.scene);
    let their = |pick: fn(&Published) -> (f64, f64)| theirs.as_ref().map(pick);
    let row =
        |method: &str, label: &str, rays, rmse: Option<f64>, paper: Option<(f64, f64)>, timing| TableRow {
            method: method.into(),
            label: label.into(),
            rays,
            rmse,
            blend_ratio: rmse.map(|rmse| blend.quality.rmse / rmse),
            paper_rmse: paper.map(|p| p.0),
            paper_ms: paper.map(|p| p.1),
            paper_blend_ratio: paper.zip(theirs.as_ref()).map(|(p, all)| all.blend.0 / p.0),
            timing,
        };
    let seconds = |seconds| TableTiming { seconds, ..TableTiming::default() };
    let mut rows = vec![row(
        "paper",
        "the blend, first frame",
        blend.rays,
        Some(blend.quality.rmse),
        their(|p| p.blend),
        seconds(blend.timing.seconds),
    )];
    let default_cones = u32::try_from(blend.cones.round() as i64).unwrap_or(0);
    if let Some(cones) = find(trials, "cones", default_cones) {
        let rmse = Some(cones.quality.rmse);
        rows.push(row("cones", "cones", 0.0, rmse, their(|p| p.cones), seconds(cones.timing.seconds)));
    }
    let by_count = rays_by_count(trials);
    let time_by_count: Vec<(f64, f64)> =
        trials.iter().filter(|t| t.method == "rays").map(|t| (t.rays, t.timing.seconds)).collect();
    if let Some(rmse) = curve::at(&by_count, blend.rays) {
        let timing = seconds(curve::at(&time_by_count, blend.rays).unwrap_or(0.0));
        rows.push(row(
            "rays",
            "rays, as many as the blend traces",
            blend.rays,
            Some(rmse),
            their(|p| p.rays),
            timing,
        ));
    }
    if !by_count.is_empty() {
        let at_time = curve::at(&by_time(trials, "rays"), blend.timing.seconds);
        let timing = TableTiming {
            seconds: blend.timing.seconds,
            rmse: at_time,
            blend_ratio: at_time.map(|rmse| blend.quality.rmse / rmse),
        };
        rows.push(row("rays", "rays, in the blend's time", 0.0, None, their(|p| p.rays), timing));
    }
    rows
}

/// Every trial against the curves of `rays` and of `hybrid`, but for the method's own.
pub(super) fn equal_time(trials: &[TrialReport]) -> Vec<EqualTime> {
    let built: Vec<(f64, f64)> = trials
        .iter()
        .filter(|t| t.method == "rays")
        .map(|t| (t.timing.seconds_with_builds, t.quality.rmse))
        .collect();
    let (rays, hybrid) = (by_time(trials, "rays"), by_time(trials, "hybrid"));
    let against = |t: &TrialReport, other: &str, curve: &[(f64, f64)], seconds: f64| {
        curve::at(curve, seconds).filter(|_| t.method != other).map(|rmse| t.quality.rmse / rmse)
    };
    let of = |t: &TrialReport| {
        let timing = EqualTimeTiming {
            rmse_ratio: against(t, "rays", &rays, t.timing.seconds),
            rmse_ratio_with_builds: against(t, "rays", &built, t.timing.seconds_with_builds),
            hybrid_rmse_ratio: against(t, "hybrid", &hybrid, t.timing.seconds).map(f64::recip),
        };
        EqualTime { method: t.method.clone(), effort: t.effort, timing }
    };
    trials.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_ratios_are_those_of_the_paper() {
        let ratio = |scene: &str, pick: fn(&Published) -> (f64, f64)| {
            let all = published(scene).unwrap();
            all.blend.0 / pick(&all).0
        };
        assert!((ratio("cornell", |p| p.cones) - 0.67).abs() < 0.005);
        assert!((ratio("CornellBox-Sphere", |p| p.rays) - 0.80).abs() < 0.006);
        assert!((ratio("sponza", |p| p.cones) - 0.66).abs() < 0.005);
        assert!((ratio("sponza", |p| p.rays) - 1.11).abs() < 0.005);
        assert!(published("atrium").is_none());
    }
}
