//! What can go wrong, by whose fault.

use crate::PlyError;
use std::{io, path::PathBuf};
use thiserror::Error;

/// Whose fault an error is; programs choose their exit code by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// A file that was given cannot be used.
    Input,
    /// The request itself is wrong.
    Settings,
    /// The result could not be stored.
    Output,
    /// The input is larger than a stated limit.
    Limits,
}

/// Why a target could not be made, resolved or written.
#[derive(Debug, Error)]
pub enum TargetError {
    /// A setting is outside its range.
    #[error("{setting}: {problem}")]
    Settings {
        /// Which setting: `eye`, `up`, `fov`, `size`, ...
        setting: &'static str,
        /// What is wrong with it, and its range.
        problem: String,
    },
    /// The estimates do not belong to the target's points.
    #[error("there are {found} estimates for {expected} surface points")]
    EstimateCount {
        /// How many points the target has.
        expected: usize,
        /// How many estimates came.
        found: usize,
    },
    /// More places are asked about than there are ids of points.
    #[error(
        "the maps have more than 4294967295 texels, or parts of texels; choose smaller ones, or fewer parts"
    )]
    TooManyTexels,
    /// Two images or slices cannot be compared.
    #[error("cannot be compared: {0}")]
    Incomparable(String),
    /// A file that cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A PLY file that holds no usable points.
    #[error("{}: {problem}", path.display())]
    Points {
        /// The file.
        path: PathBuf,
        /// Which element or line, and why.
        problem: PlyError,
    },
    /// An image file that cannot be decoded.
    #[error("{}: {problem}", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: String,
    },
    /// An input larger than a stated limit.
    #[error("{}: {what}: {count} are more than the limit of {limit}", path.display())]
    Limits {
        /// The file.
        path: PathBuf,
        /// Kind of thing.
        what: &'static str,
        /// How many.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// A file that cannot be written; an earlier file of that name is as it was.
    #[error("{}: cannot be written: {source}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl TargetError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Settings { .. } | Self::EstimateCount { .. } | Self::Incomparable(_) => Fault::Settings,
            Self::Unreadable { .. } | Self::Points { .. } | Self::Image { .. } => Fault::Input,
            Self::Limits { .. } | Self::TooManyTexels => Fault::Limits,
            Self::Output { .. } => Fault::Output,
        }
    }
}
