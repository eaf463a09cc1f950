//! Scene files.

mod error;
mod extras;
mod format;
mod gltf;
mod image_alpha;
mod image_file;
mod image_normals;
mod intake;
mod limits;
mod normals;
mod obj;
mod ply;
mod polygon;
mod soup;
mod source;
mod stl;
mod text;
mod weld;

pub(crate) use error::shown;
pub use error::{Fault, Place, SceneError};
pub use extras::Extras;
pub use format::Format;
pub use limits::Limits;
pub use normals::CREASE_ANGLE_DEG;
pub(crate) use normals::face_normal;
pub use source::Resolver;
pub(crate) use weld::key as position_key;

use crate::{Scene, known::add_known_views};
use intake::Intake;
use source::{Folder, read_file};
use std::path::Path;

/// Loads a scene file and the files that it names.
///
/// The format goes by the name's ending, else by the content. Some well-known files get named views. Files named in the scene are looked for beside it:
/// see [`load_bytes`] for scenes that are not on a disc.
///
/// # Errors
///
/// [`SceneError`] names the file and the fault. A material file or texture that is missing, a degenerate triangle and
/// the like are [`warnings`](Scene::warnings) instead.
pub fn load(path: &Path, limits: &Limits) -> Result<Scene, SceneError> {
    load_with(path, limits, Extras::default())
}

/// The same with more of what a file holds than what occludes.
///
/// # Errors
///
/// As for [`load`].
pub fn load_with(path: &Path, limits: &Limits, extras: Extras) -> Result<Scene, SceneError> {
    let at = |fault| SceneError { path: path.to_path_buf(), fault };
    let bytes = read_file(path, limits.max_file_bytes).map_err(at)?;
    let root = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let folder = Folder { root, max_bytes: limits.max_file_bytes };
    load_named(path, &bytes, None, &|name| folder.read(name), limits, extras).map_err(at)
}

/// Loads a scene from the bytes of its file.
///
/// `name` stands for the file in messages, and its stem names the scene; without a `format` it tells that too.
/// `resolve` hands out the other files (materials, textures, buffers) by the names written in the scene.
///
/// # Errors
///
/// As for [`load`].
pub fn load_bytes(
    name: &str,
    bytes: &[u8],
    format: Option<Format>,
    resolve: &Resolver,
    limits: &Limits,
) -> Result<Scene, SceneError> {
    load_bytes_with(name, bytes, format, resolve, limits, Extras::default())
}

/// The same with more of what a file holds than what occludes.
///
/// # Errors
///
/// As for [`load`].
pub fn load_bytes_with(
    name: &str,
    bytes: &[u8],
    format: Option<Format>,
    resolve: &Resolver,
    limits: &Limits,
    extras: Extras,
) -> Result<Scene, SceneError> {
    load_named(Path::new(name), bytes, format, resolve, limits, extras)
        .map_err(|fault| SceneError { path: name.into(), fault })
}

/// The file name that a URI of a glTF stands for: `%xx` is the byte of that value (RFC 3986, section 2.1).
pub fn percent_decoded(uri: &str) -> String {
    String::from_utf8_lossy(&gltf::percent_decoded(uri)).into_owned()
}

fn load_named(
    path: &Path,
    bytes: &[u8],
    format: Option<Format>,
    resolve: &Resolver,
    limits: &Limits,
    extras: Extras,
) -> Result<Scene, Fault> {
    Limits::check("bytes in the file", bytes.len() as u64, limits.max_file_bytes)?;
    let format = format.or_else(|| Format::detect(path, bytes)).ok_or(Fault::UnknownFormat)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut intake = Intake::new(name, resolve, limits, extras);
    match format {
        Format::Obj => obj::load(bytes, &mut intake)?,
        Format::Gltf => gltf::load(bytes, &mut intake)?,
        Format::Ply => ply::load(bytes, &mut intake)?,
        Format::Stl => stl::load(bytes, &mut intake)?,
    }
    let mut scene = intake.scene;
    for warning in scene.inspect() {
        scene.warn(warning.kind, warning.count, warning.example);
    }
    add_known_views(&mut scene);
    Ok(scene)
}
