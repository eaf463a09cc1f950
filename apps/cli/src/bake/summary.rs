//! What a bake tells at its end.

use super::job;
use crate::{
    args::BakeArgs,
    explain,
    report::{self, Reporter},
};
use conray::{
    Session, Work,
    target::{AtlasMap, MapSize, SeamReport},
};
use conray_bake::{Baked, MapOptions, Sheets};
use serde_json::json;
use std::path::PathBuf;

/// All that there is to tell.
pub(super) struct Told<'a> {
    pub(super) name: &'a str,
    pub(super) args: &'a BakeArgs,
    pub(super) session: &'a Session,
    pub(super) sheets: &'a Sheets,
    pub(super) baked: &'a Baked,
    pub(super) work: &'a Work,
    pub(super) files: &'a [PathBuf],
    pub(super) missed: Option<&'a str>,
    pub(super) reporter: &'a Reporter,
}

pub(super) fn tell(told: &Told<'_>) {
    let Told { args, session, baked, work, files, .. } = told;
    let mut lines = lines(told);
    lines.extend(report::work_lines(&args.ao.settings(), session.report(), work));
    let shown: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    lines.push(format!("wrote {}", shown.join(", ")));
    lines.extend(told.missed.map(String::from));
    if args.ao.explain {
        for (k, part) in (1..).zip(&baked.parts) {
            if baked.parts.len() > 1 {
                lines.push(format!("part {k} of {}, {} points:", baked.parts.len(), part.points));
            }
            lines.extend(explain::lines(session.plan(), part));
        }
    }
    let mut facts = report::work_json(&args.ao.settings(), session.report(), work);
    facts["plan"] = baked.parts.iter().map(|part| json!(part.explanation)).collect();
    facts["model"] = json!(told.name);
    facts["maps"] = told.sheets.sheets.iter().map(|sheet| json!(sheet.name)).collect();
    facts["sizes"] =
        told.sheets.sheets.iter().map(|sheet| json!([sheet.size.width, sheet.size.height])).collect();
    facts["buried"] = json!(baked.buried);
    let SeamReport { places, within, rms, worst } = baked.seams;
    let bound = MapOptions::default().seam_bound;
    facts["seams"] =
        json!({ "places": places, "within": within, "bound": bound, "rms": rms, "worst": worst });
    facts["mean_visibility"] = json!(mean(&baked.maps));
    facts["files"] = json!(files);
    facts["job"] = job::given();
    told.reporter.summary(&lines, facts);
}

/// Mean visibility of the texels that are read.
fn mean(maps: &[AtlasMap]) -> Option<f64> {
    let read = maps.iter().flat_map(|map| map.visibility.iter().zip(&map.is_read)).filter(|(_, read)| **read);
    let (sum, count) =
        read.fold((0.0, 0u64), |(sum, count), (visibility, _)| (sum + f64::from(*visibility), count + 1));
    (count > 0).then(|| sum / count as f64)
}

fn lines(Told { name, session, sheets, baked, work, .. }: &Told<'_>) -> Vec<String> {
    let side = |of: fn(&MapSize) -> u32| sheets.sheets.iter().map(|sheet| of(&sheet.size)).max();
    let (width, height) = (side(|s| s.width).unwrap_or(0), side(|s| s.height).unwrap_or(0));
    let maps = if sheets.sheets.len() == 1 { "map" } else { "maps" };
    let mut lines = vec![format!(
        "{name}: {} triangles, {} {maps} of at most {width} x {height}, {} points, AO distance {}",
        session.geometry().triangle_count(),
        sheets.sheets.len(),
        work.points,
        session.plan().distance
    )];
    if let Some(visibility) = mean(&baked.maps) {
        lines.push(format!("mean visibility {visibility:.4}, expected error {:.4}", work.expected_rmse));
    }
    let SeamReport { places, within, worst, .. } = baked.seams;
    if places > 0 {
        let share = 100.0 * within as f64 / places as f64;
        let bound = MapOptions::default().seam_bound;
        lines
            .push(format!("seams: {share:.2} % of {places} places within {bound}, at most {worst:.3} apart"));
    }
    if baked.buried > 0 {
        let buried = baked.buried;
        lines.push(format!(
            "{buried} points lie inside other geometry; their texels took the values beside them"
        ));
    }
    lines
}
