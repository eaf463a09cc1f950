//! What the program tells while it works and when it is done.

use crate::explain;
use conray::{
    AoPlan, AoSettings, Budget, BuildReport, Event, Outcome, Stage, Work, changed_settings, scene::Scene,
};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::Write;

/// Sends events to a progress bar, or to standard output as JSON lines.
pub(crate) struct Reporter {
    json: bool,
    quiet: bool,
    bar: ProgressBar,
}

impl Reporter {
    pub(crate) fn new(json: bool, quiet: bool) -> Self {
        // indicatif draws nothing where standard error is no terminal.
        let bar = if json || quiet { ProgressBar::hidden() } else { ProgressBar::new(0) };
        bar.set_style(
            ProgressStyle::with_template("{msg:8} {wide_bar} {percent:>3} %  {eta} left")
                .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        Self { json, quiet, bar }
    }

    /// Passes one event on.
    pub(crate) fn event(&self, event: Event) {
        if self.json {
            self.json_line(&event_json(&event));
        }
        match event {
            Event::Started { stage } => {
                self.bar.set_message(stage.name());
                self.bar.tick();
            }
            Event::Progress { done, total, .. } => {
                self.bar.set_length(total);
                self.bar.set_position(done);
            }
            Event::Finished { stage, .. } => {
                if stage == Stage::Estimate {
                    self.bar.finish_and_clear();
                }
            }
            Event::Warning { message } => self.warn(&message),
        }
    }

    /// How far a study is; at most about a thousand JSON lines.
    pub(crate) fn study_progress(&self, what: &str, done: u64, total: u64) {
        let moved = self.bar.message() != what
            || done * 1000 / total.max(1) != self.bar.position() * 1000 / total.max(1);
        if self.json && moved {
            self.json_line(&json!({ "event": "progress", "what": what, "done": done, "total": total }));
        }
        self.bar.set_length(total);
        self.bar.set_message(what.to_owned());
        self.bar.set_position(done);
    }

    /// Tells about something odd, on standard error.
    pub(crate) fn warn(&self, message: &str) {
        self.bar.suspend(|| eprintln!("warning: {message}"));
    }

    /// Tells what is odd about a scene, in one line a kind.
    pub(crate) fn scene_warnings(&self, scene: &Scene) {
        for warning in &scene.warnings {
            self.event(Event::Warning { message: format!("{}: {warning}", scene.name) });
        }
    }

    /// The one summary at the end: lines for people, or one JSON line.
    pub(crate) fn summary(&self, lines: &[String], facts: Value) {
        self.bar.finish_and_clear();
        if self.json {
            let mut line = json!({ "event": "summary" });
            if let (Value::Object(line), Value::Object(facts)) = (&mut line, facts) {
                line.extend(facts);
            }
            self.json_line(&line);
        } else if !self.quiet {
            print_lines(lines);
        }
    }

    fn json_line(&self, value: &Value) {
        print_lines(&[value.to_string()]);
    }
}

/// Prints to standard output; a reader that went away is no reason to fail.
pub(crate) fn print_lines(lines: &[String]) {
    let mut out = std::io::stdout().lock();
    for line in lines {
        let _ = writeln!(out, "{line}");
    }
}

fn event_json(event: &Event) -> Value {
    match event {
        Event::Started { stage } => json!({ "event": "started", "stage": stage.name() }),
        Event::Progress { stage, done, total } => {
            json!({ "event": "progress", "stage": stage.name(), "done": done, "total": total })
        }
        Event::Finished { stage, seconds } => {
            json!({ "event": "finished", "stage": stage.name(), "seconds": seconds })
        }
        Event::Warning { message } => json!({ "event": "warning", "message": message }),
    }
}

/// Lines about builds, work and memory.
pub(crate) fn work_lines(settings: &AoSettings, build: &BuildReport, work: &Work) -> Vec<String> {
    let mut builds = format!("BVH {:.2} s, {}", build.bvh_seconds, bytes(build.bvh_bytes));
    if build.voxels > 0 {
        builds += &format!(
            "; octree of {} voxels {:.2} s, {}",
            build.voxels,
            build.octree_seconds,
            bytes(build.octree_bytes)
        );
    }
    let mut took = format!("method {}: {:.2} s", settings.method, work.seconds);
    for (count, what) in [(work.rays, "rays"), (work.cones, "cones")] {
        if count > 0 {
            took += &format!(", {} {what}", millions(count));
        }
    }
    if build.device != "CPU" {
        took += &format!(", on {}", build.device);
    }
    let mut lines = vec![builds, took];
    if let Some(peak) = peak_memory() {
        lines.push(format!("peak memory {}", bytes(peak)));
    }
    let changed: Vec<String> =
        changed_settings(settings).into_iter().map(|(name, value)| format!("--{name} {value}")).collect();
    if !changed.is_empty() {
        lines.push(format!("settings other than the defaults: {}", changed.join(" ")));
    }
    lines
}

/// Adds whether the error was missed and, where asked for, the plan.
pub(crate) fn add_budget(lines: &mut Vec<String>, explained: bool, plan: &AoPlan, work: &Work) {
    lines.extend(explain::missed(plan, work));
    if explained {
        lines.extend(explain::lines(plan, work));
    }
}

/// The same facts for programs.
pub(crate) fn work_json(settings: &AoSettings, build: &BuildReport, work: &Work) -> Value {
    json!({
        "completed": work.completed,
        "ended": work.ended,
        "expected_rmse": Some(work.expected_rmse).filter(|e| e.is_finite()),
        "target_error": target_error(settings),
        "plan": work.explanation,
        "bvh": { "seconds": build.bvh_seconds, "bytes": build.bvh_bytes },
        "octree": { "seconds": build.octree_seconds, "bytes": build.octree_bytes, "voxels": build.voxels },
        "device": build.device,
        "seconds": work.seconds,
        "points": work.points,
        "rays": work.rays,
        "cones": work.cones,
        "peak_memory_bytes": peak_memory(),
        "settings": settings,
        "changed_settings": changed_settings(settings).into_iter().collect::<std::collections::BTreeMap<_, _>>(),
    })
}

/// The error that is to be reached, where there is one.
pub(crate) fn target_error(settings: &AoSettings) -> Option<f32> {
    Budget::of(settings).error.filter(|_| settings.method.has_budget())
}

/// Mean visibility and expected error over the points that were reached.
pub(crate) fn means(outcome: &Outcome) -> Option<(f64, f64)> {
    let reached = || outcome.estimates.iter().filter(|e| !e.is_pending() && e.error.is_finite());
    let count = reached().count() as f64;
    let visibility = reached().map(|e| f64::from(e.visibility)).sum::<f64>() / count;
    let squared_error = reached().map(|e| f64::from(e.error).powi(2)).sum::<f64>() / count;
    (count > 0.0).then(|| (visibility, squared_error.sqrt()))
}

/// Most memory that the process has held, where the system tells.
pub(crate) fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// Bytes for people.
pub(crate) fn bytes(count: u64) -> String {
    match count {
        0..10_000_000 => format!("{:.1} kB", count as f64 / 1e3),
        10_000_000..10_000_000_000 => format!("{:.0} MB", count as f64 / 1e6),
        _ => format!("{:.1} GB", count as f64 / 1e9),
    }
}

fn millions(count: u64) -> String {
    if count < 1_000_000 { count.to_string() } else { format!("{:.1} million", count as f64 / 1e6) }
}
