//! `conray sample`: visibility at the vertices of a PLY file.

use crate::{
    args::SampleArgs,
    explain,
    failure::Failure,
    inputs, interrupt,
    render::{estimate, stop_if},
    report::{self, Reporter},
};
use conray::{
    Event, Session,
    scene::Scene,
    target::{self, PointsTarget, Target},
};
use serde_json::json;

pub(crate) fn run(args: &SampleArgs) -> Result<(), Failure> {
    let settings = args.ao.checked()?;
    if args.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("ply")) {
        return Err(Failure::Request(format!("-o {}: must end in .ply", args.output.display())));
    }
    target::check_writable(&args.output)?;
    let reporter = Reporter::new(args.run.json, args.run.quiet);
    let interrupted = interrupt::watch();

    let points = PointsTarget::read(&args.points)?;
    let scene = inputs::load_scene(&args.scene)?;
    reporter.scene_warnings(&scene);
    let options = args.run.options();
    let Scene { name, geometry, .. } = scene;
    let session = Session::build_observed(geometry, &settings, &options, &|e| reporter.event(e))?;
    stop_if(interrupted, "before anything was estimated; no file was written")?;
    let outcome = estimate(&session, &points, None, interrupted, &reporter)?;
    explain::stop_if_nothing(&outcome.work)?;
    if let Some(skipped) = points.skipped() {
        reporter.event(Event::Warning {
            message: format!(
                "{} of {} vertices have a normal of no length (the first is {}); their visibility is NaN",
                skipped.count,
                points.vertex_count(),
                skipped.first
            ),
        });
    }
    points.write(&args.output, &outcome.estimates)?;

    let mut lines =
        vec![format!("{name}: {} points, AO distance {}", points.points().len(), session.plan().distance)];
    lines.extend(report::work_lines(&settings, session.report(), &outcome.work));
    if let Some((visibility, error)) = report::means(&outcome) {
        lines.push(format!("mean visibility {visibility:.4}, expected error {error:.4}"));
    }
    lines.push(format!("wrote {}", args.output.display()));
    report::add_budget(&mut lines, args.ao.explain, session.plan(), &outcome.work);
    let mut facts = report::work_json(&settings, session.report(), &outcome.work);
    facts["scene"] = json!(name);
    facts["mean_visibility"] = json!(report::means(&outcome).map(|m| m.0));
    facts["expected_error"] = json!(report::means(&outcome).map(|m| m.1));
    facts["files"] = json!([args.output]);
    reporter.summary(&lines, facts);
    stop_if(interrupted, "what was done by then has been written")?;
    explain::stop_if_failed(&outcome.work)?;
    explain::check(args.ao.strict, explain::missed(session.plan(), &outcome.work))
}
