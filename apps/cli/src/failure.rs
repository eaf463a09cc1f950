//! Failures and their exit codes.

use conray::{
    Error, StateError, VoxelError,
    scene::SceneError,
    target::{Fault, TargetError},
};
use conray_study::StudyError;
use std::{fmt, process::ExitCode};

/// Why the program stops, by whose fault it is.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The work failed or was interrupted: exit code 1.
    Work(String),
    /// The request was wrong: exit code 2.
    Request(String),
    /// The input could not be used: exit code 3.
    Input(String),
}

impl Failure {
    pub(crate) fn code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Work(_) => 1,
            Self::Request(_) => 2,
            Self::Input(_) => 3,
        })
    }

    /// Another message for a failure by the same fault.
    pub(crate) fn with(self, message: String) -> Self {
        match self {
            Self::Work(_) => Self::Work(message),
            Self::Request(_) => Self::Request(message),
            Self::Input(_) => Self::Input(message),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Work(message) | Self::Request(message) | Self::Input(message)) = self;
        f.write_str(message)
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<TargetError> for Failure {
    fn from(error: TargetError) -> Self {
        let message = match &error {
            TargetError::Settings { setting, problem } => format!("--{setting}: {problem}"),
            other => other.to_string(),
        };
        match error.fault() {
            Fault::Settings => Self::Request(message),
            Fault::Input | Fault::Limits => Self::Input(message),
            Fault::Output => Self::Work(message),
        }
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Conray(e) => e.into(),
            StudyError::Request(message) => Self::Request(message),
            e @ StudyError::Kept { .. } => Self::Input(e.to_string()),
            e => Self::Work(e.to_string()),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Scene(e) => e.into(),
            Error::Target(e) => e.into(),
            Error::Settings(e) => Self::Request(e.to_string()),
            Error::Device(e) => Self::Request(format!("--device: {e}")),
            Error::State { problem: StateError::Other(_), .. } => Self::Request(format!("--state {error}")),
            Error::State { .. } | Error::StateFile { .. } => Self::Input(error.to_string()),
            Error::Geometry(e) => Self::Input(e.to_string()),
            Error::Voxel(e @ VoxelError::MemoryLimit { .. }) => Self::Request(format!("--max-memory: {e}")),
            Error::Voxel(e) => Self::Input(e.to_string()),
            other => Self::Work(other.to_string()),
        }
    }
}
