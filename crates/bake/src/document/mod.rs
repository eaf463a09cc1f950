//! A glTF file as it is written, for changes in a few places.
//!
//! The JSON is kept as it stands - order of keys, numbers to the last bit of a double, extensions and extras that nobody here knows - and so are the bytes of the
//! binary chunk, to which more are appended. What is added goes at the end of the document's lists, so that no index changes.
//!
//! ("glTF 2.0 Specification", sections 3.2 and 4.4.)

mod add;
mod bounds;
mod colours;
mod container;
mod files;
mod gather;

pub use files::Files;
pub use gather::Buffers;

use serde_json::{Map, Value};
use thiserror::Error;

/// How a document is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `.glb`: one file.
    Binary,
    /// `.gltf`: text, with files beside it.
    Text,
}

/// Why a file is no document that could be changed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum DocumentError {
    /// The container is cut short or wrong.
    #[error("{0}")]
    Container(String),
    /// The text is no JSON.
    #[error("its JSON cannot be read: {0}")]
    Json(String),
    /// A part of the document is not what it must be.
    #[error("`{place}` is not {wanted}")]
    Shape {
        /// Where, such as `materials/3`.
        place: String,
        /// What it should be.
        wanted: &'static str,
    },
    /// A part that is referred to does not exist.
    #[error("`{0}` does not exist")]
    Missing(String),
}

/// A glTF document.
#[derive(Clone, Debug)]
pub struct Document {
    kind: Kind,
    root: Map<String, Value>,
    /// The binary chunk, or what a text document's added buffer will hold.
    bin: Vec<u8>,
    /// Chunks of other kinds, kept in their order.
    chunks: Vec<(u32, Vec<u8>)>,
    /// The buffer to which bytes are appended, once any were.
    buffer: Option<usize>,
    /// Files that a text document gains: name and bytes.
    added: Vec<(String, Vec<u8>)>,
}

impl Document {
    /// How it is stored.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The whole JSON.
    pub fn root(&self) -> &Map<String, Value> {
        &self.root
    }

    /// Elements of one of the document's lists, such as `materials`.
    pub fn count(&self, list: &str) -> usize {
        self.root.get(list).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// An element of one of the document's lists.
    ///
    /// # Errors
    /// Where it does not exist or is no object.
    pub fn element(&self, list: &str, index: usize) -> Result<&Map<String, Value>, DocumentError> {
        let place = || format!("{list}/{index}");
        let value = self.root.get(list).and_then(|list| list.get(index));
        let value = value.ok_or_else(|| DocumentError::Missing(place()))?;
        value.as_object().ok_or_else(|| DocumentError::Shape { place: place(), wanted: "an object" })
    }

    /// The same, to be changed.
    ///
    /// # Errors
    /// Where it does not exist or is no object.
    pub fn element_mut(
        &mut self,
        list: &str,
        index: usize,
    ) -> Result<&mut Map<String, Value>, DocumentError> {
        let place = || format!("{list}/{index}");
        let value = self.root.get_mut(list).and_then(|list| list.get_mut(index));
        let value = value.ok_or_else(|| DocumentError::Missing(place()))?;
        value.as_object_mut().ok_or_else(|| DocumentError::Shape { place: place(), wanted: "an object" })
    }
}
