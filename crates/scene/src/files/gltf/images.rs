//! The images of a glTF's textures: files beside it, or bytes in it.

use super::data::{Data, get};
use super::schema::Texture;
use super::uri::read_uri;
use crate::files::error::{Fault, shown};
use crate::files::intake::Intake;
use std::borrow::Cow;

/// What a texture leads to.
pub(super) enum Found<'d> {
    /// An image file; the name tells messages and kinds.
    File { name: String, bytes: Cow<'d, [u8]> },
    /// An image that only an extension names, such as `KHR_texture_basisu`.
    OtherFormat(String),
    /// Nothing, and why, for people.
    Missing(String),
}

/// Finds the image of a texture.
pub(super) fn find<'d>(
    data: &'d Data<'d>,
    texture: &Texture,
    index: usize,
    intake: &Intake,
) -> Result<Found<'d>, Fault> {
    let asker = format!("texture {index}");
    let Some(source) = texture.source else {
        return Ok(match texture.extensions.keys().next() {
            Some(name) => Found::OtherFormat(shown(name.as_bytes())),
            None => Found::Missing(format!("{asker} without an image")),
        });
    };
    let def = get(&data.root.images, source, "image", &asker)?;
    let name = format!("image {source}");
    match (&def.uri, def.buffer_view) {
        (Some(uri), _) => Ok(match read_uri(uri, &name, intake)? {
            Ok(bytes) => {
                let name = if uri.starts_with("data:") { name } else { uri.clone() };
                Found::File { name, bytes: Cow::Owned(bytes) }
            }
            Err(error) => Found::Missing(format!("{}: {error}", shown(uri.as_bytes()))),
        }),
        (None, Some(view)) => {
            let bytes = Cow::Borrowed(data.view(view, &name)?.bytes);
            Ok(Found::File { name, bytes })
        }
        (None, None) => Err(Fault::element(name, "it has neither a URI nor a buffer view")),
    }
}
