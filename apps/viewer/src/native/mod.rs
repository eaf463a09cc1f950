//! The program: options, the window, and runs without anybody before the window.

mod measure;
mod options;
mod screenshot;

use crate::{Viewer, host::ThreadHost};
use clap::Parser;
use measure::Measure;
use options::Options;
use screenshot::Screenshot;
use std::{process::ExitCode, sync::Arc};

/// How the program ended, for runs that end by themselves.
pub(crate) type Ending = Arc<std::sync::Mutex<Option<Result<String, Failed>>>>;

/// Why a run failed, with its exit code.
#[derive(Debug)]
pub(crate) struct Failed {
    code: u8,
    message: String,
}

/// Runs the program by the words of its command line.
pub fn main() -> ExitCode {
    let options = Options::parse();
    match run(&options) {
        Ok(told) => {
            if !told.is_empty() {
                println!("{told}");
            }
            ExitCode::SUCCESS
        }
        Err(failed) => {
            eprintln!("conray-viewer: {}", failed.message);
            ExitCode::from(failed.code)
        }
    }
}

fn run(options: &Options) -> Result<String, Failed> {
    let start = options.start()?;
    let viewport = egui::ViewportBuilder::default()
        .with_title("conray")
        .with_app_id("conray-viewer")
        .with_inner_size(options.window())
        .with_min_inner_size([480.0, 320.0])
        .with_drag_and_drop(true);
    let native = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    let ending = Ending::default();
    let ends_itself = options.screenshot.is_some() || options.measure;
    let (told, options) = (Arc::clone(&ending), options.clone());
    let opened = eframe::run_native(
        "conray",
        native,
        Box::new(move |context| {
            let ctx = context.egui_ctx.clone();
            ctx.set_theme(options.theme());
            let host = ThreadHost::start(move || ctx.request_repaint());
            let viewer = Viewer::new(Box::new(host), start);
            Ok(match (&options.screenshot, options.measure) {
                (Some(path), _) => Box::new(Screenshot::new(viewer, path.clone(), &options, told)),
                (None, true) => Box::new(Measure::new(viewer, told)),
                (None, false) => Box::new(viewer),
            })
        }),
    );
    opened.map_err(|e| Failed { code: 1, message: format!("no window can be opened: {e}") })?;
    let ended = ending.lock().map(|mut ending| ending.take());
    match ended {
        Ok(Some(ended)) => ended,
        _ if ends_itself => Err(Failed { code: 1, message: "the window was closed before the end".into() }),
        _ => Ok(String::new()),
    }
}
