//! Planes become textures: painted once for each picture, layer and range.

use super::Viewer;
use crate::layers::{Layer, Range, colours, values};
use egui::{Color32, ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use std::sync::Arc;

/// What a painted side depends on.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    version: u64,
    layer: Layer,
    /// A range of one's own choice, if there is one.
    range: Option<f32>,
    dark: bool,
    truth_key: String,
}

#[derive(Default)]
struct Side {
    key: Option<Key>,
    texture: Option<TextureHandle>,
    range: Option<Range>,
    is_empty: bool,
}

/// The textures of both sides.
#[derive(Default)]
pub(super) struct Painted {
    sides: [Side; 2],
}

impl Painted {
    pub(super) fn texture(&self, side: usize) -> Option<TextureId> {
        let side = self.sides.get(side)?;
        side.texture.as_ref().filter(|_| !side.is_empty).map(TextureHandle::id)
    }

    pub(super) fn range(&self, side: usize) -> Option<Range> {
        self.sides.get(side)?.range
    }
}

/// Where nothing of the scene is seen.
pub(super) fn ground(dark: bool) -> Color32 {
    if dark { Color32::from_rgb(34, 38, 46) } else { Color32::from_rgb(214, 220, 230) }
}

/// The colours of a side and their range; `None` where the layer has nothing to show.
fn side_colours(viewer: &Viewer, side: usize, dark: bool) -> Option<([u32; 2], Vec<Color32>, Range)> {
    let picture = viewer.shown.picture.as_ref()?;
    let shown = picture.sides.get(side)?;
    let layer = viewer.choices.layers[side];
    let truth = viewer.shown.truth(&viewer.truth_key()).map(|truth| Arc::clone(&truth.visibility));
    let values = values(layer, picture, shown, truth.as_ref().map(|t| t.as_slice()))?;
    let mut range = Range::of(layer, &values);
    if let Some(high) = viewer.fields.ranges[side].filter(|_| layer.fixed_range().is_none()) {
        range = Range { low: if range.low < 0.0 { -high } else { 0.0 }, high };
    }
    Some((picture.size, colours(layer, &values, &picture.facing, range, ground(dark)), range))
}

/// Paints what has changed.
pub(super) fn update(viewer: &mut Viewer, ctx: &Context, dark: bool) {
    let sides = if viewer.choices.is_split { 2 } else { 1 };
    for side in 0..sides {
        let key = Key {
            version: viewer.shown.version,
            layer: viewer.choices.layers[side],
            range: viewer.fields.ranges[side],
            dark,
            truth_key: viewer.truth_key(),
        };
        let has_picture = viewer.shown.picture.is_some();
        if !has_picture || viewer.canvas.painted.sides[side].key.as_ref() == Some(&key) {
            continue;
        }
        let found = side_colours(viewer, side, dark);
        let painted = &mut viewer.canvas.painted.sides[side];
        painted.is_empty = found.is_none();
        if let Some((size, pixels, range)) = found {
            let image = ColorImage::new(size.map(|n| n as usize), pixels);
            // What is enlarged much, as previews are, is smoothed; single pixels stay seen.
            let options = TextureOptions::LINEAR;
            match &mut painted.texture {
                Some(texture) => texture.set(image, options),
                None => painted.texture = Some(ctx.load_texture(format!("side {side}"), image, options)),
            }
            painted.range = Some(range);
        }
        painted.key = Some(key);
    }
}

/// The picture as it is shown, both sides put together: its size and its colours as codes in [0, 1].
pub(crate) fn composed(viewer: &Viewer, dark: bool) -> Option<([u32; 2], Vec<[f32; 3]>)> {
    let (size, mut pixels, _) = side_colours(viewer, 0, dark)?;
    if viewer.choices.is_split
        && let Some((_, right, _)) = side_colours(viewer, 1, dark)
    {
        let from = (viewer.choices.split_at * size[0] as f32).round() as usize;
        let rows = pixels.chunks_mut(size[0] as usize).zip(right.chunks(size[0] as usize));
        for (left, right) in rows {
            left[from..].copy_from_slice(&right[from..]);
        }
    }
    let codes = |c: &Color32| [c.r(), c.g(), c.b()].map(|code| f32::from(code) / 255.0);
    Some((size, pixels.iter().map(codes).collect()))
}
