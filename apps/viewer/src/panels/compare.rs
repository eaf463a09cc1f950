//! Which methods and layers are shown, what is drawn over them, and what they are compared with.

use super::named;
use crate::{
    app::Viewer,
    engine::{Question, Source},
    layers::Layer,
    text::short,
};
use conray::Method;
use egui::{ComboBox, DragValue, Slider, Ui};

/// The octree's level that is drawn first: nodes of sixteen leaves a side.
const FIRST_LEVEL: u32 = 4;

pub(super) fn sides(viewer: &mut Viewer, ui: &mut Ui) {
    let is_split = viewer.choices.is_split;
    let mut method = viewer.choices.settings.method;
    side(viewer, ui, 0, if is_split { "Left" } else { "Show" }, &mut method);
    viewer.choices.settings.method = method;
    ui.checkbox(&mut viewer.choices.is_split, "two side by side (B)")
        .on_hover_text("Two methods, or two layers of one, with a line between them to drag");
    if viewer.choices.is_split {
        let mut method = viewer.choices.right_method;
        side(viewer, ui, 1, "Right", &mut method);
        viewer.choices.right_method = method;
        ui.add(Slider::new(&mut viewer.choices.split_at, 0.0..=1.0).text("split at").fixed_decimals(2));
    }
}

fn side(viewer: &mut Viewer, ui: &mut Ui, side: usize, label: &str, method: &mut Method) {
    ui.horizontal(|ui| {
        ui.label(label);
        let list = ComboBox::from_id_salt(("method", side)).selected_text(method.to_string()).width(70.0);
        let list = list.show_ui(ui, |ui| {
            for one in Method::ALL {
                ui.selectable_value(method, one, one.to_string()).on_hover_text(about(one));
            }
        });
        named(&list.response, ["method", "method at the right"][side]);
        let layer = &mut viewer.choices.layers[side];
        let list = ComboBox::from_id_salt(("layer", side)).selected_text(layer.name()).width(150.0);
        let list = list.show_ui(ui, |ui| {
            for one in Layer::ALL {
                ui.selectable_value(layer, one, one.name());
            }
        });
        named(&list.response, ["layer", "layer at the right"][side]);
    });
    let layer = viewer.choices.layers[side];
    if layer.needs_cones() && !method.needs_octree() {
        ui.horizontal(|ui| {
            ui.label(format!("{method} marches no cones."));
            if ui.button("Use paper").clicked() {
                *method = Method::Paper;
            }
        });
    }
    if layer.map().is_some() && layer.fixed_range().is_none() {
        let shown = viewer.canvas.range(side).map_or(1.0, |range| range.high);
        let chosen = &mut viewer.fields.ranges[side];
        ui.horizontal(|ui| {
            let mut is_auto = chosen.is_none();
            if ui.checkbox(&mut is_auto, "range by the picture").changed() {
                *chosen = (!is_auto).then_some(shown);
            }
            if let Some(high) = chosen {
                let speed = (*high * 0.02).max(1e-4);
                let value = DragValue::new(high).range(1e-5..=1e6).speed(speed).max_decimals(5);
                named(&ui.add(value), "upper end of the colours");
            }
        });
    }
}

fn about(method: Method) -> &'static str {
    match method {
        Method::Rays => "Rays alone: unbiased, noisy with few",
        Method::Cones => "Cones alone: no noise, some bias",
        Method::Paper => "The published blend of both",
        Method::Hybrid => "conray's own: rays where they help most, pooled with like neighbours",
    }
}

pub(super) fn inside(viewer: &mut Viewer, ui: &mut Ui) {
    let levels = viewer.shown.built.levels;
    let mut shows = viewer.fields.boxes.is_some();
    let hint = "The nodes of one level that the seen surfaces lie in, coloured by mean opacity";
    if ui.checkbox(&mut shows, "octree as boxes").on_hover_text(hint).changed() {
        viewer.fields.boxes = shows.then_some(FIRST_LEVEL);
    }
    if let Some(level) = &mut viewer.fields.boxes {
        // Before an octree is there nothing is known of its levels.
        let most = if levels > 0 { levels - 1 } else { (*level).max(FIRST_LEVEL) };
        ui.add(Slider::new(level, 0..=most).text("level (0: leaves)"));
    }
    ui.horizontal(|ui| {
        ui.checkbox(&mut viewer.fields.shows_cones, "cones");
        ui.checkbox(&mut viewer.fields.shows_rays, "rays");
        ui.label("of the probe");
    });
    ui.weak("Click on the picture to probe a point.");
}

pub(super) fn truth(viewer: &mut Viewer, ui: &mut Ui) {
    let key = viewer.truth_key();
    match viewer.shown.truth(&key) {
        Some(truth) => {
            let state = if truth.done < 1.0 { "so far, " } else { "" };
            ui.label(format!("Truth {state}{}.", truth.origin));
        }
        None => {
            ui.label("No truth of this view and size yet.");
        }
    }
    for (side, measured) in viewer.shown.measured.clone().iter().enumerate() {
        if let (Some(rmse), Some(picture)) = (measured, &viewer.shown.picture) {
            let method = picture.sides[side].method;
            ui.label(format!("{method}: RMSE {} against it", short(*rmse)));
        }
    }
    ui.horizontal(|ui| {
        let rays = DragValue::new(&mut viewer.fields.truth_rays).range(64..=16384).suffix(" rays a pixel");
        named(&ui.add(rays), "rays a pixel of the truth");
        if ui
            .button("Find it")
            .on_hover_text("By rays of another seed (T); refining goes on after it")
            .clicked()
        {
            viewer.ask(Question::Truth { key: key.clone(), rays: viewer.fields.truth_rays });
        }
        if ui.button("Stop").clicked() {
            viewer.ask(Question::StopTruth);
        }
    });
    if cfg!(target_arch = "wasm32") {
        ui.weak("Or drop an EXR of the same size on the page.");
        return;
    }
    ui.horizontal(|ui| {
        let width = ui.available_width() - 60.0;
        let field = egui::TextEdit::singleline(&mut viewer.fields.truth).desired_width(width);
        named(&ui.add(field.hint_text("path of an EXR")), "path of an EXR");
        if ui.button("Read").clicked() {
            let source = Source::File(viewer.fields.truth.trim().into());
            viewer.read_truth(source);
        }
    });
    ui.weak("or drop an EXR of the same size on the window");
}
