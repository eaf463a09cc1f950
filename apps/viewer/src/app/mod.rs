//! The application: takes in what has come, lays the window out, and wishes for what was chosen.

mod facts;
mod files;

use crate::{
    camera::Look,
    choices::Choices,
    engine::{Fault, Order, Question, SceneFacts, Source, Wish},
    host::Host,
    panels,
    picture::Canvas,
    shown::{Shown, Then},
};
use std::sync::Arc;

/// What the viewer begins with.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// The scene; the built-in `cornell` unless another is named.
    pub source: Option<Source>,
    /// The name of a view of it.
    pub view: Option<String>,
    /// A camera by its numbers, instead of a view.
    pub look: Option<Look>,
    /// All else.
    pub choices: Choices,
    /// Shows the octree's nodes of that level.
    pub boxes: Option<u32>,
    /// A pixel to be probed once there is a picture, as shares of its width and height.
    pub probe: Option<[f32; 2]>,
    /// Finds the truth by so many rays a pixel once there is a picture.
    pub truth: Option<u32>,
}

/// The viewer's window, whoever shows it.
pub struct Viewer {
    host: Box<dyn Host>,
    pub(crate) choices: Choices,
    pub(crate) shown: Shown,
    pub(crate) canvas: Canvas,
    pub(crate) fields: panels::Fields,
    source: Source,
    last_number: u64,
    /// A view's name or a camera that the next scene is to be seen by.
    start_view: Option<String>,
    start_look: Option<Look>,
    last_wish: Option<Wish>,
    /// A wish is sent again where the engine began anew.
    boxes_asked: Option<(u64, u32)>,
    start: Start,
}

impl Viewer {
    /// A viewer over an engine; it opens the first scene at once.
    pub fn new(host: Box<dyn Host>, start: Start) -> Self {
        let source = start.source.clone().unwrap_or_else(|| Source::Builtin("cornell".into()));
        let mut viewer = Self {
            host,
            choices: start.choices.clone(),
            shown: Shown::default(),
            canvas: Canvas::default(),
            fields: panels::Fields::of(&source, start.boxes),
            source: source.clone(),
            last_number: 0,
            start_view: start.view.clone(),
            start_look: start.look,
            last_wish: None,
            boxes_asked: None,
            start,
        };
        viewer.open(source);
        viewer
    }

    /// Opens a scene; what is shown stays until it is there.
    pub(crate) fn open(&mut self, source: Source) {
        self.last_number += 1;
        self.source = source.clone();
        self.host.order(Order::Open(self.last_number, source));
    }

    /// Asks about what is shown.
    pub(crate) fn ask(&mut self, question: Question) {
        self.shown.busy.get_or_insert_with(|| ("asking".into(), None));
        self.host.order(Order::Ask(question));
    }

    /// What the truth of the present wish is called; empty before the first.
    pub(crate) fn truth_key(&self) -> String {
        self.last_wish.as_ref().map(Choices::truth_key).unwrap_or_default()
    }

    /// The newest wish.
    pub(crate) fn wish(&self) -> Option<&Wish> {
        self.last_wish.as_ref()
    }

    /// One frame.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        self.take_reports();
        self.take_dropped(ui.ctx());
        panels::keys(self, ui.ctx());
        panels::controls(self, ui);
        panels::bottom(self, ui);
        crate::picture::show(self, ui);
        self.send_wish();
        self.ask_for_boxes();
        self.begin_as_asked();
    }

    fn take_reports(&mut self) {
        let key = self.truth_key();
        for report in self.host.reports() {
            match self.shown.take(report, &key) {
                Then::Nothing => {}
                Then::SceneOpened(facts) => self.begin_scene(&facts),
                Then::SceneRefused(number) => {
                    if number == self.last_number && self.shown.scene.is_none() && number == 1 {
                        // Nothing is there to look at yet: the built-in scene stands in.
                        self.open(Source::Builtin("cornell".into()));
                    }
                }
                Then::OpenAgain => {
                    self.last_wish = None;
                    self.open(self.source.clone());
                }
                Then::Download(name, bytes) => self.download(&name, &bytes),
            }
        }
    }

    /// The first look at a scene.
    fn begin_scene(&mut self, facts: &SceneFacts) {
        let named = self.start_view.take();
        let look = match &named {
            Some(name) => {
                let found = facts.views.iter().find(|(view, _)| view == name);
                if found.is_none() {
                    let names: Vec<&str> = facts.views.iter().map(|(name, _)| &name[..]).collect();
                    let message = format!("--view {name}: {} has {}", facts.name, names.join(", "));
                    self.shown.say(Some(Fault::Request), message);
                }
                found.map(|(_, look)| *look)
            }
            None => self.start_look.take(),
        };
        let first = facts.views.first().map(|(_, look)| *look);
        let is_again = self.last_wish.is_none() && self.choices.look.is_some() && self.last_number > 1;
        if !is_again || look.is_some() {
            self.choices.look = look.or(first);
        }
        self.fields.scene = facts.word.clone();
        self.last_wish = None;
    }

    /// Tells the engine what is to be shown, where that has changed.
    fn send_wish(&mut self) {
        let Some(scene) = self.shown.scene.as_ref().map(|scene| scene.number) else { return };
        let Some(wish) = self.choices.wish(scene, self.canvas.room) else { return };
        if self.last_wish.as_ref() != Some(&wish) {
            self.host.order(Order::Wish(Box::new(wish.clone())));
            self.shown.busy.get_or_insert_with(|| ("beginning".into(), None));
            self.last_wish = Some(wish);
        }
    }

    /// Boxes go with the picture: they are asked for again when it shows something else.
    fn ask_for_boxes(&mut self) {
        let Some(level) = self.fields.boxes else {
            self.boxes_asked = None;
            return;
        };
        let Some(picture) = self.shown.picture.as_ref().filter(|picture| !picture.is_preview()) else {
            return;
        };
        let mut words = std::hash::DefaultHasher::new();
        std::hash::Hash::hash(&(self.truth_key(), self.choices.settings.voxels), &mut words);
        let of = (std::hash::Hasher::finish(&words), level);
        let is_current = self.last_wish.as_ref().is_some_and(|wish| wish.look == picture.look);
        if is_current && self.boxes_asked != Some(of) {
            self.boxes_asked = Some(of);
            self.ask(Question::Boxes { level });
        }
    }

    /// What was to be done once there is a picture.
    fn begin_as_asked(&mut self) {
        let (Some(picture), Some(wish)) = (&self.shown.picture, &self.last_wish) else { return };
        if picture.is_preview() || picture.look != wish.look {
            return;
        }
        let [width, height] = picture.wished;
        let key = self.truth_key();
        if let Some(rays) = self.start.truth.take() {
            self.ask(Question::Truth { key, rays });
        }
        if let Some([x, y]) = self.start.probe.take() {
            let pixel = [(x * width as f32) as u32, (y * height as f32) as u32];
            self.ask(Question::Probe { pixel, side: 0 });
        }
    }

    /// The program's words for a side; empty before the first picture.
    pub(crate) fn command(&self, side: usize) -> String {
        let (Some(scene), Some(wish)) = (self.shown.scene.as_deref(), &self.last_wish) else {
            return String::new();
        };
        let Some(settings) = wish.sides.get(side) else { return String::new() };
        let adapter = wish.adapter.as_deref();
        let words = crate::save::command(scene, &wish.look, wish.size, settings, wish.device, adapter);
        crate::save::shell_line(&words)
    }

    pub(crate) fn scene(&self) -> Option<&Arc<SceneFacts>> {
        self.shown.scene.as_ref()
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.show(ui);
    }

    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }
}
