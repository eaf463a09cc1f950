//! What can go wrong in a study, by whose fault.

use std::path::PathBuf;
use thiserror::Error;

/// Why a study stopped. No earlier report is harmed by any of them.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The request is wrong: an unknown method, a view that shows nothing.
    #[error("{0}")]
    Request(String),
    /// A file kept from an earlier run cannot be used.
    #[error("{}: {problem}", path.display())]
    Kept {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// A file or folder that cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Output {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// A rival's library that was there and failed.
    #[error("{name}: {problem}")]
    Rival {
        /// The contender.
        name: String,
        /// What it says.
        problem: String,
    },
    /// Stopped on request; what was finished is kept and the same command goes on from there.
    #[error("interrupted: the same command goes on from here")]
    Interrupted,
    /// Anything of the library.
    #[error(transparent)]
    Conray(#[from] conray::Error),
}

impl From<conray::target::TargetError> for StudyError {
    fn from(error: conray::target::TargetError) -> Self {
        Self::Conray(error.into())
    }
}
