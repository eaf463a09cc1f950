//! Keys that work wherever the focus is, but while text is typed.

use crate::{app::Viewer, engine::Question, layers::Layer, panels::scene::reset_view};
use conray::Method;
use egui::{Context, Key};

/// Applies the keys of this frame.
pub(crate) fn keys(viewer: &mut Viewer, ctx: &Context) {
    let types_text = ctx.text_edit_focused();
    if types_text {
        return;
    }
    let pressed = |key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
    if pressed(Key::L) {
        viewer.choices.layers[0] = after(&Layer::ALL, viewer.choices.layers[0]);
    }
    if pressed(Key::M) {
        viewer.choices.settings.method = after(&Method::ALL, viewer.choices.settings.method);
    }
    if pressed(Key::B) {
        viewer.choices.is_split = !viewer.choices.is_split;
    }
    if pressed(Key::T) {
        let (key, rays) = (viewer.truth_key(), viewer.fields.truth_rays);
        viewer.ask(Question::Truth { key, rays });
    }
    if pressed(Key::Home) {
        reset_view(viewer);
    }
    if pressed(Key::Escape) {
        viewer.shown.probe = None;
        viewer.shown.has_news = false;
    }
}

/// The next of a list, the first after the last.
fn after<T: Copy + PartialEq>(all: &[T], one: T) -> T {
    let at = all.iter().position(|other| *other == one).map_or(0, |at| at + 1);
    all[at % all.len()]
}
