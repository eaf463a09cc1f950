//! Layers to an EXR file.

use super::{FLOAT, LONG_NAMES, MAGIC, VERSION, ZIP, ZIP_ROWS, block::compress};
use crate::{Layers, TargetError, write_atomically};
use rayon::prelude::*;
use std::{io, io::Write, path::Path};

/// Longest name of an attribute or channel without and with the flag for long names.
const SHORT_NAME: usize = 31;
const LONG_NAME: usize = 255;
/// Longest value of a setting.
const MAX_TEXT_BYTES: usize = 1 << 20;

/// Writes all layers as 32-bit floats, ZIP-compressed, with each setting as a text attribute `conray.<key>`.
///
/// The visibility becomes `R`, `G` and `B` for simple viewers; all other channels keep their names
/// ([`Layers`]). Nothing is rounded or filled: pending pixels are NaN. The same layers and settings give the same bytes.
/// A key must be 1 to 248 bytes without NUL, a value at most 1 MiB; keys must differ ([`TargetError::Settings`]). The file
/// appears whole or not at all ([`write_atomically`]).
pub fn write_exr(
    path: impl AsRef<Path>,
    layers: &Layers,
    settings: &[(String, String)],
) -> Result<(), TargetError> {
    let image = image(layers, settings)?;
    write_atomically(path, |w| image.encode(w))
}

/// The bytes that [`write_exr`] writes, for those who have no files.
///
/// # Errors
/// As of [`write_exr`] for settings.
pub fn encode_exr(layers: &Layers, settings: &[(String, String)]) -> Result<Vec<u8>, TargetError> {
    let image = image(layers, settings)?;
    let mut bytes = Vec::new();
    let written = image.encode(&mut bytes);
    written.map_err(|source| TargetError::Output { path: "image.exr".into(), source })?;
    Ok(bytes)
}

fn image<'a>(layers: &'a Layers, settings: &'a [(String, String)]) -> Result<Image<'a>, TargetError> {
    let attributes = attributes(settings)?;
    let mut channels: Vec<(&str, &[f32])> = Vec::new();
    for channel in layers.channels() {
        let names: &[&str] = if channel.name == "visibility" { &["R", "G", "B"] } else { &[channel.name] };
        channels.extend(names.iter().map(|&name| (name, channel.values.as_slice())));
    }
    // The format asks for channels in the order of their names.
    channels.sort_by_key(|&(name, _)| name);
    Ok(Image { width: layers.width(), height: layers.height(), channels, attributes })
}

fn attributes(settings: &[(String, String)]) -> Result<Vec<(String, &str)>, TargetError> {
    let refuse = |problem| Err(TargetError::Settings { setting: "header", problem });
    let mut attributes: Vec<(String, &str)> = Vec::with_capacity(settings.len());
    for (key, value) in settings {
        let name = format!("conray.{key}");
        if key.is_empty() || name.len() > LONG_NAME || key.contains('\0') {
            return refuse(format!("{key:?} is no name for an attribute"));
        }
        if value.len() > MAX_TEXT_BYTES {
            return refuse(format!("{key}: {} bytes are more than {MAX_TEXT_BYTES}", value.len()));
        }
        if attributes.iter().any(|(earlier, _)| *earlier == name) {
            return refuse(format!("{key} is given twice"));
        }
        attributes.push((name, value));
    }
    Ok(attributes)
}

struct Image<'a> {
    width: u32,
    height: u32,
    /// Sorted by name.
    channels: Vec<(&'a str, &'a [f32])>,
    attributes: Vec<(String, &'a str)>,
}

impl Image<'_> {
    fn encode(&self, writer: &mut dyn Write) -> io::Result<()> {
        let blocks: Vec<Vec<u8>> = (0..self.height.div_ceil(ZIP_ROWS))
            .into_par_iter()
            .map(|block| compress(self.block_bytes(block)))
            .collect::<io::Result<_>>()?;
        let header = self.header();
        let mut offset = header.len() + 8 * blocks.len();
        writer.write_all(&header)?;
        for block in &blocks {
            writer.write_all(&(offset as u64).to_le_bytes())?;
            offset += 8 + block.len();
        }
        for (i, block) in (0u32..).zip(&blocks) {
            writer.write_all(&(i * ZIP_ROWS).to_le_bytes())?;
            writer.write_all(&(block.len() as u32).to_le_bytes())?;
            writer.write_all(block)?;
        }
        Ok(())
    }

    /// Rows of a block from the top; in each the channels in order, in each the pixels from the left.
    fn block_bytes(&self, block: u32) -> Vec<u8> {
        let (top, bottom) = (block * ZIP_ROWS, ((block + 1) * ZIP_ROWS).min(self.height));
        let width = self.width as usize;
        let mut bytes = Vec::with_capacity((bottom - top) as usize * width * self.channels.len() * 4);
        for y in top as usize..bottom as usize {
            for (_, values) in &self.channels {
                bytes.extend(values[y * width..(y + 1) * width].iter().flat_map(|v| v.to_le_bytes()));
            }
        }
        bytes
    }

    fn header(&self) -> Vec<u8> {
        let mut h = MAGIC.to_vec();
        let long = self.attributes.iter().any(|(name, _)| name.len() > SHORT_NAME);
        h.extend((VERSION | if long { LONG_NAMES } else { 0 }).to_le_bytes());
        attribute(&mut h, "channels", "chlist", &self.channel_list());
        attribute(&mut h, "compression", "compression", &[ZIP]);
        let [right, bottom] = [self.width - 1, self.height - 1].map(u32::to_le_bytes);
        let window = [[0; 4], [0; 4], right, bottom].concat();
        attribute(&mut h, "dataWindow", "box2i", &window);
        attribute(&mut h, "displayWindow", "box2i", &window);
        attribute(&mut h, "lineOrder", "lineOrder", &[0]);
        attribute(&mut h, "pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute(&mut h, "screenWindowCenter", "v2f", &[0; 8]);
        attribute(&mut h, "screenWindowWidth", "float", &1f32.to_le_bytes());
        for (name, value) in &self.attributes {
            attribute(&mut h, name, "string", value.as_bytes());
        }
        h.push(0);
        h
    }

    /// Name, pixel type, four bytes of hints that do not matter here, and sampling at every pixel, for each channel.
    fn channel_list(&self) -> Vec<u8> {
        let mut list = Vec::new();
        for (name, _) in &self.channels {
            list.extend(name.as_bytes());
            list.push(0);
            list.extend([FLOAT.to_le_bytes(), [0; 4], 1i32.to_le_bytes(), 1i32.to_le_bytes()].concat());
        }
        list.push(0);
        list
    }
}

fn attribute(header: &mut Vec<u8>, name: &str, kind: &str, value: &[u8]) {
    for text in [name, kind] {
        header.extend(text.as_bytes());
        header.push(0);
    }
    header.extend((value.len() as u32).to_le_bytes());
    header.extend(value);
}
