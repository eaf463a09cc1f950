//! Scenes made by code.

use crate::Scene;

/// Names that [`builtin`] knows.
pub const BUILTIN_NAMES: [&str; 4] = ["cornell", "cornell-blocks", "atrium", "grove"];

/// Makes a built-in scene; `None` for an unknown name.
pub fn builtin(_name: &str) -> Option<Scene> {
    None
}
