//! Image files of the kinds that are read.

use super::error::Fault;
use super::limits::Limits;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// An image whose size is known and allowed, and whose pixels are not decoded yet.
pub(super) struct ImageFile<'a> {
    name: &'a str,
    decoder: Box<dyn ImageDecoder + 'a>,
    pixels: u64,
}

impl<'a> ImageFile<'a> {
    /// Looks at the head of a file; `name` tells messages and, for TGA, the kind. The inner error names a kind that is not read.
    ///
    /// `pixels_left` is what remains of [`Limits::max_texture_pixels`].
    pub(super) fn open(
        name: &'a str,
        bytes: &'a [u8],
        pixels_left: u64,
        limits: &Limits,
    ) -> Result<Result<Self, &'static str>, Fault> {
        let format = match kind(name, bytes) {
            Ok(format) => format,
            Err(unknown) => return Ok(Err(unknown)),
        };
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.no_limits();
        let decoder = reader.into_decoder().map_err(|e| fault(name, &e))?;
        let (width, height) = decoder.dimensions();
        let pixels = u64::from(width) * u64::from(height);
        if pixels > pixels_left {
            let (found, limit) =
                (limits.max_texture_pixels - pixels_left + pixels, limits.max_texture_pixels);
            return Err(Fault::LimitExceeded { what: "texture pixels", found, limit });
        }
        // PNG and TGA pack at most about 8300 pixels into a byte (1032 : 1 for deflate, 8 one-bit pixels).
        if pixels / 8300 > bytes.len() as u64 {
            let reason = format!("it has too little data for its {width} x {height} pixels");
            return Err(Fault::element(format!("image `{name}`"), reason));
        }
        Ok(Ok(Self { name, decoder: Box::new(decoder), pixels }))
    }

    /// Rows times pixels in a row.
    pub(super) fn pixels(&self) -> u64 {
        self.pixels
    }

    /// True where the file has an alpha channel, whatever it holds.
    pub(super) fn has_alpha(&self) -> bool {
        self.decoder.color_type().has_alpha()
    }

    /// Decodes it.
    pub(super) fn decode(mut self) -> Result<DynamicImage, Fault> {
        let mut limits = image::Limits::no_limits();
        limits.max_alloc = Some(self.pixels.saturating_mul(16).saturating_add(64 << 20));
        self.decoder.set_limits(limits).map_err(|e| fault(self.name, &e))?;
        DynamicImage::from_decoder(self.decoder).map_err(|e| fault(self.name, &e))
    }
}

fn fault(name: &str, error: &image::ImageError) -> Fault {
    Fault::element(format!("image `{name}`"), format!("cannot be decoded: {error}"))
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
