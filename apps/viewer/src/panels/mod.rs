//! The panels about the picture: controls at the left, what was found at the bottom.

mod compare;
mod found;
mod keys;
mod place;
mod saving;
mod scene;
mod settings;

use crate::{app::Viewer, engine::Source};
use egui::{CollapsingHeader, Panel, ScrollArea, Ui};
pub(crate) use keys::keys;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use scene::source_of;

/// What panels keep between frames besides the choices.
pub(crate) struct Fields {
    /// The name or path of a scene, as typed.
    pub(crate) scene: String,
    /// The path of a truth, as typed.
    pub(crate) truth: String,
    pub(crate) truth_rays: u32,
    /// Part of an adapter's name, as typed.
    pub(crate) adapter: String,
    /// Where pictures are saved to.
    pub(crate) png: String,
    pub(crate) exr: String,
    /// The level of the octree whose nodes are drawn; `None` while they are not.
    pub(crate) boxes: Option<u32>,
    pub(crate) shows_cones: bool,
    pub(crate) shows_rays: bool,
    /// The upper end of a side's colours, where it was chosen by hand.
    pub(crate) ranges: [Option<f32>; 2],
    pub(crate) shows_bottom: bool,
}

impl Fields {
    pub(crate) fn of(source: &Source, boxes: Option<u32>) -> Self {
        Self {
            scene: source.word(),
            truth: String::new(),
            truth_rays: 1024,
            adapter: String::new(),
            png: "view.png".into(),
            exr: "view.exr".into(),
            boxes,
            shows_cones: true,
            shows_rays: true,
            ranges: [None; 2],
            shows_bottom: true,
        }
    }
}

/// All controls, in sections.
pub(crate) fn controls(viewer: &mut Viewer, ui: &mut Ui) {
    Panel::left("controls").default_size(300.0).size_range(240.0..=420.0).show(ui, |ui| {
        ScrollArea::vertical().auto_shrink([false; 2]).show(ui, |ui| {
            let mut section = |title: &str, is_open: bool, show: &mut dyn FnMut(&mut Viewer, &mut Ui)| {
                CollapsingHeader::new(title).default_open(is_open).show(ui, |ui| show(viewer, ui));
            };
            section("Scene", true, &mut scene::scene);
            section("Picture", true, &mut compare::sides);
            section("View", true, &mut scene::view);
            section("Look inside", true, &mut compare::inside);
            section("Truth", false, &mut compare::truth);
            section("Settings", false, &mut settings::settings);
            section("Where it is computed", false, &mut place::place);
            section("Save", false, &mut saving::saving);
            section("Appearance and keys", false, &mut place::appearance);
        });
    });
}

/// Error against time, the probe, and what was told.
pub(crate) fn bottom(viewer: &mut Viewer, ui: &mut Ui) {
    Panel::bottom("status").show(ui, |ui| found::status(viewer, ui));
    if viewer.fields.shows_bottom && ui.available_height() > 320.0 {
        Panel::bottom("found").exact_size(172.0).show(ui, |ui| found::found(viewer, ui));
    }
}

/// Gives a control a name for screen readers and tests, where no text beside it is its own.
fn named(response: &egui::Response, name: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name.to_owned()));
}
