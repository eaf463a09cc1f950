//! The study: scenes in, a report and its pictures out.

use crate::{
    Case, Contender, Report, StudyError, StudyOptions, StudyScene,
    assemble::{self, Evidence},
    case::{Place, file_name},
    contenders, machine,
    meter::Meter,
    pilot::Pilot,
    report::{CaseReport, CaseTiming, MethodReport, Request},
    trials::{self, Store, Trial},
    truth::{Truth, TruthOptions},
};
use conray::{AoSettings, Control, Method, Ray, Session, SessionOptions, View};
use serde_json::{Map, Value};
use std::{
    collections::BTreeMap,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};

/// PNG files of a report by their path beside it.
pub type Pictures = BTreeMap<String, Vec<u8>>;

/// How far a study is.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// What is being done: `cornell-front: paper, 4 frames`.
    pub what: String,
    /// Work done, in rays or what takes about as long.
    pub done: u64,
    /// Work in all, as far as can be told.
    pub total: u64,
}

/// Receives progress and warnings.
pub trait Observer: Sync {
    /// The study has moved on.
    fn progress(&self, progress: &Progress);
    /// Something odd that does not stop the study.
    fn warn(&self, message: &str);
}

/// Carries out a study.
///
/// What is finished is kept in the work folder as it goes, so that the same call goes on after an interruption; the
/// caller removes that folder once the report is written.
///
/// # Errors
/// Options out of range, a view that shows nothing, kept files that are damaged, an interruption.
pub fn run(
    scenes: Vec<StudyScene>,
    options: &StudyOptions,
    observer: &dyn Observer,
    cancelled: &AtomicBool,
) -> Result<(Report, Pictures), StudyError> {
    options.validate()?;
    let start = Instant::now();
    let mut pictures = Pictures::new();
    let mut reports = Vec::new();
    let case_count = scenes.iter().map(|s| s.views.len()).sum();
    let meter = Meter::new(observer, case_count);
    for StudyScene { scene, views, load_seconds } in scenes {
        let name = scene.name.clone();
        meter.say(format!("{name}: building"));
        let built = AoSettings { method: Method::Paper, ..options.settings.clone() };
        let threads = SessionOptions { threads: options.threads, ..SessionOptions::default() };
        let warn = |event| {
            if let conray::Event::Warning { message } = event {
                observer.warn(&message);
            }
        };
        let scene_views = scene.views.clone();
        let session = Arc::new(Session::build_observed(scene.geometry, &built, &threads, &warn)?);
        for view in views {
            let target = session.camera(&view, options.size.0, options.size.1)?;
            let case = Case {
                id: case_id(&name, &view.name, &reports),
                scene: name.clone(),
                places: places(&session, scene_views.iter().filter(|other| other.name != view.name)),
                view,
                session: Arc::clone(&session),
                target,
                settings: options.settings.clone(),
            };
            if case.points().is_empty() {
                return Err(StudyError::Request(format!(
                    "{name}: view {} shows nothing of the scene; choose another",
                    case.view.name
                )));
            }
            let timing = CaseTiming {
                load_seconds,
                bvh_seconds: session.report().bvh_seconds,
                octree_seconds: session.report().octree_seconds,
                noise: None,
            };
            reports.push(study_case(&case, timing, options, &meter, cancelled, &mut pictures)?);
        }
    }
    meter.say("writing".into());
    let report = Report {
        version: env!("CARGO_PKG_VERSION").into(),
        schema: 1,
        quick: options.quick,
        request: request(options),
        methods: contenders::chosen(&options.methods)?.iter().map(|c| method_report(&**c)).collect(),
        unstated: assemble::unstated(&options.settings),
        timing: machine::timing(options.threads, start.elapsed().as_secs_f64(), &reports),
        cases: reports,
    };
    Ok((report, pictures))
}

/// One case, from its truth to its report.
fn study_case(
    case: &Case,
    timing: CaseTiming,
    options: &StudyOptions,
    meter: &Meter<'_>,
    cancelled: &AtomicBool,
    pictures: &mut Pictures,
) -> Result<CaseReport, StudyError> {
    let control = Control { cancelled, progress: &|_| {} };
    let mut truth = find_truth(case, options, options.truth_error, meter, control)?;
    meter.say(format!("{}: looking at cones", case.id));
    let pilot = Pilot::trace(case, options.pilot_points)?;
    let mut contenders: Vec<Box<dyn Contender>> = contenders::chosen(&options.methods)?;
    contenders.retain(|c| c.unavailable().is_none());
    let store = Store::new(case, options)?;
    let trials =
        trials::run(case, &mut contenders, &truth.visibility, &pilot, options, &store, meter, control)?;
    stop_if(cancelled)?;
    // The truth must be well under what it judges.
    let smallest = |truth: &Truth| {
        let rmse = |t: &Trial| crate::quality::rmse(&t.answer.visibility, &truth.visibility);
        trials.list.iter().map(rmse).fold(f64::INFINITY, f64::min)
    };
    while truth.error > smallest(&truth) / 4.0 && truth.rays < options.truth_rays {
        let before = truth.rays;
        truth = find_truth(case, options, smallest(&truth) / 4.0, meter, control)?;
        if truth.rays == before {
            break;
        }
    }
    meter.say(format!("{}: judging", case.id));
    let evidence = Evidence {
        case,
        truth: &truth,
        pilot: &pilot,
        contenders: &contenders,
        trials: &trials,
        timing,
        options,
    };
    let report = assemble::case_report(&evidence, pictures)?;
    stop_if(cancelled)?;
    meter.case_done();
    Ok(report)
}

/// What each view shows, if there is a surface in its middle.
fn places<'a>(session: &Session, views: impl Iterator<Item = &'a View>) -> Vec<Place> {
    let place = |view: &View| {
        let direction = (view.look_at - view.eye).normalize_or_zero();
        let hit = session.bvh().nearest(&Ray { origin: view.eye, direction, t_max: f32::INFINITY })?;
        Some(Place { view: view.clone(), distance: hit.t })
    };
    views.filter_map(place).collect()
}

fn find_truth(
    case: &Case,
    options: &StudyOptions,
    error: f64,
    meter: &Meter<'_>,
    control: Control<'_>,
) -> Result<Truth, StudyError> {
    meter.say(format!("{}: truth", case.id));
    let truth_options = TruthOptions {
        error,
        max_rays: options.truth_rays,
        min_rays: 256,
        // Without a place of their own, truths last as long as the trials do.
        folder: Some(options.truth_folder.clone().unwrap_or_else(|| options.work_folder.clone())),
    };
    Truth::find(case, &truth_options, control, &|done, total| meter.truth(done as f64 / total.max(1) as f64))
}

pub(crate) fn stop_if(cancelled: &AtomicBool) -> Result<(), StudyError> {
    if cancelled.load(Ordering::Relaxed) { Err(StudyError::Interrupted) } else { Ok(()) }
}

/// Unique and fit for file names.
fn case_id(scene: &str, view: &str, earlier: &[CaseReport]) -> String {
    let id = format!("{}-{}", file_name(scene), file_name(view));
    let taken = |id: &str| earlier.iter().any(|case| case.id == id);
    (1..).map(|n| if n == 1 { id.clone() } else { format!("{id}-{n}") }).find(|id| !taken(id)).unwrap_or(id)
}

fn method_report(contender: &dyn Contender) -> MethodReport {
    MethodReport {
        name: contender.name().into(),
        about: contender.about(),
        needs_bvh: contender.needs().bvh,
        needs_octree: contender.needs().octree,
        unavailable: contender.unavailable(),
    }
}

fn request(options: &StudyOptions) -> Request {
    // By way of text, which has the shortest decimals of single-precision numbers.
    let text = serde_json::to_string(&options.settings).unwrap_or_default();
    let settings = match serde_json::from_str(&text) {
        Ok(Value::Object(mut members)) => {
            members.retain(|name, _| name != "method" && name != "rays" && name != "sampling");
            members
        }
        _ => Map::new(),
    };
    Request {
        size: [options.size.0, options.size.1],
        budgets: options.budgets.clone(),
        repeats: options.repeats,
        truth_error: options.truth_error,
        settings,
    }
}
