//! What can be wrong with a scene file, by whose fault it is.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a file is no scene; its message starts with the file's name.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct SceneError {
    /// The scene file as it was named.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What is wrong with a scene file.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// Nothing is there under that name.
    #[error("there is no such file")]
    NotFound,
    /// It is there, but the system does not hand it out.
    #[error("it cannot be read: {0}")]
    CannotRead(io::Error),
    /// Neither name nor content tell what it is.
    #[error("unknown format; OBJ, glTF, GLB, PLY and STL are known")]
    UnknownFormat,
    /// The content breaks the rules of its format.
    #[error("{place}{reason}")]
    Malformed {
        /// Where.
        place: Place,
        /// Which rule, in plain words.
        reason: String,
    },
    /// The content may be right, but needs something that is not built.
    #[error("{feature} is not supported")]
    Unsupported {
        /// Name of the feature or extension.
        feature: String,
    },
    /// It asks for more than [`Limits`](crate::Limits) allow.
    #[error("too many {what}: {found} are more than the limit of {limit}")]
    LimitExceeded {
        /// What there is too much of.
        what: &'static str,
        /// How much the file asks for.
        found: u64,
        /// How much is allowed.
        limit: u64,
    },
    /// It can be read and holds nothing that occludes.
    #[error("there are no triangles")]
    NoTriangles,
}

/// Where in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, from 1.
    Line(u64),
    /// A byte, from 0.
    Byte(u64),
    /// A part with a name of its own, such as `accessor 3`.
    Element(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Byte(byte) => write!(f, "byte {byte}: "),
            Self::Element(name) => write!(f, "{name}: "),
        }
    }
}

impl Fault {
    /// A broken rule in a line.
    pub(super) fn line(line: u64, reason: impl Into<String>) -> Self {
        Self::Malformed { place: Place::Line(line), reason: reason.into() }
    }

    /// A broken rule at a byte.
    pub(super) fn byte(byte: usize, reason: impl Into<String>) -> Self {
        Self::Malformed { place: Place::Byte(byte as u64), reason: reason.into() }
    }

    /// A broken rule in a named element.
    pub(super) fn element(name: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Malformed { place: Place::Element(name.into()), reason: reason.into() }
    }

    /// A broken rule of the whole file.
    pub(super) fn file(reason: impl Into<String>) -> Self {
        Self::Malformed { place: Place::File, reason: reason.into() }
    }

    /// A feature that is not built.
    pub(super) fn unsupported(feature: impl Into<String>) -> Self {
        Self::Unsupported { feature: feature.into() }
    }
}

/// Text of a file as a message may show it: at most 40 characters, no control characters.
pub(crate) fn shown(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(&text[..text.len().min(160)]);
    let mut shown: String =
        text.chars().take(40).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().count() > 40 {
        shown.push_str("...");
    }
    shown
}
