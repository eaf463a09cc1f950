//! The files about a text document.

use super::{Buffers, Document, DocumentError, Kind};
use serde_json::Value;

/// What a document written elsewhere needs beside it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Files {
    /// Files that were added: name and bytes.
    pub added: Vec<(String, Vec<u8>)>,
    /// Names, as written in the document, of files that it had: to be copied where it is written into another folder.
    pub had: Vec<String>,
}

impl Document {
    /// The files that go with it.
    pub fn files(&self) -> Files {
        let mut added = self.added.clone();
        if self.kind == Kind::Text
            && let Some(uri) = self.buffer.and_then(|buffer| self.uri("buffers", buffer))
        {
            added.push((uri.to_string(), self.bin.clone()));
        }
        let is_added = |uri: &str| added.iter().any(|(name, _)| name == uri);
        let lists = ["buffers", "images"].into_iter();
        let uris = lists.flat_map(|list| (0..self.count(list)).filter_map(move |k| self.uri(list, k)));
        let mut had: Vec<String> = Vec::new();
        for uri in uris.filter(|uri| !uri.starts_with("data:") && !is_added(uri)) {
            if !had.iter().any(|known| known == uri) {
                had.push(uri.to_string());
            }
        }
        Files { added, had }
    }

    /// The bytes of a buffer view; `None` where it, or what it is of, does not exist.
    pub fn view_bytes(&self, view: usize, buffers: &Buffers) -> Option<Vec<u8>> {
        let view = self.element("bufferViews", view).ok()?;
        let number = |key: &str| view.get(key).map_or(Some(0), |value| usize::try_from(value.as_u64()?).ok());
        let length = usize::try_from(view.get("byteLength")?.as_u64()?).ok()?;
        Some(buffers.range(number("buffer")?, number("byteOffset")?, length)?.to_vec())
    }

    /// Gives a texture the sampler of another, or none.
    ///
    /// # Errors
    /// Where one of them does not exist or is no object.
    pub fn copy_sampler(&mut self, from: usize, to: usize) -> Result<(), DocumentError> {
        let sampler = self.element("textures", from)?.get("sampler").cloned();
        let texture = self.element_mut("textures", to)?;
        match sampler {
            Some(sampler) => _ = texture.insert("sampler".into(), sampler),
            None => _ = texture.shift_remove("sampler"),
        }
        Ok(())
    }

    pub(super) fn uri(&self, list: &str, index: usize) -> Option<&str> {
        self.root.get(list)?.get(index)?.get("uri").and_then(Value::as_str)
    }
}
