//! Opacity out of image files.

use super::error::Fault;
use super::image_file::ImageFile;
use super::limits::Limits;
use conray_core::{AlphaTexture, Opacity, TextureOpacity};
use image::{ColorType, DynamicImage};

/// Which of an image's channels is opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    /// The alpha channel only; images without one are opaque.
    Alpha,
    /// The alpha channel where it says anything, else the first colour: what `map_d` of MTL is.
    AlphaOrRed,
    /// Red, green or blue: 0, 1, 2.
    Colour(u8),
    /// The mean of the colours, weighted as the eye sees them (Rec. 709).
    Luminance,
}

/// What an image file says about opacity.
#[derive(Debug, PartialEq)]
pub(super) enum ImageOpacity {
    /// The channel is wholly opaque or does not exist.
    Opaque,
    /// At least one texel is not opaque.
    Texture(AlphaTexture),
    /// The file is of a kind that is not read, named here.
    UnknownKind(&'static str),
}

/// Reads the opacity of an image; `name` tells messages and, for TGA, the kind.
///
/// `pixels_left` is what remains of [`Limits::max_texture_pixels`]; a texture that is returned is taken off it.
pub(super) fn read_opacity(
    name: &str,
    bytes: &[u8],
    channel: Channel,
    pixels_left: &mut u64,
    limits: &Limits,
) -> Result<ImageOpacity, Fault> {
    let file = match ImageFile::open(name, bytes, *pixels_left, limits)? {
        Ok(file) => file,
        Err(unknown) => return Ok(ImageOpacity::UnknownKind(unknown)),
    };
    if channel == Channel::Alpha && !file.has_alpha() {
        return Ok(ImageOpacity::Opaque);
    }
    let (pixels, image) = (file.pixels(), file.decode()?);
    let texels = texels(&image, channel);
    if texels.iter().all(|&t| t == u8::MAX) {
        return Ok(ImageOpacity::Opaque);
    }
    match AlphaTexture::new(image.width(), image.height(), texels) {
        Some(texture) => {
            *pixels_left -= pixels;
            Ok(ImageOpacity::Texture(texture))
        }
        None => Err(Fault::element(format!("image `{name}`"), "it has no pixels")),
    }
}

fn texels(image: &DynamicImage, channel: Channel) -> Vec<u8> {
    let pick = |i: usize| image.to_rgba8().pixels().map(|p| p.0[i]).collect::<Vec<u8>>();
    match channel {
        Channel::Alpha => pick(3),
        Channel::AlphaOrRed if image.color().has_alpha() => {
            let alpha = pick(3);
            if alpha.iter().all(|&a| a == u8::MAX) { pick(0) } else { alpha }
        }
        Channel::AlphaOrRed if image.color() == ColorType::L8 => image.as_bytes().to_vec(),
        Channel::AlphaOrRed => pick(0),
        Channel::Colour(i) => pick(usize::from(i.min(2))),
        Channel::Luminance => image.to_luma8().into_raw(),
    }
}

/// A constant where no filtered texel can give anything else.
pub(super) fn simplify(opacity: TextureOpacity) -> Opacity {
    let texels = opacity.texture.texels();
    let least = texels.iter().copied().min().unwrap_or(u8::MAX);
    let most = texels.iter().copied().max().unwrap_or(u8::MAX);
    let value = |texel: u8| opacity.factor * (f32::from(texel) / 255.0);
    match opacity.cutoff {
        Some(cutoff) if value(least) >= cutoff => Opacity::Constant(1.0),
        Some(cutoff) if value(most) < cutoff => Opacity::Constant(0.0),
        None if least == most => Opacity::Constant(value(most).clamp(0.0, 1.0)),
        _ => Opacity::Texture(opacity),
    }
}
