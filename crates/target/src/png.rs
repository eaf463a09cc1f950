//! Grey PNG: visibility alone, linear, for viewing and for textures.
//!
//! No gamma chunk is written: the values are data, and readers that honour such a chunk would change them.

use crate::{Layers, MAX_PIXELS, TargetError, input, write_atomically};
use std::{
    io::{self, Cursor, Write},
    path::Path,
};

/// Bits per pixel of a grey PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PngDepth {
    /// 256 steps.
    #[default]
    Eight,
    /// 65536 steps.
    Sixteen,
}

/// A grey image read back.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Bits per pixel.
    pub depth: PngDepth,
    /// Linear values in [0, 1], row by row from the top.
    pub values: Vec<f32>,
}

/// Writes the visibility as a grey PNG: linear, rounded to the nearest step, 1 = white, white where there is no surface.
///
/// Pending pixels are filled ([`Layers::filled_visibility`]); [`Layers::pending`] says how many. The file appears whole
/// or not at all ([`write_atomically`]).
pub fn write_png(path: impl AsRef<Path>, layers: &Layers, depth: PngDepth) -> Result<(), TargetError> {
    let values = layers.filled_visibility();
    write_atomically(path, |w| encode_png(w, layers.width(), layers.height(), &values, depth))
}

/// Encodes values in [0, 1] (others are held within, NaN becomes 0), row by row from the top, as a grey PNG.
///
/// Fails if there are not `width` x `height` values, if one side is zero, or if `writer` fails.
pub fn encode_png(
    writer: &mut dyn Write,
    width: u32,
    height: u32,
    values: &[f32],
    depth: PngDepth,
) -> io::Result<()> {
    encode(writer, (width, height), ::png::ColorType::Grayscale, values, depth)
}

/// The same for red, green and blue.
///
/// # Errors
/// As of [`encode_png`].
pub fn encode_colour_png(
    writer: &mut dyn Write,
    width: u32,
    height: u32,
    values: &[[f32; 3]],
    depth: PngDepth,
) -> io::Result<()> {
    encode(writer, (width, height), ::png::ColorType::Rgb, values.as_flattened(), depth)
}

fn encode(
    writer: &mut dyn Write,
    (width, height): (u32, u32),
    colour: ::png::ColorType,
    values: &[f32],
    depth: PngDepth,
) -> io::Result<()> {
    let samples = match depth {
        PngDepth::Eight => values.iter().map(|&v| quantise(v, 255.0) as u8).collect(),
        PngDepth::Sixteen => {
            values.iter().flat_map(|&v| quantise(v, 65535.0).to_be_bytes()).collect::<Vec<u8>>()
        }
    };
    let mut encoder = ::png::Encoder::new(writer, width, height);
    encoder.set_color(colour);
    encoder.set_depth(match depth {
        PngDepth::Eight => ::png::BitDepth::Eight,
        PngDepth::Sixteen => ::png::BitDepth::Sixteen,
    });
    let mut file = encoder.write_header()?;
    file.write_image_data(&samples)?;
    Ok(file.finish()?)
}

/// The nearest of the steps 0 to `steps`.
fn quantise(value: f32, steps: f64) -> u16 {
    (f64::from(value).clamp(0.0, 1.0) * steps).round() as u16
}

/// Reads a grey PNG of 8 or 16 bits; nothing else is accepted.
///
/// At most [`MAX_PIXELS`] pixels, and no more than the file's size can hold: memory is not taken on the word of a header.
pub fn read_png(path: impl AsRef<Path>) -> Result<GreyImage, TargetError> {
    let path = path.as_ref();
    decode_png(&input::read_file(path)?).map_err(|problem| TargetError::Image { path: path.into(), problem })
}

fn decode_png(bytes: &[u8]) -> Result<GreyImage, String> {
    // What the decoder may take beside the image itself, for chunks of metadata.
    let limits = ::png::Limits { bytes: 64 << 20 };
    let mut decoder = ::png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(::png::Transformations::IDENTITY);
    let info = decoder.read_header_info().map_err(|e| e.to_string())?;
    let (width, height) = info.size();
    let pixels = u64::from(width) * u64::from(height);
    let (depth, pixel_bytes) = match (info.color_type, info.bit_depth) {
        (::png::ColorType::Grayscale, ::png::BitDepth::Eight) => (PngDepth::Eight, 1),
        (::png::ColorType::Grayscale, ::png::BitDepth::Sixteen) => (PngDepth::Sixteen, 2),
        other => return Err(format!("it is not a grey PNG of 8 or 16 bits, but {other:?}")),
    };
    let most = (bytes.len() as u64).saturating_mul(input::MAX_DEFLATE_RATIO) / pixel_bytes;
    if pixels > MAX_PIXELS.min(most) {
        return Err(format!("{width}x{height} pixels: more than the limit, or than the file can hold"));
    }
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let mut samples = vec![0; (pixels * pixel_bytes) as usize];
    if reader.output_buffer_size() != Some(samples.len()) {
        return Err("its rows do not fit its size".into());
    }
    reader.next_frame(&mut samples).map_err(|e| e.to_string())?;
    let values = match depth {
        PngDepth::Eight => samples.iter().map(|&s| f32::from(s) / 255.0).collect(),
        PngDepth::Sixteen => samples
            .chunks_exact(2)
            .map(|s| (f64::from(u16::from_be_bytes([s[0], s[1]])) / 65535.0) as f32)
            .collect(),
    };
    Ok(GreyImage { width, height, depth, values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn encoded(width: u32, values: &[f32], depth: PngDepth) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode_png(&mut bytes, width, values.len() as u32 / width, values, depth).unwrap();
        bytes
    }

    #[test]
    fn the_header_says_grey_of_the_depth_asked_for() {
        for (depth, bits) in [(PngDepth::Eight, 8), (PngDepth::Sixteen, 16)] {
            let bytes = encoded(3, &[0.5; 6], depth);
            assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
            assert_eq!(&bytes[12..16], b"IHDR");
            // Width, height, bits, colour type 0 (grey), deflate, filter 0, not interlaced: PNG specification, 11.2.1.
            assert_eq!(bytes[16..29], [0, 0, 0, 3, 0, 0, 0, 2, bits, 0, 0, 0, 0]);
            assert!(!bytes.windows(4).any(|w| w == b"gAMA" || w == b"sRGB"));
        }
    }

    #[test]
    fn values_round_to_the_nearest_step() {
        let exact = [0.0, 0.25, 0.498, 0.5, 0.503, 1.0, -3.0, 7.0, f32::NAN, f32::INFINITY];
        let truth = [0.0, 64.0, 127.0, 128.0, 128.0, 255.0, 0.0, 255.0, 0.0, 255.0];
        let image = decode_png(&encoded(5, &exact, PngDepth::Eight)).unwrap();
        assert_eq!((image.width, image.height), (5, 2));
        for (found, step) in image.values.iter().zip(truth) {
            assert_eq!(*found, step / 255.0);
        }
    }

    proptest! {
        #[test]
        fn round_trips_stay_within_half_a_step(
            values in prop::collection::vec(0f32..=1.0, 1..80), sixteen in any::<bool>(),
        ) {
            let (depth, steps) = if sixteen { (PngDepth::Sixteen, 65535.0) } else { (PngDepth::Eight, 255.0) };
            let image = decode_png(&encoded(1, &values, depth)).unwrap();
            prop_assert_eq!(image.depth, depth);
            for (a, b) in values.iter().zip(&image.values) {
                prop_assert!(f64::from((a - b).abs()) <= 0.5 / steps + 1e-7);
            }
            // Steps themselves survive exactly.
            prop_assert_eq!(encoded(1, &image.values, depth), encoded(1, &values, depth));
        }

        #[test]
        fn damaged_files_are_refused_or_read_but_never_panic(
            cut in 0usize..200, flips in prop::collection::vec((0usize..200, any::<u8>()), 0..4),
        ) {
            let mut bytes = encoded(8, &(0..64).map(|i| i as f32 / 64.0).collect::<Vec<_>>(), PngDepth::Sixteen);
            let whole = bytes.len();
            for (at, x) in flips {
                bytes[at % whole] ^= x;
            }
            bytes.truncate(whole.saturating_sub(cut));
            let _ = decode_png(&bytes);
            // The image data ends 16 bytes before the end: 4 of checksum, 12 of IEND.
            if cut > 16 {
                prop_assert!(decode_png(&bytes).is_err());
            }
        }
    }

    #[test]
    fn absurd_sizes_are_refused_before_memory_is_taken() {
        let mut bytes = encoded(3, &[0.5; 6], PngDepth::Eight);
        bytes[16..24].copy_from_slice(&[0, 0, 0x3f, 0xff, 0, 0, 0x3f, 0xff]);
        let crc = crc32(&bytes[12..29]).to_be_bytes();
        bytes[29..33].copy_from_slice(&crc);
        let problem = decode_png(&bytes).unwrap_err();
        assert!(problem.contains("16383x16383"), "{problem}");
    }

    /// PNG specification, annex D.
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ c >> 1 } else { c >> 1 })
        })
    }

    #[test]
    fn other_colours_and_wrong_counts_are_refused() {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, 1, 1);
        encoder.set_color(::png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&[1, 2, 3]).unwrap();
        assert!(decode_png(&bytes).unwrap_err().contains("Rgb"));
        assert!(encode_png(&mut Vec::new(), 2, 2, &[0.0; 3], PngDepth::Eight).is_err());
        assert!(encode_png(&mut Vec::new(), 0, 2, &[], PngDepth::Eight).is_err());
    }

    #[test]
    fn files_report_their_name() {
        let error = read_png("/absent/a.png").unwrap_err();
        assert!(error.to_string().contains("/absent/a.png"));
        assert_eq!(error.fault(), crate::Fault::Input);
    }

    /// A camera that sees a disc, half of its points pending.
    #[test]
    fn images_of_interrupted_work_are_white_outside_and_filled_inside() {
        use crate::{Camera, CameraTarget, Target};
        use conray_core::{Estimate, SurfacePoint, Vec3, View};
        let (eye, look_at, up) = (Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y);
        let view = View { name: String::new(), eye, look_at, up, vertical_fov_deg: 60.0 };
        let target = CameraTarget::trace(Camera::new(&view, 24, 24).unwrap(), |ray| {
            let p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
            (p.truncate().length() < 1.5).then(|| SurfacePoint::new(p, Vec3::Z))
        });
        let half = Estimate { visibility: 0.5, error: 0.0, rays: 1, bent: Vec3::Z, cone: None };
        let pending = |i: usize| if i.is_multiple_of(2) { Estimate::PENDING } else { half };
        let estimates: Vec<_> = (0..target.points().len()).map(pending).collect();
        let layers = target.resolve(&estimates).unwrap();
        assert_eq!(layers.pending(), target.points().len().div_ceil(2));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_png(&path, &layers, PngDepth::Eight).unwrap();
        let image = read_png(&path).unwrap();
        for (value, coverage) in image.values.iter().zip(layers.coverage()) {
            assert_eq!(*value, if *coverage == 0.0 { 1.0 } else { 128.0 / 255.0 });
        }
    }
}
