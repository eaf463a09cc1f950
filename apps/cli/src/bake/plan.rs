//! `--dry-run`: what a bake would do.

use crate::{
    failure::Failure,
    report::{Reporter, bytes},
};
use conray::{Control, Session, Work};
use conray_bake::{Apart, MapOptions, Memory, Places, Sheets, Uvs, bake_maps};
use serde_json::json;

/// Rows of the largest map that are baked to see how long all takes.
const TRIED_ROWS: u32 = 32;

/// What is ready to be baked.
pub(super) struct Ready<'a> {
    pub(super) name: &'a str,
    pub(super) session: &'a Session,
    pub(super) apart: &'a [Apart],
    pub(super) places: &'a Places,
    pub(super) sheets: &'a Sheets,
    pub(super) memory: Memory,
    pub(super) options: &'a MapOptions,
}

/// Prints maps, texels, memory and time; a few rows are baked to foresee it.
pub(super) fn print(ready: &Ready<'_>, reporter: &Reporter) -> Result<(), Failure> {
    let Ready { name, session, apart, places, sheets, memory, options } = *ready;
    let portions = places.atlas.portions(options.portion)?;
    let reads: f64 = portions.iter().map(|portion| places.atlas.reads(portion)).sum();
    let seconds = foreseen(session, apart, places, options)?;
    let mut lines = vec![format!(
        "{name}: {} triangles, {} maps, about {reads:.0} texels read, in {} portions, AO distance {}",
        session.geometry().triangle_count(),
        sheets.sheets.len(),
        portions.len(),
        session.plan().distance
    )];
    let mut maps = Vec::new();
    for sheet in &sheets.sheets {
        let (size, triangles) = (sheet.size, triangles(session, &sheet.instances));
        let (uvs, set) = match &sheet.uvs {
            Uvs::Set(set) => ("UV set", set),
            Uvs::New { set, .. } => ("new UV set", set),
        };
        lines.push(format!(
            "map {}: {} x {}, {} surfaces of {triangles} triangles by {uvs} {set}",
            sheet.name,
            size.width,
            size.height,
            sheet.readers().count()
        ));
        maps.push(json!({
            "name": sheet.name, "size": [size.width, size.height], "surfaces": sheet.readers().count(),
            "triangles": triangles, "uv_set": set, "is_new": matches!(sheet.uvs, Uvs::New { .. })
        }));
    }
    let all = memory.always + memory.portion;
    lines.push(format!("memory: about {}", bytes(all)));
    lines.push(match seconds {
        Some(seconds) => format!("time of estimation: about {seconds:.1} s"),
        None => "time of estimation: not known, nothing was read".into(),
    });
    lines.push("nothing was written".into());
    let facts = json!({
        "model": name, "maps": maps, "texels": reads, "portions": portions.len(), "memory_bytes": all,
        "seconds": seconds, "distance": session.plan().distance
    });
    reporter.summary(&lines, facts);
    Ok(())
}

fn triangles(session: &Session, instances: &[u32]) -> usize {
    instances.iter().map(|&instance| session.geometry().mesh_of(instance as usize).triangles().len()).sum()
}

/// Seconds that the estimation would take, by some rows across the maps.
fn foreseen(
    session: &Session,
    apart: &[Apart],
    places: &Places,
    options: &MapOptions,
) -> Result<Option<f64>, Failure> {
    let most = places.atlas.sizes.iter().map(|size| u64::from(size.width)).max().unwrap_or(0);
    let rows = u64::from(TRIED_ROWS) * most * u64::from(places.atlas.supersample).pow(2);
    let all = places.atlas.portions(rows)?;
    let reads: f64 = all.iter().map(|portion| places.atlas.reads(portion)).sum();
    // The fullest of them stands for all.
    let tried = all.iter().max_by(|a, b| places.atlas.reads(a).total_cmp(&places.atlas.reads(b)));
    let Some(tried) = tried.filter(|tried| places.atlas.reads(tried) > 0.0) else { return Ok(None) };
    let budget = conray::Budget { seconds: None, ..session.plan().budget };
    let only = MapOptions { only: Some(tried.clone()), state: None, ..options.clone() };
    let baked = bake_maps(session, apart, places, budget, &only, Control::none(), &mut |_| {})?;
    let work = Work::of_parts(&baked.parts);
    let found = work.map(|work| work.seconds * reads / places.atlas.reads(tried));
    Ok(found.map(|found| session.plan().budget.seconds.map_or(found, |most| found.min(most))))
}
