//! What the window tells the engine.

use crate::{camera::Look, engine::wire};
use conray::{AoSettings, Device};
use serde::{Deserialize, Serialize};
use std::{path::PathBuf, sync::Arc};

/// A message to the engine. The newest wish counts; questions are answered one after the other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Order {
    /// Opens a scene, which keeps that number; what is shown stays until it is there.
    Open(u64, Source),
    /// What is to be shown from now on.
    Wish(Box<Wish>),
    /// Something about what is shown.
    Ask(Question),
}

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Source {
    /// A built-in scene by its name.
    Builtin(String),
    /// A file with those beside it.
    File(PathBuf),
    /// A file by its name and bytes, and those dropped together with it: where there is no disc to read from.
    Bytes(NamedBytes, Vec<NamedBytes>),
}

/// A file in memory.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedBytes {
    /// Its name, without folders.
    pub name: String,
    /// What is in it.
    #[serde(with = "wire::shared_bytes")]
    pub bytes: Arc<[u8]>,
}

impl std::fmt::Debug for NamedBytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} bytes)", self.name, self.bytes.len())
    }
}

impl Source {
    /// As the program is told it: a name or a path.
    pub fn word(&self) -> String {
        match self {
            Self::Builtin(name) => name.clone(),
            Self::Bytes(file, _) => file.name.clone(),
            Self::File(path) => path.display().to_string(),
        }
    }
}

/// All that decides what is shown. Two wishes that are equal are one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wish {
    /// The number of the scene.
    pub scene: u64,
    /// From where.
    pub look: Look,
    /// Width and height in pixels, each at least 1.
    pub size: [u32; 2],
    /// The settings of one or two pictures side by side; they differ in the method.
    #[serde(with = "wire::as_json")]
    pub sides: Vec<AoSettings>,
    /// Where estimates are made.
    #[serde(with = "wire::device")]
    pub device: Device,
    /// Part of the name of the adapter that is meant.
    pub adapter: Option<String>,
    /// Counts how often the same was asked for anew.
    pub again: u32,
}

/// A question about what is shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Question {
    /// What a pixel of the wanted size sees, its cones by a side's settings, and some of its rays.
    Probe {
        /// Column and row.
        pixel: [u32; 2],
        /// 0 or 1.
        side: usize,
    },
    /// Which nodes of an octree's level the seen surfaces lie in.
    Boxes {
        /// 0 is the leaves.
        level: u32,
    },
    /// The truth of the view by so many rays a pixel; it keeps that name.
    Truth {
        /// What it is the truth of, for the one who asks.
        key: String,
        /// Rays a pixel.
        rays: u32,
    },
    /// No truth any more.
    StopTruth,
    /// The picture of a side as an EXR with all layers, to a file where one is named.
    Exr {
        /// 0 or 1.
        side: usize,
        /// Where to; without one the bytes come back.
        path: Option<PathBuf>,
    },
    /// An EXR image's visibility, to be compared with.
    ReadExr {
        /// What it is the truth of, for the one who asks.
        key: String,
        /// The file.
        source: Source,
    },
}
