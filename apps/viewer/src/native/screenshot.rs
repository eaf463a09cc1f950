//! A picture of the window, for documents and tests: `--screenshot`.

use super::{Ending, Failed, options::Options};
use crate::Viewer;
use conray::target::{PngDepth, encode_colour_png, write_atomically};
use egui::{ColorImage, Context};
use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

/// All must have been at rest for so long.
const REST: Duration = Duration::from_millis(600);
/// Nothing takes longer.
const PATIENCE: Duration = Duration::from_secs(600);

/// Shows the viewer until the picture is to be taken.
pub(super) struct Screenshot {
    viewer: Viewer,
    path: PathBuf,
    after: Option<Duration>,
    start: Instant,
    rest_since: Option<Instant>,
    taken: Arc<Mutex<Option<Arc<ColorImage>>>>,
    is_asked: bool,
    ending: Ending,
}

impl Screenshot {
    pub(super) fn new(viewer: Viewer, path: PathBuf, options: &Options, ending: Ending) -> Self {
        let after = options.after.map(Duration::from_secs_f64);
        let (start, taken) = (Instant::now(), Arc::default());
        Self { viewer, path, after, start, rest_since: None, taken, is_asked: false, ending }
    }

    /// True once it is time.
    fn is_time(&mut self) -> bool {
        if let Some(after) = self.after {
            return self.start.elapsed() >= after;
        }
        let rests = self.viewer.is_at_rest();
        let since = *self.rest_since.get_or_insert_with(Instant::now);
        if !rests {
            self.rest_since = None;
        }
        rests && since.elapsed() >= REST
    }

    fn end(&self, ctx: &Context, how: Result<String, Failed>) {
        if let Ok(mut ending) = self.ending.lock() {
            ending.get_or_insert(how);
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

impl eframe::App for Screenshot {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.viewer.show(ui);
        let ctx = ui.ctx().clone();
        let image = self.taken.lock().map(|mut taken| taken.take()).unwrap_or_default();
        if let Some(image) = image {
            let told = self.viewer.facts().to_string();
            self.end(&ctx, write(&self.path, &image).map(|()| told));
        } else if let Some(message) = self.viewer.scene_trouble() {
            self.end(&ctx, Err(Failed { code: 3, message }));
        } else if self.start.elapsed() > PATIENCE {
            self.end(&ctx, Err(Failed { code: 1, message: "it does not come to rest".into() }));
        } else if !self.is_asked && self.is_time() {
            self.is_asked = true;
            let (taken, ctx) = (Arc::clone(&self.taken), ctx.clone());
            ctx.clone().request_screenshot(move |image| {
                if let Ok(mut place) = taken.lock() {
                    *place = Some(image);
                }
                ctx.request_repaint();
            });
        }
        ctx.request_repaint_after(Duration::from_millis(50));
    }
}

fn write(path: &Path, image: &ColorImage) -> Result<(), Failed> {
    let [width, height] = image.size.map(|side| side as u32);
    let codes: Vec<[f32; 3]> =
        image.pixels.iter().map(|c| [c.r(), c.g(), c.b()].map(|code| f32::from(code) / 255.0)).collect();
    let written =
        write_atomically(path, |out| encode_colour_png(out, width, height, &codes, PngDepth::Eight));
    written.map_err(|e| Failed { code: 1, message: e.to_string() })
}
