//! Buffers and buffer views: the bytes behind a glTF's accessors and images.

use super::meshopt::decode;
use super::schema::{Buffer, Root};
use super::uri::read_uri;
use crate::files::error::{Fault, shown};
use crate::files::intake::Intake;
use crate::files::limits::Limits;
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::HashMap;

/// Geometry may take this many bytes whatever the size of its files.
const FREE_BYTES: u64 = 64 << 20;

/// All bytes of a document.
pub(super) struct Data<'a> {
    /// The document.
    pub root: &'a Root,
    buffers: Vec<Cow<'a, [u8]>>,
    /// For each buffer the first one of the same URI, whose bytes it shares.
    same_as: Vec<usize>,
    /// Views that were compressed.
    decoded: Vec<Option<Vec<u8>>>,
    total_bytes: usize,
    budget: Budget,
}

/// How much memory geometry may still take: what files back, times a limit.
struct Budget {
    used: Cell<u64>,
    allowed: u64,
}

/// The bytes of a view and the distance between its elements, where it sets one.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub bytes: &'a [u8],
    pub stride: Option<usize>,
}

/// An element of a list, or a fault that says who asked for it.
pub(super) fn get<'a, T>(list: &'a [T], index: usize, what: &str, asker: &str) -> Result<&'a T, Fault> {
    let there_are = || format!("{what} {index} does not exist: there are {}", list.len());
    list.get(index).ok_or_else(|| Fault::element(asker, there_are()))
}

impl<'a> Data<'a> {
    /// Reads all buffers and decompresses all views that need it.
    pub(super) fn load(
        root: &'a Root,
        bin: Option<&'a [u8]>,
        file_bytes: usize,
        intake: &Intake,
    ) -> Result<Self, Fault> {
        let (mut buffers, mut same_as) = (Vec::<Cow<[u8]>>::new(), Vec::new());
        let mut first_of: HashMap<&str, usize> = HashMap::new();
        let mut total = file_bytes as u64;
        for (i, buffer) in root.buffers.iter().enumerate() {
            let same = buffer.uri.as_deref().map_or(i, |uri| *first_of.entry(uri).or_insert(i));
            let bytes = if same == i { read_buffer(buffer, i, bin, intake)? } else { Cow::Borrowed(&[][..]) };
            total += if matches!(bytes, Cow::Owned(_)) { bytes.len() as u64 } else { 0 };
            Limits::check("bytes in the buffers", total, intake.limits.max_file_bytes)?;
            let there = if same == i { bytes.len() } else { buffers[same].len() };
            if there < buffer.byte_length && !is_fallback(buffer) {
                let reason = format!("it has {there} bytes, {} are declared", buffer.byte_length);
                return Err(Fault::element(format!("buffer {i}"), reason));
            }
            buffers.push(bytes);
            same_as.push(same);
        }
        let allowed = FREE_BYTES.saturating_add(total.saturating_mul(intake.limits.max_expansion));
        let budget = Budget { used: Cell::new(0), allowed };
        let mut data =
            Self { root, buffers, same_as, decoded: Vec::new(), total_bytes: total as usize, budget };
        for i in 0..root.buffer_views.len() {
            let decoded = data.decompress(i)?;
            data.total_bytes += decoded.as_ref().map_or(0, Vec::len);
            data.decoded.push(decoded);
        }
        Ok(data)
    }

    /// Takes `bytes` off what geometry may use, before they are set aside.
    pub(super) fn spend(&self, bytes: u64) -> Result<(), Fault> {
        let found = self.budget.used.get().saturating_add(bytes);
        Limits::check("bytes of geometry for so small a file", found, self.budget.allowed)?;
        self.budget.used.set(found);
        Ok(())
    }

    fn buffer_range(&self, buffer: usize, offset: usize, length: usize, asker: &str) -> Result<&[u8], Fault> {
        let same = *get(&self.same_as, buffer, "buffer", asker)?;
        let bytes = &self.buffers[same];
        bytes.get(offset..).and_then(|rest| rest.get(..length)).ok_or_else(|| {
            let there = bytes.len();
            let reason = format!(
                "bytes {offset} to {} of buffer {buffer}, which has {there}",
                offset.saturating_add(length)
            );
            Fault::element(asker, reason)
        })
    }

    fn decompress(&self, index: usize) -> Result<Option<Vec<u8>>, Fault> {
        let extensions = &self.root.buffer_views[index].extensions;
        let Some(meshopt) = extensions.ext_meshopt.as_ref().or(extensions.khr_meshopt.as_ref()) else {
            return Ok(None);
        };
        let asker = format!("buffer view {index}");
        let bytes = self.buffer_range(meshopt.buffer, meshopt.byte_offset, meshopt.byte_length, &asker)?;
        self.spend((meshopt.count as u64).saturating_mul(meshopt.byte_stride as u64))?;
        decode(meshopt, bytes).map_err(|reason| Fault::element(asker, reason)).map(Some)
    }

    /// The bytes of a buffer view; `asker` is who wants them.
    pub(super) fn view(&self, index: usize, asker: &str) -> Result<View<'_>, Fault> {
        let view = get(&self.root.buffer_views, index, "buffer view", asker)?;
        let extensions = &view.extensions;
        if let Some(bytes) = &self.decoded[index] {
            let meshopt = extensions.ext_meshopt.as_ref().or(extensions.khr_meshopt.as_ref());
            return Ok(View { bytes, stride: meshopt.map(|m| m.byte_stride) });
        }
        let name = format!("buffer view {index}");
        let bytes = self.buffer_range(view.buffer, view.byte_offset, view.byte_length, &name)?;
        Ok(View { bytes, stride: view.byte_stride.filter(|&s| s > 0) })
    }

    /// Bytes of all files and what they were decompressed to: no accessor of that many elements is plausible.
    pub(super) fn total_bytes(&self) -> usize {
        self.total_bytes
    }
}

/// A buffer that only stands for what compressed views decode to.
fn is_fallback(buffer: &Buffer) -> bool {
    buffer.uri.is_none()
        && (buffer.extensions.ext_meshopt.is_some() || buffer.extensions.khr_meshopt.is_some())
}

fn read_buffer<'a>(
    buffer: &Buffer,
    index: usize,
    bin: Option<&'a [u8]>,
    intake: &Intake,
) -> Result<Cow<'a, [u8]>, Fault> {
    let name = format!("buffer {index}");
    match &buffer.uri {
        Some(uri) => match read_uri(uri, &name, intake)? {
            Ok(bytes) => Ok(Cow::Owned(bytes)),
            Err(error) => {
                Err(Fault::element(name, format!("`{}` cannot be read: {error}", shown(uri.as_bytes()))))
            }
        },
        None if is_fallback(buffer) => Ok(Cow::Borrowed(&[])),
        None if index == 0 && bin.is_some() => Ok(Cow::Borrowed(bin.unwrap_or_default())),
        None => Err(Fault::element(name, "it has no URI, and the file has no binary chunk for it")),
    }
}
