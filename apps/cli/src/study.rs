//! `conray study`: methods compared on scenes, as a report.

use crate::{args::StudyArgs, failure::Failure, inputs, interrupt, report::Reporter};
use conray::{View, scene::Scene, target};
use conray_study::{self as study, StudyOptions, StudyScene};
use serde_json::json;
use std::{fs, time::Instant};

pub(crate) fn run(args: &StudyArgs) -> Result<(), Failure> {
    let options = options(args)?;
    options.validate()?;
    let reporter = Reporter::new(args.run.json, args.run.quiet);
    let interrupted = interrupt::watch();
    let scenes = scenes(args, &reporter)?;
    study::check_folder(&args.output)?;

    let start = Instant::now();
    let (found, pictures) = study::run(scenes, &options, &reporter, interrupted)?;
    study::write_report(&args.output, &found, &pictures)?;
    // What was kept for going on after an interruption has done its service.
    let _ = fs::remove_dir_all(&options.work_folder);

    let mut lines: Vec<String> = found.cases.iter().flat_map(study::summary).collect();
    lines.push(format!(
        "wrote {} in {:.0} s",
        args.output.join("report.html").display(),
        start.elapsed().as_secs_f64()
    ));
    let facts =
        json!({ "report": args.output.join("report.json"), "seconds": start.elapsed().as_secs_f64() });
    reporter.summary(&lines, facts);
    Ok(())
}

fn options(args: &StudyArgs) -> Result<StudyOptions, Failure> {
    let work = args.output.join("unfinished");
    let start = if args.quick { StudyOptions::quick(work) } else { StudyOptions::full(work) };
    let truths = args.cache.clone().or_else(|| Some(dirs::cache_dir()?.join("conray").join("truths")));
    let budgets = args.budgets.clone().unwrap_or_else(|| start.budgets.clone());
    let enough = budgets.last().map_or(0, |most| most.saturating_mul(16));
    Ok(StudyOptions {
        size: args.size.unwrap_or(start.size),
        truth_rays: args.truth_rays.unwrap_or(start.truth_rays.max(enough)),
        budgets,
        methods: args.methods.clone().unwrap_or_else(|| start.methods.clone()),
        repeats: args.repeats,
        truth_error: args.truth_error.unwrap_or(start.truth_error),
        settings: args.ao.settings(),
        threads: args.run.threads,
        truth_folder: truths,
        ..start
    })
}

/// Loads every scene and finds its views, so that mistakes show before long work.
fn scenes(args: &StudyArgs, reporter: &Reporter) -> Result<Vec<StudyScene>, Failure> {
    let given = inputs::given_view(&args.given);
    if given.is_some() && args.scenes.len() > 1 {
        return Err(Failure::Request("--eye and --look-at need exactly one scene".into()));
    }
    let mut loaded: Vec<StudyScene> = Vec::new();
    for name in &args.scenes {
        let start = Instant::now();
        let scene = inputs::load_scene(name)?;
        let load_seconds = start.elapsed().as_secs_f64();
        reporter.scene_warnings(&scene);
        let views = views(&scene, args, given.clone());
        loaded.push(StudyScene { scene, views, load_seconds });
    }
    for name in &args.view {
        if !loaded.iter().any(|s| s.views.iter().any(|v| v.name == *name)) {
            let scenes: Vec<&Scene> = loaded.iter().map(|s| &s.scene).collect();
            return Err(inputs::no_such_view(&scenes, name));
        }
    }
    if let Some(bare) = loaded.iter().find(|s| s.views.is_empty()) {
        return Err(inputs::no_such_view(&[&bare.scene], &args.view.join(",")));
    }
    for view in loaded.iter().flat_map(|s| &s.views) {
        let (width, height) = options(args)?.size;
        target::Camera::new(view, width, height)?;
    }
    Ok(loaded)
}

/// The views of one scene that were asked for; its first where none were.
fn views(scene: &Scene, args: &StudyArgs, given: Option<View>) -> Vec<View> {
    let mut views: Vec<View> = if let Some(view) = given {
        vec![view]
    } else if args.view.is_empty() {
        vec![scene.default_view()]
    } else {
        args.view.iter().filter_map(|name| inputs::named_view(scene, name)).collect()
    };
    for view in &mut views {
        view.vertical_fov_deg = args.given.fov.unwrap_or(view.vertical_fov_deg);
        view.up = args.given.up.unwrap_or(view.up);
    }
    views
}

impl study::Observer for Reporter {
    fn progress(&self, progress: &study::Progress) {
        self.study_progress(&progress.what, progress.done, progress.total);
    }

    fn warn(&self, message: &str) {
        self.event(conray::Event::Warning { message: message.into() });
    }
}
