//! Mouse and keys on the picture.

use super::Viewer;
use crate::{camera::Look, engine::Question};
use egui::{Event, EventFilter, Key, PointerButton, Rect, Response, Ui, Vec2};
use std::f32::consts::PI;

/// A flight covers this share of the scene's diagonal in a second; ten times as much with shift.
const FLIGHT: f32 = 0.12;
/// A step of an arrow key, in radians.
const ARROW_RAD: f32 = 0.05;
/// Points of a wheel's step.
const WHEEL_POINTS: f32 = 50.0;

/// What a press that may become a double click has asked for.
#[derive(Default)]
pub(super) struct Moves {
    /// The next probe's answer is the point to turn about.
    turns_to_probe: bool,
}

/// Applies what was done on the picture in this frame.
pub(super) fn apply(viewer: &mut Viewer, ui: &Ui, response: &Response, rect: Rect, on_split: bool) {
    let Some(look) = viewer.choices.look else { return };
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    let mut next = look;
    if !on_split {
        next = dragged(next, ui, response, rect);
    }
    if response.hovered() {
        next = wheeled(next, ui);
    }
    next = keyed(next, viewer, ui, response);
    if next != look {
        viewer.choices.look = Some(next);
    }
    turn_to_probe(viewer);
    if response.clicked() || response.double_clicked() {
        probe(viewer, response, rect);
    }
}

fn dragged(look: Look, ui: &Ui, response: &Response, rect: Rect) -> Look {
    let by: Vec2 = response.drag_delta() / rect.height();
    if by == Vec2::ZERO {
        return look;
    }
    let modifiers = ui.input(|input| input.modifiers);
    let shifts = response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle);
    if shifts || modifiers.shift {
        look.pan(by.x, by.y)
    } else if modifiers.ctrl || modifiers.command {
        // The head turns as far as the pointer shows.
        let fov = look.vertical_fov_deg.to_radians();
        look.turn(by.x * fov, by.y * fov)
    } else {
        look.orbit(-by.x * PI, -by.y * PI)
    }
}

fn wheeled(look: Look, ui: &Ui) -> Look {
    let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
    // A pinch by a factor is as many steps as come to it.
    let steps = wheel / WHEEL_POINTS + pinch.ln() * 7.0;
    if steps == 0.0 { look } else { look.zoom(steps) }
}

fn keyed(look: Look, viewer: &Viewer, ui: &Ui, response: &Response) -> Look {
    let typing = ui.ctx().egui_wants_keyboard_input() && !response.has_focus();
    if typing {
        return look;
    }
    let mut look = look;
    let (held, seconds, shift) = ui.input(|input| {
        let held = |key| f32::from(u8::from(input.key_down(key) && !input.modifiers.command));
        let axis = |plus, minus| held(plus) - held(minus);
        let axes = [axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S)];
        (axes, input.stable_dt.min(0.1), input.modifiers.shift)
    });
    if held != [0.0; 3] {
        let diagonal = viewer.scene().map_or(1.0, |scene| scene.diagonal);
        let step = FLIGHT * diagonal * seconds * if shift { 10.0 } else { 1.0 };
        look = look.fly(held.map(|axis| axis * step));
        ui.ctx().request_repaint();
    }
    if !response.has_focus() {
        return look;
    }
    let pressed = ui.input(|input| {
        let keys = input.events.iter().filter_map(|event| match event {
            Event::Key { key, pressed: true, .. } => Some(*key),
            _ => None,
        });
        keys.collect::<Vec<_>>()
    });
    for key in pressed {
        look = match key {
            Key::ArrowLeft => look.orbit(-ARROW_RAD, 0.0),
            Key::ArrowRight => look.orbit(ARROW_RAD, 0.0),
            Key::ArrowUp => look.orbit(0.0, -ARROW_RAD),
            Key::ArrowDown => look.orbit(0.0, ARROW_RAD),
            Key::Plus | Key::Equals => look.zoom(1.0),
            Key::Minus => look.zoom(-1.0),
            _ => look,
        };
    }
    look
}

/// Asks what the pixel under the pointer sees; with a double click the camera turns about it from then on.
fn probe(viewer: &mut Viewer, response: &Response, rect: Rect) {
    let (Some(at), Some(wish)) = (response.interact_pointer_pos(), viewer.wish()) else { return };
    if !rect.contains(at) {
        return;
    }
    let share = (at - rect.min) / rect.size();
    let [width, height] = wish.size;
    let pixel = [(share.x * width as f32) as u32, (share.y * height as f32) as u32];
    let side = usize::from(viewer.choices.is_split && share.x > viewer.choices.split_at);
    viewer.canvas.moves.turns_to_probe = response.double_clicked();
    viewer.shown.probe = None;
    viewer.ask(Question::Probe { pixel, side });
}

fn turn_to_probe(viewer: &mut Viewer) {
    if !viewer.canvas.moves.turns_to_probe {
        return;
    }
    if let (Some(probe), Some(look)) = (&viewer.shown.probe, viewer.choices.look) {
        viewer.choices.look = Some(look.turned_to(probe.position));
        viewer.canvas.moves.turns_to_probe = false;
    }
}
