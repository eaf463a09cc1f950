//! `conray bake`: ambient occlusion into the textures of a model.

use crate::{
    args::BakeArgs,
    explain,
    failure::Failure,
    interrupt,
    render::{estimate, stop_if},
    report::{self, Reporter},
};
use conray::{
    Event, Outcome, Session, SessionOptions,
    scene::{self, Format, Scene},
    target::{self, AtlasMap, MapSize, PngDepth, SeamReport, Target},
};
use conray_bake::{Document, Origins, Places, Sheets, Unmapped, Unwrap, file_names, png, write_model};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Differences at a seam below this are hardly seen.
const SEAM_BOUND: f32 = 0.02;

/// Texels of all maps together: more are beyond the numbers that count them, and any memory.
const MAX_TEXELS: u64 = 1 << 30;

/// What the output is.
enum Output {
    /// A model like the one that came in.
    Model(Document),
    /// PNG files.
    Maps,
}

pub(crate) fn run(args: &BakeArgs) -> Result<(), Failure> {
    let settings = args.ao.checked()?;
    let reporter = Reporter::new(args.run.json, args.run.quiet);
    let interrupted = interrupt::watch();
    let output = output(&args.model, &args.output)?;
    target::check_writable(&args.output)?;

    let scene = scene::load(&args.model, &scene::Limits::default())?;
    reporter.scene_warnings(&scene);
    let Scene { name, geometry, origins, sources, .. } = scene;
    let instances: Vec<u32> = (0..geometry.instances().len() as u32).collect();
    let (width, height) = args.size;
    // New UVs are of use only where they are written too.
    let unwrap = match &output {
        Output::Model(_) if !args.no_unwrap => Unwrap::Yes,
        _ => Unwrap::No,
    };
    let sheets = Sheets::of(&geometry, &instances, MapSize { width, height }, unwrap);
    if let Some(unmapped) = sheets.unmapped.first() {
        return Err(no_uvs(unmapped, &sheets, &geometry.instances()[unmapped.instance as usize].name));
    }
    let all = sheets.sheets.len() as u64 * u64::from(width) * u64::from(height);
    if all > MAX_TEXELS {
        let count = sheets.sheets.len();
        return Err(Failure::Request(format!(
            "--size: {count} maps of {width} x {height} are too large; choose less"
        )));
    }
    let options = SessionOptions { threads: args.run.threads };
    let session = Session::build_observed(geometry, &settings, &options, &|e| reporter.event(e))?;
    // Images of other formats than glTF have their first row at v = 1.
    let places = Places::of(session.geometry(), &sheets, origins.is_empty());
    let texels = places.texels(&session, args.supersample);
    for (sheet, overlap) in
        sheets.sheets.iter().zip(texels.overlaps()).filter(|(_, overlap)| **overlap >= 1.0)
    {
        let message =
            format!("{}: surfaces lie over each other on {overlap:.0} texels of its map", sheet.name);
        reporter.event(Event::Warning { message });
    }
    stop_if(interrupted, "before anything was estimated; no file was written")?;
    let mut outcome = estimate(&session, &texels, None, interrupted, &reporter)?;
    let buried = places.unbury(&session, &texels, &mut outcome.estimates);
    let mut maps = texels.resolve(&outcome.estimates)?;
    maps.iter_mut().for_each(AtlasMap::fill);
    let seams = places.seams(&session);
    target::level(&seams, &mut maps);
    maps.iter_mut().for_each(|map| map.extend(args.padding));
    let seams = SeamReport::of(&seams, &maps, SEAM_BOUND);
    let depth = if args.bits == "16" { PngDepth::Sixteen } else { PngDepth::Eight };
    let files = match output {
        Output::Maps => write_maps(&args.output, &sheets, &maps, depth)?,
        Output::Model(document) => {
            let instances = session.geometry().instances();
            let vertices: Vec<&[u32]> =
                instances.iter().map(|instance| &sources[instance.mesh as usize][..]).collect();
            let origins = Origins { instances: &origins, vertices: &vertices };
            let written = write_model(&args.output, &args.model, document, &origins, &sheets, &maps, depth)
                .map_err(|e| Failure::Work(format!("{}: {e}", args.output.display())))?;
            for name in written.not_copied {
                let message = format!("{name}, which the model names, is not copied; copy it by hand");
                reporter.event(Event::Warning { message });
            }
            written.files
        }
    };

    let missed = explain::missed(session.plan(), &outcome);
    let mut lines = lines(&name, args, &session, &sheets, &outcome, &seams);
    if buried > 0 {
        lines.push(format!(
            "{buried} points lie inside other geometry; their texels took the values beside them"
        ));
    }
    lines.extend(report::work_lines(&settings, session.report(), &outcome));
    let shown: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    lines.push(format!("wrote {}", shown.join(", ")));
    report::add_budget(&mut lines, args.ao.explain, session.plan(), &outcome);
    let mut facts = report::work_json(&settings, session.report(), &outcome);
    facts["model"] = json!(name);
    facts["maps"] = json!(sheets.sheets.iter().map(|sheet| &sheet.name).collect::<Vec<_>>());
    facts["size"] = json!([width, height]);
    facts["buried"] = json!(buried);
    facts["seams"] = json!({
        "places": seams.places, "within": seams.within, "bound": SEAM_BOUND, "rms": seams.rms, "worst": seams.worst
    });
    facts["mean_visibility"] = json!(report::means(&outcome).map(|m| m.0));
    facts["files"] = json!(files);
    reporter.summary(&lines, facts);
    stop_if(interrupted, "what was done by then has been written")?;
    explain::check(args.ao.strict, missed)
}

/// What will be written, refused before any work where it cannot be.
fn output(model: &Path, output: &Path) -> Result<Output, Failure> {
    let request = |problem: String| Failure::Request(format!("-o {}: {problem}", output.display()));
    let ending =
        |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let (from, to) = (ending(model), ending(output));
    let is_input = matches!((model.canonicalize(), output.canonicalize()), (Ok(a), Ok(b)) if a == b);
    match &to[..] {
        _ if is_input => Err(request("it is the model itself; choose another name".into())),
        "png" => Ok(Output::Maps),
        "glb" | "gltf" if from == to => {
            let input = |problem: String| Failure::Input(format!("{}: {problem}", model.display()));
            let bytes = std::fs::read(model).map_err(|e| input(format!("cannot be read: {e}")))?;
            let format = Format::detect(model, &bytes);
            if format != Some(Format::Gltf) {
                return Err(input("it is no glTF".into()));
            }
            Ok(Output::Model(Document::open(&bytes).map_err(|e| input(e.to_string()))?))
        }
        _ if matches!(&from[..], "glb" | "gltf") => {
            Err(request(format!("must end in .{from} as the model does, or in .png")))
        }
        _ => Err(request("must end in .png: only glTF is written back".into())),
    }
}

fn no_uvs(unmapped: &Unmapped, sheets: &Sheets, name: &str) -> Failure {
    let count = sheets.unmapped.len();
    let name = if name.is_empty() { format!("surface {}", unmapped.instance) } else { name.to_string() };
    Failure::Input(format!(
        "{count} surfaces have no UV set that a map can use; the first is {name}: {}. Unwrap them into a set of their own, within the unit \
         square and without overlaps, or bake a glTF without --no-unwrap",
        unmapped.fault
    ))
}

/// One PNG a map: under the name asked for where there is one map, else with the map's name in it.
fn write_maps(
    output: &Path,
    sheets: &Sheets,
    maps: &[AtlasMap],
    depth: PngDepth,
) -> Result<Vec<PathBuf>, Failure> {
    let stem = output.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let path = |name: &String| match maps.len() {
        1 => output.to_path_buf(),
        _ => output.with_file_name(format!("{stem}-{name}.png")),
    };
    let paths: Vec<PathBuf> = file_names(sheets).iter().map(path).collect();
    for (path, map) in paths.iter().zip(maps) {
        let bytes = png(map, depth);
        target::write_atomically(path, |out| out.write_all(&bytes))?;
    }
    Ok(paths)
}

fn lines(
    name: &str,
    args: &BakeArgs,
    session: &Session,
    sheets: &Sheets,
    outcome: &Outcome,
    seams: &SeamReport,
) -> Vec<String> {
    let (width, height) = args.size;
    let maps = if sheets.sheets.len() == 1 { "map" } else { "maps" };
    let mut lines = vec![format!(
        "{name}: {} triangles, {} {maps} of at most {width} x {height}, {} points, AO distance {}",
        session.geometry().triangle_count(),
        sheets.sheets.len(),
        outcome.estimates.len(),
        session.plan().distance
    )];
    if let Some((visibility, error)) = report::means(outcome) {
        lines.push(format!("mean visibility {visibility:.4}, expected error {error:.4}"));
    }
    if seams.places > 0 {
        let share = 100.0 * seams.within as f64 / seams.places as f64;
        lines.push(format!(
            "seams: {share:.2} % of {} places within {SEAM_BOUND}, at most {:.3} apart",
            seams.places, seams.worst
        ));
    }
    lines
}
