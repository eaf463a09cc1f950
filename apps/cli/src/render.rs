//! `conray render`: the ambient occlusion that a camera sees.

use crate::{args::RenderArgs, explain, failure::Failure, inputs, interrupt, report};
use conray::{
    AoSettings, Control, Event, Method, Outcome, PROGRESS_UNITS, Session, Stage, View,
    scene::Scene,
    target::{self, CameraTarget, PngDepth, Target},
};
use report::Reporter;
use serde_json::json;
use std::{
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Instant,
};

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let settings = args.ao.checked()?;
    check_state(args, &settings)?;
    check_outputs(&args.output)?;
    let reporter = Reporter::new(args.run.json, args.run.quiet);
    let interrupted = interrupt::watch();

    let scene = inputs::load_scene(&args.scene)?;
    reporter.scene_warnings(&scene);
    let view = inputs::choose_view(&scene, &args.camera)?;
    let (width, height) = args.size;
    target::Camera::new(&view, width, height)?;
    let options = args.run.options();
    // The geometry moves into the session; names and views stay for the summary.
    let Scene { name, geometry, .. } = scene;
    let session = Session::build_observed(geometry, &settings, &options, &|e| reporter.event(e))?;
    stop_if(interrupted, "before anything was estimated; no file was written")?;
    let camera = session.camera(&view, width, height)?;
    let outcome = estimate(&session, &camera, args.state.as_deref(), interrupted, &reporter)?;
    explain::stop_if_nothing(&outcome.work)?;
    write_outputs(args, &settings, &session, &camera, &outcome)?;

    let missed = explain::missed(session.plan(), &outcome.work);
    let mut lines = summary_lines(&name, &view, args, &settings, &session, &outcome, camera.points().len());
    report::add_budget(&mut lines, args.ao.explain, session.plan(), &outcome.work);
    let mut facts = report::work_json(&settings, session.report(), &outcome.work);
    facts["scene"] = json!(name);
    facts["triangles"] = json!(session.geometry().triangle_count());
    facts["view"] = json!(view.name);
    facts["size"] = json!([width, height]);
    facts["distance"] = json!(session.plan().distance.to_string());
    facts["mean_visibility"] = json!(report::means(&outcome).map(|m| m.0));
    facts["expected_error"] = json!(report::means(&outcome).map(|m| m.1));
    facts["files"] = json!(args.output);
    reporter.summary(&lines, facts);
    if camera.points().is_empty() {
        reporter.warn("the view shows nothing of the scene");
    }
    stop_if(interrupted, "what was done by then has been written")?;
    explain::stop_if_failed(&outcome.work)?;
    explain::check(args.ao.strict, missed)
}

/// Refuses a file of kept work that could not be used, before any work.
fn check_state(args: &RenderArgs, settings: &AoSettings) -> Result<(), Failure> {
    let Some(path) = &args.state else { return Ok(()) };
    if settings.method != Method::Hybrid {
        return Err(Failure::Request(format!("--state: needs --method hybrid, not {}", settings.method)));
    }
    if args.output.contains(path) {
        return Err(Failure::Request(format!("--state {}: is an output too", path.display())));
    }
    Ok(target::check_writable(path)?)
}

/// Refuses outputs that could not be written, before any work.
fn check_outputs(outputs: &[PathBuf]) -> Result<(), Failure> {
    for path in outputs {
        if !matches!(extension(path).as_str(), "png" | "exr") {
            return Err(Failure::Request(format!("-o {}: must end in .png or .exr", path.display())));
        }
        target::check_writable(path)?;
    }
    Ok(())
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Runs the session over a target with progress as events.
pub(crate) fn estimate<T: Target>(
    session: &Session,
    target: &T,
    state: Option<&Path>,
    interrupted: &AtomicBool,
    reporter: &Reporter,
) -> Result<Outcome, Failure> {
    observed(interrupted, reporter, |control| match state {
        Some(path) => Ok(session.run_target_kept(session.plan().budget, target, control, path)?),
        None => Ok(session.run_target(target, control)?),
    })
}

/// Carries out work that tells of progress and can be stopped.
pub(crate) fn observed<T>(
    interrupted: &AtomicBool,
    reporter: &Reporter,
    work: impl FnOnce(Control<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let stage = Stage::Estimate;
    let (done, told, total) = (AtomicU64::new(0), AtomicU64::new(0), PROGRESS_UNITS);
    let start = Instant::now();
    reporter.event(Event::Started { stage });
    let progress = |work: usize| {
        let done = done.fetch_add(work as u64, Ordering::Relaxed) + work as u64;
        // At most about two hundred events a run.
        if done == total || done >= told.load(Ordering::Relaxed) + total / 200 {
            told.store(done, Ordering::Relaxed);
            reporter.event(Event::Progress { stage, done, total });
        }
    };
    let result = work(Control { cancelled: interrupted, progress: &progress })?;
    reporter.event(Event::Finished { stage, seconds: start.elapsed().as_secs_f64() });
    Ok(result)
}

fn write_outputs(
    args: &RenderArgs,
    settings: &AoSettings,
    session: &Session,
    camera: &CameraTarget,
    outcome: &Outcome,
) -> Result<(), Failure> {
    let layers = camera.resolve(&outcome.estimates)?;
    for path in &args.output {
        if extension(path) == "png" {
            let depth = if args.bits == "16" { PngDepth::Sixteen } else { PngDepth::Eight };
            target::write_png(path, &layers, depth)?;
        } else {
            let mut attributes = conray::settings_text(settings);
            attributes.push(("scene".into(), args.scene.clone()));
            attributes.push(("world-distance".into(), session.plan().distance.to_string()));
            attributes.push(("version".into(), env!("CARGO_PKG_VERSION").into()));
            target::write_exr(path, &layers, &attributes)?;
        }
    }
    Ok(())
}

/// Fails where Ctrl-C was pressed.
pub(crate) fn stop_if(interrupted: &AtomicBool, what: &str) -> Result<(), Failure> {
    if interrupted.load(Ordering::Relaxed) {
        return Err(Failure::Work(format!("interrupted: {what}")));
    }
    Ok(())
}

fn summary_lines(
    name: &str,
    view: &View,
    args: &RenderArgs,
    settings: &AoSettings,
    session: &Session,
    outcome: &Outcome,
    points: usize,
) -> Vec<String> {
    let (width, height) = args.size;
    let mut lines = vec![format!(
        "{name}: {} triangles, view {}, {width} x {height}, {points} points, AO distance {}",
        session.geometry().triangle_count(),
        view.name,
        session.plan().distance
    )];
    lines.extend(report::work_lines(settings, session.report(), &outcome.work));
    if let Some((visibility, error)) = report::means(outcome) {
        lines.push(format!("mean visibility {visibility:.4}, expected error {error:.4}"));
    }
    let files: Vec<String> = args.output.iter().map(|path| path.display().to_string()).collect();
    lines.push(format!("wrote {}", files.join(", ")));
    lines
}
