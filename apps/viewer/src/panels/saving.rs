//! Files, and the command that makes the same picture.

use super::named;
use crate::{app::Viewer, engine::Question};
use egui::Ui;

pub(super) fn saving(viewer: &mut Viewer, ui: &mut Ui) {
    let dark = ui.visuals().dark_mode;
    let sides = if viewer.choices.is_split { 2 } else { 1 };
    let on_page = cfg!(target_arch = "wasm32");
    ui.horizontal(|ui| {
        path(ui, &mut viewer.fields.png, "file of the PNG");
        if ui
            .button("Save PNG")
            .on_hover_text("The picture as it is shown, without what is drawn over it")
            .clicked()
        {
            viewer.save_png(dark);
        }
    });
    ui.horizontal(|ui| {
        path(ui, &mut viewer.fields.exr, "file of the EXR");
        for side in 0..sides {
            let name = match (sides, side) {
                (1, _) => "Save EXR",
                (_, 0) => "EXR, left",
                _ => "EXR, right",
            };
            let hint = "All layers as numbers, the settings in the header";
            if ui.button(name).on_hover_text(hint).clicked() {
                let path = (!on_page).then(|| viewer.fields.exr.trim().into());
                viewer.ask(Question::Exr { side, path });
            }
        }
    });
    for side in 0..sides {
        let mut command = viewer.command(side);
        if command.is_empty() {
            continue;
        }
        ui.label(["This picture by the program:", "That at the right:"][side]);
        let id = ui.scope_id().with(("command", side));
        let field = egui::TextEdit::multiline(&mut command).id(id).code_editor().desired_rows(3);
        named(&ui.add(field.desired_width(f32::INFINITY)), "command");
        if ui.button("Copy").clicked() {
            ui.ctx().copy_text(command);
        }
    }
}

fn path(ui: &mut Ui, path: &mut String, name: &str) {
    named(&ui.add(egui::TextEdit::singleline(path).desired_width(110.0)), name);
}
