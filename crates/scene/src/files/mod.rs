//! Scene files.

use crate::Scene;
use std::path::Path;

/// Bounds on what a file may ask for.
#[derive(Clone, Debug, Default)]
pub struct Limits {}

/// Why a file is no scene.
#[derive(Debug, thiserror::Error)]
#[error("not yet")]
pub struct SceneError;

/// Loads a scene.
pub fn load(_path: &Path, _limits: &Limits) -> Result<Scene, SceneError> {
    Err(SceneError)
}
