//! From files and from code to scenes.
//!
//! [`load`] reads OBJ with MTL, glTF 2.0 and GLB, PLY and STL; [`builtin`] makes scenes without any file. Both give a
//! [`Scene`]: geometry in world units, named views, and a list of [`Warning`]s about what was mended or ignored.

mod builtin;
mod files;
mod inspect;
mod known;
mod model;

pub use builtin::{BUILTIN_NAMES, builtin};
pub use files::{
    CREASE_ANGLE_DEG, Extras, Fault, Format, Limits, Place, Resolver, SceneError, load, load_bytes,
    load_bytes_with, load_with, percent_decoded,
};
pub use model::{Origin, Scene, Warning, WarningKind};
