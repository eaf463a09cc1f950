//! Settings with their ranges, each with its way back.

use super::named;
use crate::{app::Viewer, choices::default_settings};
use conray::{Alpha, AoSettings, Distance, Epsilon, Falloff, Method, Sampling, limits};
use egui::{ComboBox, DragValue, Slider, Ui};

pub(super) fn settings(viewer: &mut Viewer, ui: &mut Ui) {
    let defaults = default_settings();
    let methods: Vec<Method> = viewer.choices.sides().iter().map(|side| side.method).collect();
    let diagonal = viewer.scene().map_or(1.0, |scene| scene.diagonal);
    let in_world = viewer.shown.built.distance;
    let settings = &mut viewer.choices.settings;
    distance(ui, settings, &defaults, diagonal, in_world);
    budget(ui, settings, &defaults);
    let with_rays = methods.iter().any(|method| method.has_budget());
    ui.add_enabled_ui(with_rays, |ui| directions(ui, settings, &defaults));
    let with_cones = methods.iter().any(|method| method.needs_octree());
    ui.add_enabled_ui(with_cones, |ui| cones(ui, settings, &defaults));
    ui.add_enabled_ui(methods.contains(&Method::Paper), |ui| blend(ui, settings, &defaults));
    general(ui, settings, &defaults);
    ui.horizontal(|ui| {
        if ui.button("Reset all").clicked() {
            *settings = AoSettings { method: settings.method, ..defaults };
        }
        if ui.button("Begin anew").on_hover_text("The same once more, from the first ray").clicked() {
            viewer.choices.again += 1;
        }
    });
}

/// A row with a way back, shown where the value is not its default.
fn row<T: PartialEq + Clone>(
    ui: &mut Ui,
    name: &str,
    hint: &str,
    value: &mut T,
    default: &T,
    show: impl FnOnce(&mut Ui, &mut T),
) {
    ui.horizontal(|ui| {
        ui.add_sized([82.0, 16.0], egui::Label::new(name).truncate()).on_hover_text(hint);
        ui.scope(|ui| show(ui, value)).response.on_hover_text(hint);
        if value != default
            && ui.small_button("reset").on_hover_text(format!("Back to the default of {name}")).clicked()
        {
            *value = default.clone();
        }
    });
}

fn distance(ui: &mut Ui, settings: &mut AoSettings, defaults: &AoSettings, diagonal: f32, in_world: f32) {
    let hint = "How far an occluder counts, in world units; auto is a tenth of the scene's diagonal";
    row(ui, "distance", hint, &mut settings.distance, &defaults.distance, |ui, value| {
        let name = match value {
            Distance::Auto => "auto",
            Distance::World(_) => "units",
            Distance::Infinite => "infinite",
        };
        let list = ComboBox::from_id_salt("distance").selected_text(name).width(66.0);
        let list = list.show_ui(ui, |ui| {
            let world = if in_world.is_finite() && in_world > 0.0 { in_world } else { 0.1 * diagonal };
            ui.selectable_value(value, Distance::Auto, "auto");
            ui.selectable_value(value, Distance::World(world), "units");
            ui.selectable_value(value, Distance::Infinite, "infinite");
        });
        named(&list.response, "distance");
        if let Distance::World(world) = value {
            let range = diagonal * 1e-4..=diagonal * 10.0;
            named(
                &ui.add(DragValue::new(world).range(range).speed(0.003 * diagonal).max_decimals(4)),
                "distance",
            );
        }
    });
    let hint = "How an occluder's weight fades with its distance; needs a finite distance";
    row(ui, "falloff", hint, &mut settings.falloff, &defaults.falloff, |ui, value| {
        let list = ComboBox::from_id_salt("falloff").selected_text(value.to_string()).width(80.0);
        let list = list.show_ui(ui, |ui| {
            for one in [Falloff::None, Falloff::Linear, Falloff::Smooth] {
                ui.selectable_value(value, one, one.to_string());
            }
        });
        named(&list.response, "falloff");
    });
}

fn budget(ui: &mut Ui, settings: &mut AoSettings, defaults: &AoSettings) {
    let hint = "Refining ends at this expected RMSE, from 0.00001 to 0.5 (rays and hybrid)";
    row(ui, "until error", hint, &mut settings.error, &defaults.error, |ui, value| {
        let default = defaults.error.unwrap_or(0.005);
        optional(ui, "until error", value, default, |ui, error| {
            named(
                &ui.add(Slider::new(error, limits::ERROR).logarithmic(true).max_decimals(5)),
                "until error",
            );
        });
    });
    let hint = "Most rays a pixel, from 1 to 1048576 (rays and hybrid); powers of two err least";
    row(ui, "most rays", hint, &mut settings.rays, &defaults.rays, |ui, value| {
        optional(ui, "most rays", value, 256, |ui, rays| {
            named(&ui.add(Slider::new(rays, limits::RAYS).logarithmic(true)), "most rays");
        });
    });
    let hint = "Most seconds of estimation (rays and hybrid)";
    row(ui, "most time", hint, &mut settings.time, &defaults.time, |ui, value| {
        optional(ui, "most time", value, 10.0, |ui, seconds| {
            named(&ui.add(Slider::new(seconds, 0.01..=3600.0).logarithmic(true).suffix(" s")), "most time");
        });
    });
}

/// A value that may be absent, with a box to say whether it is.
fn optional<T: Copy>(
    ui: &mut Ui,
    name: &str,
    value: &mut Option<T>,
    otherwise: T,
    show: impl FnOnce(&mut Ui, &mut T),
) {
    let mut is_set = value.is_some();
    let checkbox = ui.checkbox(&mut is_set, "");
    named(&checkbox, &format!("limit {name}"));
    if checkbox.changed() {
        *value = is_set.then_some(otherwise);
    }
    match value {
        Some(value) => show(ui, value),
        None => {
            ui.weak("no limit");
        }
    }
}

fn directions(ui: &mut Ui, settings: &mut AoSettings, defaults: &AoSettings) {
    ui.spacing_mut().slider_width = 70.0;
    let hint = "Aperture of the cone in which rays leave, from 1 to 180 degrees (rays and hybrid)";
    row(ui, "spread", hint, &mut settings.spread, &defaults.spread, |ui, value| {
        named(&ui.add(Slider::new(value, limits::SPREAD).suffix(" deg")), "spread");
    });
    let hint = "Degrees above the horizon, from 0 to 89, below which occluders count less (rays and hybrid)";
    row(ui, "bias angle", hint, &mut settings.bias_angle, &defaults.bias_angle, |ui, value| {
        named(&ui.add(Slider::new(value, limits::BIAS_ANGLE).suffix(" deg")), "bias angle");
    });
    let hint = "How method rays draws directions; stratified needs a number of rays";
    row(ui, "sampling", hint, &mut settings.sampling, &defaults.sampling, |ui, value| {
        let list = ComboBox::from_id_salt("sampling").selected_text(value.to_string()).width(90.0);
        let list = list.show_ui(ui, |ui| {
            for one in Sampling::ALL {
                ui.selectable_value(value, one, one.to_string());
            }
        });
        named(&list.response, "sampling");
    });
    if settings.sampling == Sampling::Stratified && settings.rays.is_none() {
        settings.rays = Some(64);
    }
}

fn cones(ui: &mut Ui, settings: &mut AoSettings, defaults: &AoSettings) {
    let hint = "Octree leaves along the longest side of the scene, from 16 to 2048 (cones and paper)";
    row(ui, "voxels", hint, &mut settings.voxels, &defaults.voxels, |ui, value| {
        let list = ComboBox::from_id_salt("voxels").selected_text(value.to_string()).width(70.0);
        let list = list.show_ui(ui, |ui| {
            for power in limits::VOXELS.start().ilog2()..=limits::VOXELS.end().ilog2() {
                ui.selectable_value(value, 1 << power, (1u32 << power).to_string());
            }
        });
        named(&list.response, "voxels");
    });
    let hint = "Cones a point (cones and paper)";
    row(ui, "cones", hint, &mut settings.cones, &defaults.cones, |ui, value| {
        for count in conray::ConeSet::ALL.map(conray::ConeSet::count) {
            ui.selectable_value(value, count, count.to_string());
        }
    });
}

fn blend(ui: &mut Ui, settings: &mut AoSettings, defaults: &AoSettings) {
    ui.spacing_mut().slider_width = 70.0;
    let hint = "Which error of a cone that is (paper)";
    row(ui, "epsilon", hint, &mut settings.epsilon, &defaults.epsilon, |ui, value| {
        for one in [Epsilon::Published, Epsilon::Marching] {
            ui.selectable_value(value, one, one.to_string());
        }
    });
    let hint = "How fast trust in a cone falls with its error, 0 or more (paper)";
    row(ui, "beta", hint, &mut settings.beta, &defaults.beta, |ui, value| {
        named(&ui.add(Slider::new(value, limits::BETA).logarithmic(true).smallest_positive(0.1)), "beta");
    });
    let hint = "The error up to which a cone is trusted fully, from 0 to 1 (paper)";
    row(ui, "gamma", hint, &mut settings.gamma, &defaults.gamma, |ui, value| {
        named(
            &ui.add(
                Slider::new(value, limits::GAMMA).logarithmic(true).smallest_positive(1e-3).max_decimals(4),
            ),
            "gamma",
        );
    });
    let hint = "Most rays a cone, from 1 to 65536 (paper)";
    row(ui, "rays a cone", hint, &mut settings.max_rays, &defaults.max_rays, |ui, value| {
        named(&ui.add(Slider::new(value, limits::MAX_RAYS).logarithmic(true)), "rays a cone");
    });
}

fn general(ui: &mut Ui, settings: &mut AoSettings, defaults: &AoSettings) {
    let hint = "Chooses the random numbers";
    row(ui, "seed", hint, &mut settings.seed, &defaults.seed, |ui, value| {
        named(&ui.add(DragValue::new(value)), "seed");
    });
    let hint = "Whether the opacity of materials counts; a change reads the scene again";
    row(ui, "opacity", hint, &mut settings.alpha, &defaults.alpha, |ui, value| {
        ui.selectable_value(value, Alpha::Material, "of materials");
        ui.selectable_value(value, Alpha::Opaque, "all opaque");
    });
    let hint = "Most memory that the structures may take; the octree steps down to obey";
    row(ui, "memory", hint, &mut settings.max_memory, &defaults.max_memory, |ui, value| {
        optional(ui, "memory", value, 2 << 30, |ui, bytes| {
            let mut megabytes = *bytes >> 20;
            named(&ui.add(DragValue::new(&mut megabytes).range(1..=1 << 20).suffix(" MiB")), "memory");
            *bytes = megabytes << 20;
        });
    });
}
