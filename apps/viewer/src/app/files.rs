//! Files that come in and go out: dropped, read, saved.

use super::Viewer;
use crate::engine::{Fault, Question, Source};

impl Viewer {
    /// Files dropped on the window: a scene with what belongs to it, or a truth.
    pub(crate) fn take_files(&mut self, sources: Vec<Source>) {
        let ending = |source: &Source| {
            let word = source.word();
            std::path::Path::new(&word).extension().map(|e| e.to_string_lossy().to_lowercase())
        };
        const SCENES: [&str; 5] = ["obj", "gltf", "glb", "ply", "stl"];
        let is_scene = |source: &&Source| ending(source).is_some_and(|e| SCENES.contains(&&e[..]));
        if let Some(scene) = sources.iter().find(is_scene) {
            let scene = match scene {
                Source::Bytes(file, _) => {
                    let beside =
                        sources.iter().filter(|other| *other != scene).filter_map(|other| match other {
                            Source::Bytes(file, _) => Some(file.clone()),
                            _ => None,
                        });
                    Source::Bytes(file.clone(), beside.collect())
                }
                other => other.clone(),
            };
            self.open(scene);
        } else if let Some(image) = sources.iter().find(|s| ending(s).as_deref() == Some("exr")) {
            self.read_truth(image.clone());
        } else if let Some(first) = sources.first() {
            let message =
                format!("{}: no scene (.obj, .gltf, .glb, .ply, .stl) and no truth (.exr)", first.word());
            self.shown.say(Some(Fault::Input), message);
        }
    }

    /// Reads an image to compare with.
    pub(crate) fn read_truth(&mut self, source: Source) {
        if self.last_wish.is_none() {
            self.shown.say(Some(Fault::Request), "open a scene first, then a truth to compare it with");
            return;
        }
        self.ask(Question::ReadExr { key: self.truth_key(), source });
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn take_dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        let sources: Vec<Source> = files.iter().map(|file| Source::File(file.path().into())).collect();
        if !sources.is_empty() {
            self.take_files(sources);
        }
    }

    #[cfg(target_arch = "wasm32")]
    pub(super) fn take_dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|input| input.raw.dropped_files.clone());
        if !files.is_empty() {
            crate::web::read_dropped(files, ctx.clone());
        }
        let read = crate::web::take_read();
        let mut sources = Vec::new();
        for file in read {
            match file {
                Ok(file) => sources.push(Source::Bytes(file, Vec::new())),
                Err(message) => self.shown.say(Some(Fault::Input), message),
            }
        }
        if !sources.is_empty() {
            self.take_files(sources);
        }
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn download(&mut self, name: &str, bytes: &[u8]) {
        let written = conray::target::write_atomically(name, |out| out.write_all(bytes));
        match written {
            Ok(()) => self.shown.say(None, format!("wrote {name}")),
            Err(e) => self.shown.say(Some(Fault::Work), e.to_string()),
        }
    }

    #[cfg(target_arch = "wasm32")]
    pub(super) fn download(&mut self, name: &str, bytes: &[u8]) {
        if let Err(message) = crate::web::download(name, bytes) {
            self.shown.say(Some(Fault::Work), message);
        }
    }

    /// Saves the picture as it is shown.
    pub(crate) fn save_png(&mut self, dark: bool) {
        let Some((size, colours)) = crate::picture::composed(self, dark) else {
            self.shown.say(Some(Fault::Request), "there is no picture to save yet");
            return;
        };
        let mut bytes = Vec::new();
        let depth = conray::target::PngDepth::Eight;
        let encoded = conray::target::encode_colour_png(&mut bytes, size[0], size[1], &colours, depth);
        if let Err(e) = encoded {
            self.shown.say(Some(Fault::Work), format!("the picture cannot be saved: {e}"));
            return;
        }
        let name = self.fields.png.clone();
        self.download(&name, &bytes);
    }
}
