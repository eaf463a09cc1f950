//! Opacity out of image files.

use super::error::Fault;
use super::limits::Limits;
use conray_core::{AlphaTexture, Opacity, TextureOpacity};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

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
    let format = match kind(name, bytes) {
        Ok(format) => format,
        Err(unknown) => return Ok(ImageOpacity::UnknownKind(unknown)),
    };
    let fault =
        |e: image::ImageError| Fault::element(format!("image `{name}`"), format!("cannot be decoded: {e}"));
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.no_limits();
    let mut decoder = reader.into_decoder().map_err(fault)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels > *pixels_left {
        let (found, limit) = (limits.max_texture_pixels - *pixels_left + pixels, limits.max_texture_pixels);
        return Err(Fault::LimitExceeded { what: "texture pixels", found, limit });
    }
    // PNG and TGA pack at most about 8300 pixels into a byte (1032 : 1 for deflate, 8 one-bit pixels).
    if pixels / 8300 > bytes.len() as u64 {
        let reason = format!("it has too little data for its {width} x {height} pixels");
        return Err(Fault::element(format!("image `{name}`"), reason));
    }
    if channel == Channel::Alpha && !decoder.color_type().has_alpha() {
        return Ok(ImageOpacity::Opaque);
    }
    let mut decoding = image::Limits::no_limits();
    decoding.max_alloc = Some(pixels.saturating_mul(16).saturating_add(64 << 20));
    decoder.set_limits(decoding).map_err(fault)?;
    let image = DynamicImage::from_decoder(decoder).map_err(fault)?;
    let texels = texels(&image, channel);
    if texels.iter().all(|&t| t == u8::MAX) {
        return Ok(ImageOpacity::Opaque);
    }
    match AlphaTexture::new(width, height, texels) {
        Some(texture) => {
            *pixels_left -= pixels;
            Ok(ImageOpacity::Texture(texture))
        }
        None => Err(Fault::element(format!("image `{name}`"), "it has no pixels")),
    }
}

/// The kind by the first bytes; TGA has none of its own and goes by its name.
fn kind(name: &str, bytes: &[u8]) -> Result<ImageFormat, &'static str> {
    let ends = |ending: &str| name.to_ascii_lowercase().ends_with(ending);
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Ok(ImageFormat::Png),
        [0xff, 0xd8, 0xff, ..] => Ok(ImageFormat::Jpeg),
        [b'B', b'M', ..] if !ends(".tga") => Ok(ImageFormat::Bmp),
        [0xab, b'K', b'T', b'X', ..] => Err("KTX"),
        [b'D', b'D', b'S', b' ', ..] => Err("DDS"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Err("WebP"),
        [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => Err("TIFF"),
        [b'G', b'I', b'F', b'8', ..] => Err("GIF"),
        [b'8', b'B', b'P', b'S', ..] => Err("PSD"),
        _ if ends(".tga") => Ok(ImageFormat::Tga),
        // A file that pretends to be one of these and is not deserves the decoder's words.
        _ if ends(".png") => Ok(ImageFormat::Png),
        _ if ends(".jpg") || ends(".jpeg") => Ok(ImageFormat::Jpeg),
        _ => Err("an unknown kind of image"),
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
