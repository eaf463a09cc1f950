//! Named camera views.

use crate::Vec3;

/// A perspective view of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// How `--view` calls it.
    pub name: String,
    /// Position of the camera.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub look_at: Vec3,
    /// Which way is up in the picture.
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub vertical_fov_deg: f32,
}
