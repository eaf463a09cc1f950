//! An EXR file to its channels, for tests and tools: scan lines of 32-bit floats, not or ZIP-compressed.

use super::{FLOAT, LONG_NAMES, MAGIC, VERSION, ZIP, ZIP_ROWS, block::decompress};
use crate::{MAX_PIXELS, TargetError, input};
use std::path::Path;

/// Most channels of a file that is read.
const MAX_CHANNELS: usize = 256;

/// What an EXR file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Name and values of each channel, in the order of the file; row by row from the top.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Text attributes, in the order of the file.
    pub attributes: Vec<(String, String)>,
}

impl ExrImage {
    /// The values of one channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }
}

/// Reads all channels and text attributes of a file as [`crate::write_exr`] writes it.
///
/// Also files of other programs, if they are single-part scan-line images of 32-bit floats, not compressed or by ZIP or
/// ZIPS. Memory is not taken on the word of a header: never more than the file's size can hold.
pub fn read_exr_channels(path: impl AsRef<Path>) -> Result<ExrImage, TargetError> {
    let path = path.as_ref();
    decode(&input::read_file(path)?).map_err(|problem| TargetError::Image { path: path.into(), problem })
}

/// The same of bytes; `name` stands for the file in messages.
///
/// # Errors
/// [`TargetError::Image`] where they are no such image.
pub fn decode_exr_channels(name: &str, bytes: &[u8]) -> Result<ExrImage, TargetError> {
    decode(bytes).map_err(|problem| TargetError::Image { path: name.into(), problem })
}

pub(super) fn decode(bytes: &[u8]) -> Result<ExrImage, String> {
    let mut cursor = Cursor { bytes, at: 0 };
    let header = Header::read(&mut cursor)?;
    let (width, height) = (header.width as usize, header.height as usize);
    let row_bytes = width * header.channels.len() * 4;
    let total = row_bytes as u64 * height as u64;
    if total > (bytes.len() as u64).saturating_mul(input::MAX_DEFLATE_RATIO) {
        return Err(format!("{width}x{height} pixels: more than the file can hold"));
    }
    let mut channels: Vec<_> =
        header.channels.into_iter().map(|name| (name, vec![0f32; width * height])).collect();
    for block in 0..height.div_ceil(header.rows_per_block) {
        let offset = u64::from_le_bytes(cursor.array()?);
        let mut at = Cursor { bytes, at: usize::try_from(offset).unwrap_or(usize::MAX) };
        let top = i64::from(i32::from_le_bytes(at.array()?)) - i64::from(header.top);
        if top != (block * header.rows_per_block) as i64 {
            return Err(format!("block {block} starts at row {top}"));
        }
        let top = block * header.rows_per_block;
        let rows = header.rows_per_block.min(height - top);
        let size = u32::from_le_bytes(at.array()?) as usize;
        let packed = at.take(size)?;
        let raw = decompress(packed, rows * row_bytes).ok_or(format!("block {block} cannot be decoded"))?;
        let mut values = raw.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        for y in top..top + rows {
            for (_, channel) in &mut channels {
                channel[y * width..(y + 1) * width].fill_with(|| values.next().unwrap_or(f32::NAN));
            }
        }
    }
    Ok(ExrImage { width: header.width, height: header.height, channels, attributes: header.attributes })
}

struct Header {
    width: u32,
    height: u32,
    /// Number of the first row.
    top: i32,
    channels: Vec<String>,
    rows_per_block: usize,
    attributes: Vec<(String, String)>,
}

impl Header {
    fn read(cursor: &mut Cursor) -> Result<Self, String> {
        if cursor.array()? != MAGIC {
            return Err("it is not an EXR file".into());
        }
        let version = u32::from_le_bytes(cursor.array()?);
        if version & !LONG_NAMES != VERSION {
            return Err("tiled, deep or multi-part EXR files are not supported".into());
        }
        let (mut channels, mut compression, mut window) = (None, None, None);
        let mut attributes = Vec::new();
        loop {
            let name = cursor.text()?;
            if name.is_empty() {
                break;
            }
            let kind = cursor.text()?;
            let size = u32::from_le_bytes(cursor.array()?) as usize;
            let mut value = Cursor { bytes: cursor.take(size)?, at: 0 };
            match (name.as_str(), kind.as_str()) {
                ("channels", _) => channels = Some(channel_list(&mut value)?),
                ("compression", _) => compression = Some(value.array::<1>()?[0]),
                ("dataWindow", _) => window = Some(data_window(&mut value)?),
                (_, "string") => {
                    attributes.push((name, String::from_utf8_lossy(value.bytes).into_owned()));
                }
                _ => {}
            }
        }
        let missing = |what| format!("the header has no {what}");
        let (width, height, top) = window.ok_or_else(|| missing("data window"))?;
        let rows_per_block = match compression.ok_or_else(|| missing("compression"))? {
            // None and ZIPS: row by row.
            0 | 2 => 1,
            ZIP => ZIP_ROWS as usize,
            other => return Err(format!("compression {other} is not supported: none, ZIPS and ZIP are")),
        };
        let channels = channels.ok_or_else(|| missing("channels"))?;
        Ok(Self { width, height, top, channels, rows_per_block, attributes })
    }
}

fn channel_list(value: &mut Cursor) -> Result<Vec<String>, String> {
    let mut names = Vec::new();
    loop {
        let name = value.text()?;
        if name.is_empty() {
            return Ok(names);
        }
        let [kind, _, x, y] = [value.array()?, value.array()?, value.array()?, value.array()?];
        if i32::from_le_bytes(kind) != FLOAT {
            return Err(format!("channel {name} does not hold 32-bit floats"));
        }
        if [x, y].map(i32::from_le_bytes) != [1, 1] {
            return Err(format!("channel {name} is not sampled at every pixel"));
        }
        names.push(name);
        if names.len() > MAX_CHANNELS {
            return Err(format!("there are more than {MAX_CHANNELS} channels"));
        }
    }
}

/// Width, height and number of the first row.
fn data_window(value: &mut Cursor) -> Result<(u32, u32, i32), String> {
    let [left, top, right, bottom] =
        [value.array()?, value.array()?, value.array()?, value.array()?].map(i32::from_le_bytes);
    let side = |low: i32, high: i32| u32::try_from(i64::from(high) - i64::from(low) + 1).ok();
    match (side(left, right), side(top, bottom)) {
        (Some(w @ 1..), Some(h @ 1..)) if u64::from(w) * u64::from(h) <= MAX_PIXELS => Ok((w, h, top)),
        _ => Err(format!("the data window {left},{top} to {right},{bottom} is empty or too large")),
    }
}

/// Bytes read in order; the end is an error.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let taken = self.at.checked_add(count).and_then(|end| self.bytes.get(self.at..end));
        self.at = self.at.saturating_add(count);
        taken.ok_or_else(|| "the file is truncated or its sizes are wrong".into())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.take(N)?.try_into().map_err(|_| String::new())
    }

    /// Text up to a NUL.
    fn text(&mut self) -> Result<String, String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|&b| b == 0).ok_or("a name in the header does not end")?;
        self.at += length + 1;
        Ok(String::from_utf8_lossy(&rest[..length]).into_owned())
    }
}
