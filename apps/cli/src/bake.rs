//! `conray bake`: ambient occlusion into the textures of a model.

use crate::{
    args::BakeArgs,
    explain,
    failure::Failure,
    interrupt,
    render::{observed, stop_if},
    report::{self, Reporter},
};
use conray::{
    Event, Session, SessionOptions, Work,
    scene::{self, Format, Scene},
    target::{self, AtlasMap, MapSize, PngDepth, SeamReport},
};
use conray_bake::{
    Baked, Document, MapOptions, Origins, Places, Sheets, Unmapped, Unwrap, bake_maps, file_names, png,
    write_model,
};
use serde_json::json;
use std::path::{Path, PathBuf};

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
    let places = Places::of(session.geometry(), &sheets, origins.is_empty(), args.supersample);
    stop_if(interrupted, "before anything was estimated; no file was written")?;
    let map_options = MapOptions { padding: args.padding, ..MapOptions::default() };
    let baked = observed(interrupted, &reporter, |control| {
        Ok(bake_maps(&session, &places, session.plan().budget, &map_options, control)?)
    })?;
    let Some(work) = Work::of_parts(&baked.parts) else {
        return Err(Failure::Input(format!("{}: no surface reads a map", args.model.display())));
    };
    for (sheet, overlap) in sheets.sheets.iter().zip(&baked.overlaps).filter(|(_, overlap)| **overlap >= 1.0)
    {
        let message =
            format!("{}: surfaces lie over each other on {overlap:.0} texels of its map", sheet.name);
        reporter.event(Event::Warning { message });
    }
    let depth = if args.bits == "16" { PngDepth::Sixteen } else { PngDepth::Eight };
    let files = match output {
        Output::Maps => write_maps(&args.output, &sheets, &baked.maps, depth)?,
        Output::Model(document) => {
            let instances = session.geometry().instances();
            let vertices: Vec<&[u32]> =
                instances.iter().map(|instance| &sources[instance.mesh as usize][..]).collect();
            let origins = Origins { instances: &origins, vertices: &vertices };
            let written =
                write_model(&args.output, &args.model, document, &origins, &sheets, &baked.maps, depth)
                    .map_err(|e| Failure::Work(format!("{}: {e}", args.output.display())))?;
            for name in written.not_copied {
                let message = format!("{name}, which the model names, is not copied; copy it by hand");
                reporter.event(Event::Warning { message });
            }
            written.files
        }
    };

    let missed = explain::missed(session.plan(), &work);
    let mut lines = lines(&name, args, &session, &sheets, &baked, &work);
    lines.extend(report::work_lines(&settings, session.report(), &work));
    let shown: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    lines.push(format!("wrote {}", shown.join(", ")));
    lines.extend(missed.clone());
    if args.ao.explain {
        for (k, part) in (1..).zip(&baked.parts) {
            if baked.portions > 1 {
                lines.push(format!("portion {k} of {}, {} points:", baked.portions, part.points));
            }
            lines.extend(explain::lines(session.plan(), part));
        }
    }
    let mut facts = report::work_json(&settings, session.report(), &work);
    facts["plan"] = baked.parts.iter().map(|part| json!(part.explanation)).collect();
    facts["model"] = json!(name);
    facts["maps"] = json!(sheets.sheets.iter().map(|sheet| &sheet.name).collect::<Vec<_>>());
    facts["size"] = json!([width, height]);
    facts["buried"] = json!(baked.buried);
    let SeamReport { places, within, rms, worst } = baked.seams;
    facts["seams"] = json!({
        "places": places, "within": within, "bound": map_options.seam_bound, "rms": rms, "worst": worst
    });
    facts["mean_visibility"] = json!(mean(&baked.maps));
    facts["files"] = json!(files);
    reporter.summary(&lines, facts);
    stop_if(interrupted, "what was done by then has been written")?;
    explain::check(args.ao.strict, missed)
}

/// Mean visibility of the texels that are read.
fn mean(maps: &[AtlasMap]) -> Option<f64> {
    let read = maps.iter().flat_map(|map| map.visibility.iter().zip(&map.is_read)).filter(|(_, read)| **read);
    let (sum, count) =
        read.fold((0.0, 0u64), |(sum, count), (visibility, _)| (sum + f64::from(*visibility), count + 1));
    (count > 0).then(|| sum / count as f64)
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
    baked: &Baked,
    work: &Work,
) -> Vec<String> {
    let (width, height) = args.size;
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
