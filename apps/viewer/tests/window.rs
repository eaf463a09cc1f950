//! The window without a screen: controls found by their names, pressed, and looked at for their effect.

use conray_viewer::{
    Start, Viewer,
    choices::{Choices, PictureSize},
    engine::Source,
    host::ThreadHost,
};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use serde_json::Value;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(120);

fn window(start: Start) -> Harness<'static, Viewer> {
    let mut choices = start.choices.clone();
    choices.size = PictureSize::Fixed([96, 72]);
    choices.settings.error = Some(0.02);
    choices.device = conray::Device::Cpu;
    let host = ThreadHost::start(|| {});
    let viewer = Viewer::new(Box::new(host), Start { choices, ..start });
    Harness::builder()
        .with_size([1280.0, 1600.0])
        .build_ui_state(|ui, viewer: &mut Viewer| viewer.show(ui), viewer)
}

/// Frames until the window shows what is waited for.
fn until(harness: &mut Harness<'static, Viewer>, what: &str, is_it: impl Fn(&Viewer) -> bool) {
    let start = Instant::now();
    while !is_it(harness.state()) {
        assert!(start.elapsed() < PATIENCE, "{what}: {}", harness.state().facts());
        std::thread::sleep(Duration::from_millis(5));
        harness.step();
    }
}

fn until_rest(harness: &mut Harness<'static, Viewer>) -> Value {
    // A change made in one frame is a wish in the next.
    harness.run_steps(3);
    until(harness, "rest", Viewer::is_at_rest);
    harness.state().facts()
}

fn press(harness: &mut Harness<'static, Viewer>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

/// Opens a list by what it shows now and chooses from it.
fn choose(harness: &mut Harness<'static, Viewer>, now: &str, next: &str) {
    harness.get_by_value(now).click();
    harness.run_steps(3);
    // A box to tick may bear the same word as an entry of the open list.
    let entry =
        harness.get_all_by_label(next).find(|entry| entry.accesskit_node().role() != egui::Role::CheckBox);
    entry.unwrap().click();
    harness.run_steps(3);
}

#[test]
fn the_method_is_changed_by_its_list_and_the_picture_follows() {
    let mut harness = window(Start::default());
    let facts = until_rest(&mut harness);
    assert_eq!((&facts["scene"], &facts["sides"][0]["method"]), (&"cornell".into(), &"hybrid".into()));
    choose(&mut harness, "hybrid", "cones");
    let facts = until_rest(&mut harness);
    assert_eq!(facts["sides"][0]["method"], "cones");
    assert_eq!(facts["sides"][0]["rays_per_pixel"], 0.0);
}

#[test]
fn two_sides_are_shown_on_request_and_by_a_key() {
    let mut harness = window(Start::default());
    until_rest(&mut harness);
    press(&mut harness, "two side by side (B)");
    let facts = until_rest(&mut harness);
    assert_eq!(facts["sides"].as_array().unwrap().len(), 2);
    assert_eq!(facts["sides"][1]["method"], "rays");
    harness.key_press(egui::Key::B);
    let facts = until_rest(&mut harness);
    assert_eq!(facts["sides"].as_array().unwrap().len(), 1);
    harness.key_press(egui::Key::M);
    assert_eq!(until_rest(&mut harness)["sides"][0]["method"], "rays", "M is the next method");
}

#[test]
fn a_layer_of_cones_offers_the_method_that_has_them() {
    let choices = Choices { layers: [conray_viewer::layers::Layer::Alpha; 2], ..Choices::default() };
    let mut harness = window(Start { choices, ..Start::default() });
    until_rest(&mut harness);
    press(&mut harness, "Use paper");
    assert_eq!(until_rest(&mut harness)["sides"][0]["method"], "paper");
}

#[test]
fn drags_orbit_the_wheel_zooms_and_reset_comes_back() {
    let mut harness = window(Start::default());
    let before = until_rest(&mut harness);
    let centre = centre(&before);
    harness.drag_at(centre);
    harness.step();
    harness.hover_at(centre + egui::vec2(60.0, 10.0));
    harness.step();
    harness.drop_at(centre + egui::vec2(60.0, 10.0));
    let turned = until_rest(&mut harness);
    assert_ne!(turned["look"]["eye"], before["look"]["eye"]);
    assert_eq!(turned["look"]["look_at"], before["look"]["look_at"], "an orbit");
    assert_eq!(turned["picture_look"], turned["look"]);
    let distance = |facts: &Value| {
        let point = |name: &str| -> Vec<f64> {
            facts["look"][name].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
        };
        let (eye, at) = (point("eye"), point("look_at"));
        eye.iter().zip(&at).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    harness.hover_at(centre);
    harness.step();
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, 200.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run_steps(30);
    let near = until_rest(&mut harness);
    assert!(distance(&near) < 0.9 * distance(&turned), "{} {}", distance(&near), distance(&turned));
    press(&mut harness, "Reset");
    assert_eq!(until_rest(&mut harness)["look"], before["look"]);
}

#[test]
fn a_click_probes_and_escape_puts_it_away() {
    let mut harness = window(Start::default());
    let facts = until_rest(&mut harness);
    let centre = centre(&facts);
    harness.drag_at(centre);
    harness.step();
    harness.drop_at(centre);
    until(&mut harness, "a probe", |viewer| !viewer.facts()["probe"].is_null());
    assert_eq!(harness.state().facts()["probe"][0], serde_json::json!([48, 36]));
    assert_eq!(harness.state().facts()["look"], facts["look"], "a click moves nothing");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.state().facts()["probe"].is_null());
}

#[test]
fn boxes_are_drawn_of_the_level_chosen() {
    let mut harness = window(Start::default());
    until_rest(&mut harness);
    press(&mut harness, "octree as boxes");
    until(&mut harness, "boxes", |viewer| viewer.facts()["boxes"].as_u64().is_some_and(|count| count > 3));
}

#[test]
fn a_scene_that_cannot_be_read_leaves_the_picture_and_is_told() {
    let mut harness = window(Start::default());
    let before = until_rest(&mut harness);
    let fields = harness.get_all_by_role(egui::accesskit::Role::TextInput);
    fields.into_iter().find(|field| field.value().as_deref() == Some("cornell")).unwrap().focus();
    harness.run_steps(2);
    // The typed name is replaced.
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.event(egui::Event::Text("gone.obj".into()));
    harness.run_steps(2);
    press(&mut harness, "Open");
    until(&mut harness, "a message", |viewer| viewer.facts()["messages"].to_string().contains("gone.obj"));
    let after = until_rest(&mut harness);
    assert_eq!((&after["scene"], &after["version"]), (&before["scene"], &before["version"]));
}

#[test]
fn a_settings_row_has_a_way_back() {
    let mut harness = window(Start::default());
    until_rest(&mut harness);
    press(&mut harness, "Settings");
    harness.run_steps(20);
    // The error of these tests is not the default.
    let before = harness.query_all_by_label("reset").count();
    assert!(before >= 1);
    harness.get_all_by_label("reset").next().unwrap().click();
    harness.run_steps(3);
    assert_eq!(harness.query_all_by_label("reset").count(), before - 1);
}

#[test]
fn an_unknown_view_is_told_and_the_first_is_shown() {
    let start = Start {
        source: Some(Source::Builtin("atrium".into())),
        view: Some("nowhere".into()),
        ..Start::default()
    };
    let mut harness = window(start);
    let facts = until_rest(&mut harness);
    assert!(facts["messages"].to_string().contains("nowhere"), "{facts}");
    assert_eq!(facts["scene"], "atrium");
}

fn centre(facts: &Value) -> egui::Pos2 {
    let at = |i: usize| facts["canvas"][i].as_f64().unwrap() as f32;
    egui::pos2(0.5 * (at(0) + at(2)), 0.5 * (at(1) + at(3)))
}
