//! The files about a text document.

use super::{Document, Kind};
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

    pub(super) fn uri(&self, list: &str, index: usize) -> Option<&str> {
        self.root.get(list)?.get(index)?.get("uri").and_then(Value::as_str)
    }
}
