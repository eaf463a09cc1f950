//! The picture in the middle of the window: what is painted, what is drawn over it, and how it is moved.

mod boxes;
mod fan;
mod legend;
mod moves;
mod paint;

use crate::{app::Viewer, layers::Layer, text::short};
use egui::{Align2, CentralPanel, Color32, FontId, Frame, Painter, Pos2, Rect, Sense, Ui, pos2, vec2};
pub(crate) use paint::composed;

/// The picture's place and what is kept of one frame for the next.
#[derive(Default)]
pub(crate) struct Canvas {
    /// Pixels that there is room for.
    pub(crate) room: [u32; 2],
    /// Where the picture is, in points.
    pub(crate) rect: Option<Rect>,
    painted: paint::Painted,
    moves: moves::Moves,
}

impl Canvas {
    /// The range of a side's colours, once painted.
    pub(crate) fn range(&self, side: usize) -> Option<crate::layers::Range> {
        self.painted.range(side)
    }
}

/// Shows the picture in all the room that is left.
pub(crate) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    let frame = Frame::NONE.fill(ui.visuals().extreme_bg_color);
    CentralPanel::default().frame(frame).show(ui, |ui| {
        let room = ui.available_rect_before_wrap();
        let scale = ui.ctx().pixels_per_point();
        viewer.canvas.room = [room.width(), room.height()].map(|side| (side * scale).round().max(0.0) as u32);
        if room.width() < 1.0 || room.height() < 1.0 {
            return;
        }
        let response = ui.interact(room, ui.scope_id().with("picture"), Sense::click_and_drag());
        let name = "picture: drag to orbit, arrow keys when focused";
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
        let rect = placed(viewer, room);
        viewer.canvas.rect = Some(rect);
        // The handle of the split lies over the picture, so it is asked first.
        let on_split = split_handle(viewer, ui, rect);
        moves::apply(viewer, ui, &response, rect, on_split);
        draw(viewer, ui, rect, room);
        if response.has_focus() {
            ui.painter().rect_stroke(
                room.shrink(1.0),
                0.0,
                ui.visuals().selection.stroke,
                egui::StrokeKind::Inside,
            );
        }
    });
}

/// Where the picture goes: in its own proportions, as large as there is room.
fn placed(viewer: &Viewer, room: Rect) -> Rect {
    let wished = viewer.wish().map(|wish| wish.size);
    let Some([width, height]) = wished.filter(|size| !size.contains(&0)) else { return room };
    let scale = (room.width() / width as f32).min(room.height() / height as f32);
    let size = vec2(width as f32, height as f32) * scale;
    // Rounding must not make a picture that fits blurred.
    if (size - room.size()).abs().max_elem() < 1.0 {
        room
    } else {
        Rect::from_center_size(room.center(), size)
    }
}

/// The line between two sides, dragged with the mouse; true while the pointer is on it.
fn split_handle(viewer: &mut Viewer, ui: &Ui, rect: Rect) -> bool {
    if !viewer.choices.is_split {
        return false;
    }
    let x = rect.left() + viewer.choices.split_at * rect.width();
    let grip = Rect::from_min_max(pos2(x - 6.0, rect.top()), pos2(x + 6.0, rect.bottom()));
    let response = ui.interact(grip, ui.scope_id().with("split"), Sense::drag());
    let response = response.on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        viewer.choices.split_at = ((pointer.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
    }
    response.hovered() || response.dragged()
}

fn draw(viewer: &mut Viewer, ui: &Ui, rect: Rect, room: Rect) {
    let dark = ui.visuals().dark_mode;
    paint::update(viewer, ui.ctx(), dark);
    let painter = ui.painter().with_clip_rect(room);
    let split = rect.left() + viewer.choices.split_at * rect.width();
    let parts = match viewer.choices.is_split {
        true => vec![
            Rect::from_min_max(rect.min, pos2(split, rect.bottom())),
            Rect::from_min_max(pos2(split, rect.top()), rect.max),
        ],
        false => vec![rect],
    };
    for (side, part) in parts.iter().enumerate() {
        let painter = painter.with_clip_rect(part.intersect(room));
        match viewer.canvas.painted.texture(side) {
            Some(texture) => {
                let uv = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
                painter.image(texture, rect, uv, Color32::WHITE);
            }
            None => explain_absence(viewer, &painter, *part, side, ui.visuals().text_color()),
        }
    }
    if viewer.choices.is_split {
        painter.vline(split, rect.y_range(), egui::Stroke::new(3.0, Color32::BLACK));
        painter.vline(split, rect.y_range(), egui::Stroke::new(1.0, Color32::WHITE));
        painter.circle(
            pos2(split, rect.center().y),
            6.0,
            Color32::WHITE,
            egui::Stroke::new(1.5, Color32::BLACK),
        );
    }
    if let (Some(boxes), true) = (&viewer.shown.boxes, viewer.fields.boxes.is_some()) {
        boxes::draw(&painter, viewer, boxes, rect);
    }
    if viewer.shown.probe.is_some() {
        fan::draw(&painter, viewer, rect);
    }
    for (side, part) in parts.iter().enumerate() {
        let painter = painter.with_clip_rect(part.intersect(room));
        title(viewer, &painter, *part, side);
        legend::draw(&painter, viewer, *part, side);
    }
}

/// Says why there is nothing to see of a layer.
fn explain_absence(viewer: &Viewer, painter: &Painter, part: Rect, side: usize, colour: Color32) {
    let layer = viewer.choices.layers[side];
    let text = match &viewer.shown.picture {
        None => "reading the scene ...".into(),
        Some(picture) if picture.sides.get(side).is_none() => "working ...".into(),
        Some(picture) if layer.needs_cones() => format!(
            "Method {} marches no cones.\nChoose cones or paper to see {}.",
            picture.sides[side].method,
            layer.name()
        ),
        Some(picture) if layer == Layer::Difference && picture.is_preview() => "working ...".into(),
        Some(_) if layer == Layer::Difference => {
            "There is no truth of this view and size yet.\nFind it, or drop an EXR of the same size here."
                .into()
        }
        Some(_) => "working ...".to_string(),
    };
    let galley = painter.layout(text, FontId::proportional(15.0), colour, part.width() - 20.0);
    painter.galley(part.center() - galley.size() * 0.5, galley, colour);
}

/// Method and error of a side, at its top.
fn title(viewer: &Viewer, painter: &Painter, part: Rect, side: usize) {
    let Some(picture) = &viewer.shown.picture else { return };
    let Some(shown) = picture.sides.get(side) else { return };
    let mut text = format!("{}, {} rays a pixel", shown.method, short(shown.rays_per_pixel));
    if shown.expected_rmse.is_finite() {
        text += &format!("\nexpected error {}", short(shown.expected_rmse));
    }
    if let Some(measured) = viewer.shown.measured.get(side).copied().flatten() {
        text += &format!(", against the truth {}", short(measured));
    }
    if picture.is_preview() {
        text += &format!("\npreview of {} x {}", picture.size[0], picture.size[1]);
    } else if let Some(ended) = &shown.ended {
        text += &format!("\n{ended} ({} s)", short(shown.seconds));
    }
    let (at, align) = match side {
        0 => (part.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP),
        _ => (part.right_top() + vec2(-8.0, 8.0), Align2::RIGHT_TOP),
    };
    plate(painter, at, align, &text);
}

/// Text on a dark plate, readable on any picture.
fn plate(painter: &Painter, at: Pos2, align: Align2, text: &str) -> Rect {
    let galley = painter.layout_no_wrap(text.into(), FontId::proportional(12.0), Color32::WHITE);
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand(4.0), 4.0, Color32::from_black_alpha(175));
    painter.galley(rect.min, galley, Color32::WHITE);
    rect.expand(4.0)
}
