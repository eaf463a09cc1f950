//! `conray bake`: ambient occlusion into the textures of a model.

mod checks;
mod job;
mod output;
mod plan;
mod preview;
mod summary;
mod vertex;

pub(crate) use job::{keep, with_job};

use crate::{
    args::BakeArgs,
    explain,
    failure::Failure,
    interrupt,
    render::{observed, stop_if},
    report::Reporter,
};
use conray::{
    AoSettings, Backs, Distance, Event, Geometry, Session, Work,
    scene::{self, Scene},
    target::{self, AtlasMap},
};
use conray_bake::{
    Apart, BentColours, BentSpace, MapOptions, Memory, Places, Sheets, Unmapped, Unwrap, bake_maps,
};
use output::Output;
use std::{
    path::{Path, PathBuf},
    sync::atomic::AtomicBool,
};

pub(crate) fn run(args: &BakeArgs) -> Result<(), Failure> {
    if args.options.is_some() {
        return job::print_options();
    }
    args.ao.checked()?;
    let reporter = Reporter::new(args.run.json, args.run.quiet);
    let interrupted = interrupt::watch();
    let each = args.each();
    let [one] = &each[..] else { return run_several(&each, &args.output(), interrupted, &reporter) };
    bake(one, interrupted, &reporter)
}

/// Bakes several models into a folder; what fails is told, and the others go on.
fn run_several(
    each: &[BakeArgs],
    folder: &Path,
    interrupted: &AtomicBool,
    reporter: &Reporter,
) -> Result<(), Failure> {
    let request = |problem: &str| Err(Failure::Request(format!("-o {}: {problem}", folder.display())));
    if each.iter().any(|args| args.state.is_some() || args.preview.is_some()) {
        return Err(Failure::Request("--state and --preview: are for one model at a time".into()));
    }
    let is_dry = each.iter().any(|args| args.dry_run);
    if !is_dry && !folder.is_dir() {
        return request("must be a folder that is there, for several models");
    }
    let mut names: Vec<PathBuf> = each.iter().map(BakeArgs::output).collect();
    names.sort();
    if !is_dry && let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return request(&format!("two of the models would both be {}", twice[0].display()));
    }
    let mut first = None;
    let mut failed = 0;
    for args in each {
        if let Err(failure) = bake(args, interrupted, reporter) {
            stop_if(interrupted, &failure.to_string())?;
            reporter.warn(&format!("not baked: {failure}"));
            failed += 1;
            first.get_or_insert(failure);
        }
    }
    first.map_or(Ok(()), |failure| {
        Err(failure.with(format!("{failed} of {} models were not baked", each.len())))
    })
}

/// Bakes one model.
fn bake(args: &BakeArgs, interrupted: &AtomicBool, reporter: &Reporter) -> Result<(), Failure> {
    let settings = args.ao.checked()?;
    let (model, to) = (args.model(), args.output());
    let output = Output::of(&model, &to)?;
    if output.is_some() {
        target::check_writable(&to)?;
    }
    let for_vertices = Output::is_for_vertices(output.as_ref(), args)?;
    checks::use_of_options(for_vertices, output.as_ref())?;
    preview::check(args, for_vertices)?;
    checks::state(args, &settings)?;
    let options = checks::device_options(args)?;
    let mut scene = scene::load_with(&model, &scene::Limits::default(), args.extras())?;
    reporter.scene_warnings(&scene);
    let scope = args.scope();
    if scope.backs != Backs::Block && settings.method.needs_octree() {
        let what = format!(
            "--ignore-backfaces: voxels have no backs; needs --method rays or hybrid, not {}",
            settings.method
        );
        return Err(Failure::Request(what));
    }
    // What is chosen or added does not change the distance.
    let distance = settings.distance.in_world(scene.geometry.bounds().diagonal());
    let settings = AoSettings { distance: definite(settings.distance, distance), ..settings };
    let shown: Vec<u32> = scene.geometry.instances().iter().map(|instance| instance.mesh).collect();
    let chosen = scope.apply(&mut scene, distance).map_err(|e| Failure::Request(e.to_string()))?;
    let Scene { name, geometry, origins, sources, .. } = scene;
    let sheets = if for_vertices {
        Sheets::default()
    } else {
        sheets_of(args, &geometry, &chosen.receivers, !origins.is_empty(), output.as_ref())?
    };
    let session = Session::build_observed(geometry, &settings, &options, &|e| reporter.event(e))?;
    let facing = session.install(|| args.facing(session.geometry(), &chosen.receivers)).ok_or_else(|| {
        let what = "--normal mapped: no material of what is baked has a normal map that can be read";
        Failure::Request(what.into())
    })?;
    let apart = chosen.objects.iter().cloned().map(|instances| {
        let session = session.only(&instances)?;
        Ok(Apart { instances, session })
    });
    let apart = apart.collect::<Result<Vec<Apart>, conray::Error>>()?;
    let vertices: Vec<&[u32]> =
        shown.iter().map(|&mesh| sources.get(mesh as usize).map_or(&[][..], Vec::as_slice)).collect();
    if for_vertices {
        let of = vertex::Of {
            name: &name,
            args,
            session: &session,
            apart: &apart,
            receivers: &chosen.receivers,
            facing: &facing,
            origins: &origins,
            vertices: &vertices,
        };
        return vertex::run(&of, output, interrupted, reporter);
    }
    // Images of other formats than glTF have their first row at v = 1.
    let places = Places::of(session.geometry(), &sheets, origins.is_empty(), args.supersample, facing);
    let structures = session.memory_bytes()
        + places.facing.memory_bytes()
        + apart.iter().map(|apart| apart.session.memory_bytes()).sum::<u64>();
    let bent = args.bent().map_or(BentSpace::World, BentColours::space);
    let memory = Memory::within(&places, bent, structures, settings.max_memory).map_err(|needed| {
        Failure::Request(format!(
            "--max-memory: the maps need {needed} bytes; allow more, or choose less {}",
            args.extent_option()
        ))
    })?;
    let map_options = MapOptions {
        padding: args.padding,
        portion: memory.places,
        state: args.state.clone(),
        bent,
        ..MapOptions::default()
    };
    stop_if(interrupted, "before anything was estimated; no file was written")?;
    if args.dry_run {
        let ready = plan::Ready {
            name: &name,
            session: &session,
            apart: &apart,
            places: &places,
            sheets: &sheets,
            memory,
            options: &map_options,
        };
        return plan::print(&ready, reporter);
    }
    let mut preview = match &args.preview {
        Some(path) => Some(preview::Preview::begin(path, &session, &apart, &places, &sheets, &map_options)?),
        None => None,
    };
    let baked = observed(interrupted, reporter, |control| {
        let budget = session.plan().budget;
        let mut refine = |maps: &[AtlasMap]| preview.iter_mut().for_each(|preview| preview.refine(maps));
        Ok(bake_maps(&session, &apart, &places, budget, &map_options, control, &mut refine)?)
    })?;
    if let Some(preview) = preview {
        preview.end(&baked.maps)?;
    }
    let Some(work) = Work::of_parts(&baked.parts) else {
        return Err(Failure::Input(format!("{}: no surface reads a map", model.display())));
    };
    explain::stop_if_nothing(&work)?;
    for (sheet, overlap) in sheets.sheets.iter().zip(&baked.overlaps).filter(|(_, overlap)| **overlap >= 1.0)
    {
        let message =
            format!("{}: surfaces lie over each other on {overlap:.0} texels of its map", sheet.name);
        reporter.event(Event::Warning { message });
    }
    let files = match output {
        Some(output) => {
            output.write(args, &sheets, &baked.maps, (&origins, &vertices), &session, reporter)?
        }
        None => Vec::new(),
    };
    let missed = explain::missed(session.plan(), &work);
    summary::tell(&summary::Told {
        name: &name,
        args,
        session: &session,
        sheets: &sheets,
        baked: &baked,
        work: &work,
        files: &files,
        missed: missed.as_deref(),
        reporter,
    });
    stop_if(interrupted, "what was done by then has been written")?;
    explain::stop_if_failed(&work)?;
    explain::check(args.ao.strict, missed)
}

/// A distance that does not depend on what is in the scene; one that makes no sense is left for the settings to refuse.
fn definite(distance: Distance, in_world: f32) -> Distance {
    match distance {
        Distance::Auto if in_world > 0.0 && in_world.is_finite() => Distance::World(in_world),
        other => other,
    }
}

/// The maps of what is baked.
fn sheets_of(
    args: &BakeArgs,
    geometry: &Geometry,
    receivers: &[u32],
    is_gltf: bool,
    output: Option<&Output>,
) -> Result<Sheets, Failure> {
    let extent = args.extent();
    // New UVs are of use only where they are written too: in the glTF, or in an OBJ beside the maps.
    let is_written = !is_gltf || matches!(output, Some(Output::Model(_)) | None);
    let unwrap = if is_written && !args.no_unwrap { Unwrap::Yes } else { Unwrap::No };
    let sheets = match args.shared {
        true => Sheets::shared(geometry, receivers, extent, unwrap),
        false => Sheets::of(geometry, receivers, extent, unwrap),
    };
    if let Some(unmapped) = sheets.unmapped.first() {
        return Err(no_uvs(unmapped, &sheets, &geometry.instances()[unmapped.instance as usize].name));
    }
    checks::size_of_maps(args, &sheets)?;
    Ok(sheets)
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
