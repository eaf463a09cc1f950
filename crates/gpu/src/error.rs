//! Why a graphics processor did not do what was asked.

use conray_estimate::Method;
use thiserror::Error;

/// Why a graphics processor did not do what was asked.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GpuError {
    /// No adapter of that name, or none at all.
    #[error("no graphics adapter{}; there {found}", wanted.as_ref().map_or(String::new(), |name| format!(" has a name with {name}")))]
    NoAdapter {
        /// Part of the name that was asked for.
        wanted: Option<String>,
        /// What there is, for people.
        found: String,
    },
    /// The adapter does not hand out a device.
    #[error("{adapter} gives no device: {reason}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// Why.
        reason: String,
    },
    /// Something larger than the adapter takes.
    #[error("{what} need {bytes} bytes in one buffer, and {adapter} takes {limit}")]
    TooLarge {
        /// What.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// The adapter's name.
        adapter: String,
        /// The most that it takes.
        limit: u64,
    },
    /// A method, or a setting of one, that is not built for it.
    #[error("{0} runs on the CPU alone")]
    Unsupported(&'static str),
    /// A method whose structures were not given.
    #[error("nothing was uploaded for method {0}: build a session with it")]
    NotUploaded(Method),
    /// The device went away, or memory ran out, while it worked.
    #[error("{adapter} failed: {reason}")]
    Failed {
        /// The adapter's name.
        adapter: String,
        /// What it said.
        reason: String,
    },
}
