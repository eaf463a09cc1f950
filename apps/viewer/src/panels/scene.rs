//! Which scene, and from where.

use super::named;
use crate::{app::Viewer, choices::PictureSize, engine::Source, text::count};
use conray::scene::BUILTIN_NAMES;
use egui::{ComboBox, DragValue, Slider, Ui};

/// The largest side of a picture that is chosen by hand.
const MOST_SIDE: u32 = 4096;

pub(super) fn scene(viewer: &mut Viewer, ui: &mut Ui) {
    let name = viewer.scene().map_or("no scene yet".to_owned(), |scene| scene.name.clone());
    ui.horizontal(|ui| {
        ui.label("Built in");
        let mut chosen = None;
        let list = ComboBox::from_id_salt("built-in scene").selected_text(name).width(150.0);
        let list = list.show_ui(ui, |ui| {
            for builtin in BUILTIN_NAMES {
                let is_open = viewer.fields.scene == builtin;
                if ui.selectable_label(is_open, builtin).clicked() {
                    chosen = Some(Source::Builtin(builtin.into()));
                }
            }
        });
        named(&list.response, "built-in scene");
        if let Some(source) = chosen {
            viewer.open(source);
        }
    });
    if cfg!(target_arch = "wasm32") {
        ui.label("Or drop a model on the page. Nothing leaves this machine.");
    } else {
        ui.horizontal(|ui| {
            let width = ui.available_width() - 60.0;
            let field = egui::TextEdit::singleline(&mut viewer.fields.scene).desired_width(width);
            let field = ui.add(field.hint_text("path of a model"));
            named(&field, "path of a model");
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            if ui.button("Open").clicked() || entered {
                let word = viewer.fields.scene.trim().to_owned();
                viewer.open(source_of(&word));
            }
        });
        ui.weak("or drop a model on the window");
    }
    let Some(scene) = viewer.scene().cloned() else { return };
    ui.label(format!("{}: {} triangles", scene.name, count(scene.triangles)));
    if !scene.warnings.is_empty() {
        ui.collapsing(format!("{} oddities", scene.warnings.len()), |ui| {
            for warning in &scene.warnings {
                ui.label(warning);
            }
        });
    }
}

/// A built-in scene by its name, else a file.
pub(crate) fn source_of(word: &str) -> Source {
    if BUILTIN_NAMES.contains(&word) { Source::Builtin(word.into()) } else { Source::File(word.into()) }
}

pub(super) fn view(viewer: &mut Viewer, ui: &mut Ui) {
    if let (Some(scene), Some(look)) = (viewer.scene().cloned(), viewer.choices.look) {
        let current = scene.views.iter().find(|(_, view)| *view == look);
        let name = current.map_or("moved".to_owned(), |(name, _)| name.clone());
        ui.horizontal(|ui| {
            ui.label("View");
            let list = ComboBox::from_id_salt("view").selected_text(name).width(150.0).show_ui(ui, |ui| {
                for (name, view) in &scene.views {
                    if ui.selectable_label(*view == look, name).clicked() {
                        viewer.choices.look = Some(*view);
                    }
                }
            });
            named(&list.response, "view");
            let reset = ui.button("Reset").on_hover_text("Back to the first view (Home)");
            if reset.clicked() {
                reset_view(viewer);
            }
        });
        let mut fov = look.vertical_fov_deg;
        let slider = Slider::new(&mut fov, 5.0..=140.0).suffix(" deg").text("field of view");
        if ui.add(slider).on_hover_text("Vertical, from 5 to 140 degrees").changed() {
            viewer.choices.look =
                viewer.choices.look.map(|look| crate::camera::Look { vertical_fov_deg: fov, ..look });
        }
    }
    let mut is_fixed = matches!(viewer.choices.size, PictureSize::Fixed(_));
    ui.horizontal(|ui| {
        if ui.checkbox(&mut is_fixed, "fixed size").on_hover_text("Else as large as there is room").changed()
        {
            let room = viewer.canvas.room.map(|side| side.clamp(1, MOST_SIDE));
            viewer.choices.size = if is_fixed { PictureSize::Fixed(room) } else { PictureSize::Fit };
        }
        if let PictureSize::Fixed([width, height]) = &mut viewer.choices.size {
            named(&ui.add(DragValue::new(width).range(1..=MOST_SIDE).suffix(" px")), "width");
            ui.label("x");
            named(&ui.add(DragValue::new(height).range(1..=MOST_SIDE).suffix(" px")), "height");
        }
    });
}

/// Back to the scene's first view.
pub(super) fn reset_view(viewer: &mut Viewer) {
    let first = viewer.scene().and_then(|scene| scene.views.first()).map(|(_, look)| *look);
    viewer.choices.look = first.or(viewer.choices.look);
}
