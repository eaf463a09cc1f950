//! Which colour is which value.

use super::{Viewer, plate};
use crate::text::tick;
use egui::{Align2, Color32, FontId, Mesh, Painter, Rect, Stroke, StrokeKind, pos2, vec2};

/// Width and height of the bar, in points.
const BAR: [f32; 2] = [190.0, 12.0];
/// Pieces that the bar is drawn of.
const PIECES: usize = 48;

/// Draws the legend of a side at its bottom.
pub(super) fn draw(painter: &Painter, viewer: &Viewer, part: Rect, side: usize) {
    let layer = viewer.choices.layers[side];
    let Some(range) = viewer.canvas.range(side).filter(|_| viewer.canvas.painted.texture(side).is_some())
    else {
        return;
    };
    let at_right = side == 1;
    let corner =
        if at_right { part.right_bottom() - vec2(8.0, 8.0) } else { part.left_bottom() + vec2(8.0, -8.0) };
    let Some(map) = layer.map() else {
        let align = if at_right { Align2::RIGHT_BOTTOM } else { Align2::LEFT_BOTTOM };
        plate(painter, corner, align, layer.name());
        return;
    };
    let size = vec2(BAR[0] + 20.0, 48.0);
    let min = if at_right { corner - size } else { corner - vec2(0.0, size.y) };
    let outer = Rect::from_min_size(min, size);
    painter.rect_filled(outer, 4.0, Color32::from_black_alpha(175));
    let font = FontId::proportional(12.0);
    painter.text(outer.min + vec2(10.0, 3.0), Align2::LEFT_TOP, layer.name(), font, Color32::WHITE);
    let bar = Rect::from_min_size(outer.min + vec2(10.0, 19.0), BAR.into());
    let mut mesh = Mesh::default();
    for piece in 0..PIECES {
        let x = |piece: usize| bar.left() + bar.width() * piece as f32 / PIECES as f32;
        let rect = Rect::from_min_max(pos2(x(piece), bar.top()), pos2(x(piece + 1), bar.bottom()));
        mesh.add_colored_rect(rect, map.colour((piece as f32 + 0.5) / PIECES as f32));
    }
    painter.add(mesh);
    painter.rect_stroke(bar, 0.0, Stroke::new(1.0, Color32::GRAY), StrokeKind::Outside);
    let font = FontId::proportional(11.0);
    for (share, align) in [(0.0, Align2::LEFT_TOP), (0.5, Align2::CENTER_TOP), (1.0, Align2::RIGHT_TOP)] {
        let value = range.low + share * (range.high - range.low);
        let at = pos2(bar.left() + share * bar.width(), bar.bottom() + 1.0);
        painter.text(at, align, tick(value.into()), font.clone(), Color32::WHITE);
    }
}
