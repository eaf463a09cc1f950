//! What was found: error against time, the probed point, and what was told.

use crate::{
    app::Viewer,
    curve,
    engine::{Fault, Probe},
    text::short,
};
use egui::{Color32, RichText, ScrollArea, Ui, vec2};

/// One line: what is worked on, and the newest message.
pub(super) fn status(viewer: &mut Viewer, ui: &mut Ui) {
    ui.horizontal(|ui| {
        match &viewer.shown.busy {
            Some((what, share)) => {
                let share = share.map_or(String::new(), |share| format!(" {:.0} %", 100.0 * share));
                ui.add_sized(vec2(150.0, 16.0), egui::Label::new(format!("{what}{share}")).truncate());
            }
            None => {
                ui.add_sized(vec2(150.0, 16.0), egui::Label::new("at rest"));
            }
        }
        ui.separator();
        for place in viewer.shown.built.places.iter().take(1) {
            ui.add(egui::Label::new(place).truncate());
            ui.separator();
        }
        if !viewer.shown.has_news {
            ui.weak("drag to orbit, wheel to zoom, click to probe");
            return;
        }
        if let Some(message) = viewer.shown.messages.last() {
            if ui.button("Put away").clicked() {
                viewer.shown.has_news = false;
                return;
            }
            let text = RichText::new(&message.text);
            let text = match message.fault {
                Some(fault) => text.color(colour(fault, ui.visuals().dark_mode)).strong(),
                None => text,
            };
            ui.add(egui::Label::new(text).truncate()).on_hover_text(&message.text);
        }
    });
}

fn colour(fault: Fault, dark: bool) -> Color32 {
    match (fault, dark) {
        (Fault::Request, true) => Color32::from_rgb(255, 200, 90),
        (Fault::Request, false) => Color32::from_rgb(140, 85, 0),
        (_, true) => Color32::from_rgb(255, 130, 120),
        (_, false) => Color32::from_rgb(175, 20, 20),
    }
}

/// Three columns: the curve, the probe, the messages.
pub(super) fn found(viewer: &mut Viewer, ui: &mut Ui) {
    let goal = viewer.choices.settings.error;
    let height = ui.available_height();
    let width = (ui.available_width() - 24.0) / 3.0;
    ui.horizontal_top(|ui| {
        curve::show(ui, &viewer.shown.curves, goal, vec2(width, height));
        ui.separator();
        column(ui, "probe", [width, height], |ui| match &viewer.shown.probe {
            Some(probe) => probed(viewer, probe, ui),
            None => {
                ui.weak(
                    "Click on the picture: what a point's cones and rays say is shown here, and drawn there.",
                );
            }
        });
        ui.separator();
        column(ui, "messages", [width, height], |ui| {
            if viewer.shown.messages.is_empty() {
                ui.weak("Nothing to tell.");
            }
            for message in viewer.shown.messages.iter().rev() {
                let text = RichText::new(&message.text);
                let dark = ui.visuals().dark_mode;
                ui.label(message.fault.map_or(text.clone(), |fault| text.color(colour(fault, dark))));
            }
        });
    });
}

fn column(ui: &mut Ui, name: &str, [width, height]: [f32; 2], show: impl FnOnce(&mut Ui)) {
    ui.allocate_ui(vec2(width, height), |ui| {
        ScrollArea::vertical().id_salt(name).auto_shrink([false; 2]).show(ui, |ui| {
            ui.vertical(show);
        });
    });
}

fn probed(viewer: &Viewer, probe: &Probe, ui: &mut Ui) {
    let [x, y] = probe.pixel;
    let [px, py, pz] = probe.position.map(|v| short(v.into()));
    ui.label(format!("pixel {x}, {y} at {px}, {py}, {pz}"));
    if let Some(picture) = &viewer.shown.picture {
        let is_same = picture.look == viewer.wish().map_or(picture.look, |wish| wish.look);
        let [width, height] = picture.size;
        let column = u64::from(x) * u64::from(width) / u64::from(picture.wished[0].max(1));
        let row = u64::from(y) * u64::from(height) / u64::from(picture.wished[1].max(1));
        let at = (row * u64::from(width) + column) as usize;
        for side in picture.sides.iter().filter(|_| is_same) {
            let value = |plane: &[f32]| plane.get(at).map_or("-".into(), |v| short((*v).into()));
            let mut text = format!(
                "{}: visibility {}, error {}, rays {}",
                side.method,
                value(&side.visibility),
                value(&side.error),
                value(&side.rays)
            );
            if let Some(cones) = &side.cones {
                let (epsilon, alpha) = (value(&cones.error), value(&cones.alpha));
                text += &format!("; cones {}, epsilon {epsilon}, alpha {alpha}", value(&cones.visibility));
            }
            if let Some(truth) = viewer.shown.truth(&viewer.truth_key()) {
                text += &format!("; truth {}", value(&truth.visibility));
            }
            ui.label(text);
        }
    }
    let open = probe.rays.iter().filter(|(_, hit)| hit.is_none()).count();
    ui.label(format!(
        "{open} of {} rays drawn are open; AO distance {}",
        probe.rays.len(),
        short(probe.distance.into())
    ));
    if probe.cones.is_empty() {
        ui.weak("No cones: there is no octree. Choose method cones or paper, or octree as boxes.");
        return;
    }
    egui::Grid::new("cones").num_columns(5).spacing([12.0, 1.0]).striped(true).show(ui, |ui| {
        for title in ["cone", "visibility", "epsilon", "alpha", "rays"] {
            ui.strong(title);
        }
        ui.end_row();
        for (index, cone) in probe.cones.iter().enumerate() {
            ui.label((index + 1).to_string());
            for value in [cone.visibility, cone.error, cone.alpha] {
                ui.label(short(value.into()));
            }
            ui.label(cone.rays.to_string());
            ui.end_row();
        }
    });
}
