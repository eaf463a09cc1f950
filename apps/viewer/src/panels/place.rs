//! Where estimates are made; how the window looks and which keys it knows.

use super::named;
use crate::app::Viewer;
use conray::Device;
use egui::{ThemePreference, Ui};

pub(super) fn place(viewer: &mut Viewer, ui: &mut Ui) {
    let is_page = cfg!(target_arch = "wasm32");
    let hints = match is_page {
        true => [
            "The browser's graphics processor where it has one, else the CPU",
            "In a worker of this page, on one thread",
            "The browser's WebGPU, also where that is a program on the CPU",
        ],
        false => [
            "A graphics processor where there is one, else the CPU",
            "All cores",
            "A graphics processor, also one that is a program on the CPU",
        ],
    };
    let all = [(Device::Auto, "auto"), (Device::Cpu, "CPU"), (Device::Gpu, "GPU")];
    ui.horizontal(|ui| {
        for ((device, name), hint) in all.into_iter().zip(hints) {
            ui.radio_value(&mut viewer.choices.device, device, name).on_hover_text(hint);
        }
    });
    if is_page {
        places(viewer, ui);
        return;
    }
    ui.horizontal(|ui| {
        ui.label("Adapter");
        let hint = "part of its name";
        let field = egui::TextEdit::singleline(&mut viewer.fields.adapter).hint_text(hint);
        let field = ui.add(field.desired_width(150.0));
        named(&field, "part of the adapter's name");
        if field.lost_focus() {
            viewer.choices.adapter = viewer.fields.adapter.clone();
        }
    });
    places(viewer, ui);
}

/// Where the estimates of each side are made.
fn places(viewer: &Viewer, ui: &mut Ui) {
    for (side, place) in viewer.shown.built.places.iter().enumerate() {
        let name = match (side, viewer.shown.built.places.len()) {
            (_, 1) => "Works on",
            (0, _) => "Left works on",
            _ => "Right works on",
        };
        ui.label(format!("{name}: {place}"));
    }
}

/// What keys and the mouse do, for people.
const KEYS: [(&str, &str); 12] = [
    ("drag", "orbit"),
    ("right or shift-drag", "pan"),
    ("ctrl-drag", "turn the head"),
    ("wheel, pinch, + -", "zoom"),
    ("W A S D Q E", "fly (shift: faster)"),
    ("arrow keys", "orbit, once the picture is clicked"),
    ("click", "probe; double: turn about it"),
    ("L, M", "next layer, next method"),
    ("B", "two side by side"),
    ("T", "find the truth of this view"),
    ("Home", "first view"),
    ("Tab, Space, Escape", "next control, press it, put away"),
];

pub(super) fn appearance(viewer: &mut Viewer, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let mut theme = ui.ctx().options(|options| options.theme_preference);
        for (one, name) in [
            (ThemePreference::System, "as the system"),
            (ThemePreference::Light, "light"),
            (ThemePreference::Dark, "dark"),
        ] {
            if ui.radio_value(&mut theme, one, name).changed() {
                ui.ctx().set_theme(theme);
            }
        }
    });
    ui.checkbox(&mut viewer.fields.shows_bottom, "error against time, and probe");
    egui::Grid::new("keys").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
        for (key, what) in KEYS {
            ui.strong(key);
            ui.label(what);
            ui.end_row();
        }
    });
}
