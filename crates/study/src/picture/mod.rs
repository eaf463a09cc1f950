//! Pictures of values: grey, heat, signed difference, crops; as PNG.

mod colour;
mod layout;

use std::{borrow::Cow, io};

/// A picture in 8-bit sRGB.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue of each pixel, row by row from the top.
    pub rgb: Vec<u8>,
}

/// What marks a value that is not a number: magenta, which no colour map here comes near.
const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];

impl Picture {
    /// One colour all over.
    pub fn plain(width: u32, height: u32, rgb: [u8; 3]) -> Self {
        Self { width, height, rgb: rgb.repeat(width as usize * height as usize) }
    }

    /// Visibility as it is stored, without a transfer curve: 0 is black, 1 is white, NaN is magenta.
    ///
    /// Values beyond `[0, 1]` are held within it. Pixels without a value are white.
    pub fn grey(width: u32, height: u32, visibility: &[f32]) -> Self {
        Self::coloured(width, height, visibility.iter().map(|&v| (v, [byte(v); 3])), [255; 3])
    }

    /// Signed difference of `result` and `truth`: white is equal, blue too closed, red too open.
    ///
    /// An error of `full_scale` or more has the strongest colour; NaN is magenta. Pixels without a value are white.
    pub fn difference(width: u32, height: u32, result: &[f32], truth: &[f32], full_scale: f32) -> Self {
        let errors = result.iter().zip(truth).map(|(result, truth)| result - truth);
        let pixels = errors.map(|error| (error, colour::diverging(share(error, full_scale, -1.0))));
        Self::coloured(width, height, pixels, [255; 3])
    }

    /// Values from 0 (dark violet) to `max` or more (yellow); NaN is magenta. Pixels without a value are as 0.
    pub fn heat(width: u32, height: u32, values: &[f32], max: f32) -> Self {
        let pixels = values.iter().map(|&value| (value, colour::sequential(share(value, max, 0.0))));
        Self::coloured(width, height, pixels, colour::sequential(0.0))
    }

    /// The picture as a PNG file.
    pub fn to_png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing to memory cannot fail unless `rgb` and the size disagree, which `whole` rules out.
        let _ = self.encode(&mut bytes);
        bytes
    }

    fn encode(&self, bytes: &mut Vec<u8>) -> Result<(), png::EncodingError> {
        // PNG knows no picture without pixels: one white pixel stands for it.
        let (width, height) = (self.width.max(1), self.height.max(1));
        let mut encoder = png::Encoder::new(io::Cursor::new(bytes), width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.whole(width, height))?;
        writer.finish()
    }

    /// The bytes of the pixels, white where some are missing.
    fn whole(&self, width: u32, height: u32) -> Cow<'_, [u8]> {
        let length = 3 * width as usize * height as usize;
        if self.rgb.len() == length {
            return Cow::Borrowed(&self.rgb);
        }
        let mut rgb = self.rgb.clone();
        rgb.resize(length, 255);
        Cow::Owned(rgb)
    }

    fn coloured(
        width: u32,
        height: u32,
        pixels: impl Iterator<Item = (f32, [u8; 3])>,
        missing: [u8; 3],
    ) -> Self {
        let count = width as usize * height as usize;
        let known = pixels.map(|(value, rgb)| if value.is_nan() { NOT_A_NUMBER } else { rgb });
        Self { width, height, rgb: known.chain(std::iter::repeat(missing)).take(count).flatten().collect() }
    }
}

/// `value / full` within `[least, 1]`; a full scale of 0 shows every difference from 0 at its strongest.
fn share(value: f32, full: f32, least: f32) -> f32 {
    if full > 0.0 {
        (value / full).clamp(least, 1.0)
    } else if value == 0.0 {
        0.0
    } else {
        value.signum().max(least)
    }
}

fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

#[cfg(test)]
mod tests;
