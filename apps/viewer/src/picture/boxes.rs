//! Nodes of the octree as boxes over the picture.

use super::{Viewer, plate};
use crate::{colour::Map, engine::Boxes};
use conray::Vec3;
use egui::{Align2, Painter, Pos2, Rect, Stroke, pos2, vec2};

/// Corners by bits x, y, z; the pairs that an edge joins.
const EDGES: [(usize, usize); 12] =
    [(0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7)];

/// Draws the boxes, coloured by mean opacity.
pub(super) fn draw(painter: &Painter, viewer: &Viewer, boxes: &Boxes, rect: Rect) {
    let Some(look) = viewer.choices.look else { return };
    let size = [rect.width(), rect.height()];
    let painter = painter.with_clip_rect(painter.clip_rect().intersect(rect));
    for &(corner, opacity) in &boxes.nodes {
        let corners: [Option<Pos2>; 8] = std::array::from_fn(|bits| {
            let step = |bit: usize| if bits >> bit & 1 == 1 { boxes.edge } else { 0.0 };
            let at = Vec3::from(corner) + Vec3::new(step(0), step(1), step(2));
            look.project(at, size).map(|[x, y]| rect.min + vec2(x, y))
        });
        let stroke = Stroke::new(1.0, Map::Sequential.colour(0.25 + 0.75 * opacity));
        for (a, b) in EDGES {
            if let (Some(a), Some(b)) = (corners[a], corners[b]) {
                painter.line_segment([a, b], stroke);
            }
        }
    }
    let mut text = format!(
        "octree level {}: {} nodes, edge {}",
        boxes.level,
        boxes.found,
        crate::text::short(boxes.edge.into())
    );
    if boxes.nodes.len() < boxes.found {
        text += &format!("\nthe {} that most pixels lie in are drawn", boxes.nodes.len());
    }
    plate(&painter, pos2(rect.center().x, rect.bottom() - 8.0), Align2::CENTER_BOTTOM, &text);
}
