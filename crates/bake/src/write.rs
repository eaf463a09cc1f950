//! What a bake writes: PNG maps, and models that show them.

use crate::{
    AssignError, BentSpace, Buffers, Document, Kind, Origins, Sheets, Uvs, assign,
    packed::{packed, share},
};
use base64::{Engine, prelude::BASE64_STANDARD};
use conray_core::Vec3;
use conray_target::{AtlasMap, PngDepth, TargetError, encode_colour_png, encode_png, write_atomically};
use std::{
    collections::BTreeSet,
    fs, io,
    path::{Component, Path, PathBuf},
};
use thiserror::Error;

/// Why a baked model is not written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The document cannot show the maps.
    #[error(transparent)]
    Assign(#[from] AssignError),
    /// A file cannot be written.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// A file that the model needs cannot be copied beside it.
    #[error("{}: cannot be copied to {}: {reason}", from.display(), to.display())]
    Copy {
        /// The file.
        from: PathBuf,
        /// Where it should go.
        to: PathBuf,
        /// What the system says.
        reason: String,
    },
}

/// What is done to visibility for its looks, apart from what is true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Occlusion is multiplied by this, and held at 1; 1 is the truth.
    pub intensity: f32,
    /// Visibility is raised to this power; 1 is the truth.
    pub power: f32,
}

impl Default for Look {
    fn default() -> Self {
        Self { intensity: 1.0, power: 1.0 }
    }
}

impl Look {
    /// A visibility as it is to look.
    pub fn of(self, visibility: f32) -> f32 {
        // To the bit what it was where nothing is wanted.
        if self == Self::default() {
            return visibility;
        }
        (1.0 - self.intensity * (1.0 - visibility)).clamp(0.0, 1.0).powf(self.power)
    }
}

/// How maps become PNG files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PngOptions {
    /// Bits per sample.
    pub depth: PngDepth,
    /// What is done for the looks.
    pub look: Look,
    /// Occlusion goes into the red channel of the image of roughness and metalness, where a material reads both by the same UVs.
    pub packs: bool,
}

/// What bent directions of a PNG are, and which way green points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BentColours {
    /// World space.
    World,
    /// Tangent space, green up in the picture, as in glTF and OpenGL.
    Tangent,
    /// Tangent space, green down, as in DirectX.
    TangentDown,
}

impl BentColours {
    /// The space of the directions.
    pub fn space(self) -> BentSpace {
        if self == Self::World { BentSpace::World } else { BentSpace::Tangent }
    }
}

/// Bent directions of a map, baked in the space of the colours, as a PNG: unit vectors, each axis from -1 to 1 as 0 to 1. What has no direction points nowhere in the
/// world, (0.5, 0.5, 0.5), and straight up in tangent space.
pub fn bent_png(map: &AtlasMap, colours: BentColours, depth: PngDepth) -> Vec<u8> {
    let (none, green) = match colours {
        BentColours::World => (Vec3::ZERO, 1.0),
        BentColours::Tangent => (Vec3::Z, 1.0),
        BentColours::TangentDown => (Vec3::Z, -1.0),
    };
    let colour = |bent: &Vec3| (0.5 * Vec3::new(1.0, green, 1.0) * bent.normalize_or(none) + 0.5).to_array();
    let values: Vec<[f32; 3]> = map.bent.iter().map(colour).collect();
    let mut bytes = Vec::new();
    encode_colour_png(&mut bytes, map.width, map.height, &values, depth)
        .expect("maps have a size, and memory takes all");
    bytes
}

/// A map as a grey PNG: linear visibility, 1 is white. What has no value is white.
pub fn png(map: &AtlasMap, PngOptions { depth, look, .. }: PngOptions) -> Vec<u8> {
    let values: Vec<f32> =
        map.visibility.iter().map(|&v| if v.is_nan() { 1.0 } else { look.of(v) }).collect();
    let mut bytes = Vec::new();
    encode_png(&mut bytes, map.width, map.height, &values, depth)
        .expect("maps have a size, and memory takes all");
    bytes
}

/// Names for the files of sheets: those of the sheets with only letters, digits, `-`, `_` and `.`, each once.
pub fn file_names(sheets: &Sheets) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name = |wanted: &str| {
        let wanted: String = wanted.chars().map(plain).collect();
        let mut name = wanted.trim_start_matches('.').to_string();
        for more in 2.. {
            // Names that differ in case only are the same file on some systems.
            if !name.is_empty() && taken.insert(name.to_lowercase()) {
                break;
            }
            name = format!("{wanted}-{more}");
        }
        name
    };
    sheets.sheets.iter().map(|sheet| sheet.name.as_str()).map(name).collect()
}

/// What was written, and what was not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Files, the model last.
    pub files: Vec<PathBuf>,
    /// Maps that were to be packed with roughness and metalness and were not, each with the reason, for people.
    pub not_packed: Vec<String>,
    /// Names of files that the document has and that were not copied beside it: missing, or outside its folder.
    pub not_copied: Vec<String>,
}

/// Writes a model that shows its maps, and beside a text document the files that it gained and, in another folder, those that it had. Files are whole
/// or not there; the model itself comes last.
///
/// # Errors
/// What the document or the disc refuses; files that were written before stay.
pub fn write_model(
    path: &Path,
    source: &Path,
    mut document: Document,
    origins: &Origins<'_>,
    sheets: &Sheets,
    maps: &[AtlasMap],
    options: PngOptions,
) -> Result<Written, WriteError> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let anew = sheets.sheets.iter().any(|sheet| matches!(sheet.uvs, Uvs::New { .. }));
    let buffers = if anew || options.packs { buffers_of(&document, source)? } else { Buffers::default() };
    let (mut textures, mut shared, mut not_packed) = (Vec::new(), Vec::new(), Vec::new());
    for ((sheet, name), map) in sheets.sheets.iter().zip(file_names(sheets)).zip(maps) {
        let packed = match options.packs {
            true => packed(&document, source, &buffers, origins, sheet, map, options.look)?,
            false => Err(String::new()),
        };
        let (bytes, before, ending) = match packed {
            Ok((bytes, before)) => (bytes, Some(before), "orm"),
            Err(reason) => {
                if options.packs {
                    not_packed.push(format!("{}: {reason}", sheet.name));
                }
                (png(map, options), None, "ao")
            }
        };
        let texture = document.push_png(bytes, &format!("{stem}-{name}-{ending}"), sheet.repeats);
        let texture = texture.map_err(AssignError::from)?;
        if let Some(before) = before {
            document.copy_sampler(before, texture).map_err(AssignError::from)?;
            shared.push((sheet, texture));
        }
        textures.push(texture);
    }
    assign(&mut document, origins, sheets, &textures, &buffers, &format!("{stem}-ao"))?;
    for (sheet, texture) in shared {
        share(&mut document, origins, sheet, texture)?;
    }
    Ok(Written { not_packed, ..write_document(path, source, &document)? })
}

/// The buffers of a document that was read from there.
pub(crate) fn buffers_of(document: &Document, source: &Path) -> Result<Buffers, AssignError> {
    Ok(Buffers::of(document, |uri| bytes_of(source, uri))?)
}

/// Writes a document that was read from `source`, with its files.
pub(crate) fn write_document(path: &Path, source: &Path, document: &Document) -> Result<Written, WriteError> {
    let bytes = document.to_bytes().map_err(AssignError::from)?;
    let mut written = Written::default();
    if document.kind() == Kind::Text {
        let folder = path.parent().unwrap_or(Path::new(""));
        let files = document.files();
        for uri in &files.had {
            match copied(source.parent().unwrap_or(Path::new("")), folder, uri)? {
                Copied::Yes(path) => written.files.push(path),
                Copied::IsThere => {}
                Copied::No => written.not_copied.push(uri.clone()),
            }
        }
        for (name, bytes) in &files.added {
            let to = folder.join(name);
            write_atomically(&to, |out| out.write_all(bytes))?;
            written.files.push(to);
        }
    }
    write_atomically(path, |out| out.write_all(&bytes))?;
    written.files.push(path.to_path_buf());
    Ok(written)
}

/// The bytes of a buffer: a file beside the model, or data in it.
pub(crate) fn bytes_of(model: &Path, uri: &str) -> Option<Vec<u8>> {
    match uri.strip_prefix("data:") {
        Some(inline) => BASE64_STANDARD.decode(inline.split_once(";base64,")?.1).ok(),
        None => fs::read(model.parent()?.join(conray_scene::percent_decoded(uri))).ok(),
    }
}

/// What became of a file that a document names.
enum Copied {
    Yes(PathBuf),
    /// It is where it should be.
    IsThere,
    No,
}

/// Copies a file that a document names into another folder, unless it would lie outside that folder.
fn copied(from: &Path, to: &Path, uri: &str) -> Result<Copied, WriteError> {
    let name = PathBuf::from(conray_scene::percent_decoded(uri));
    let is_inside = name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let (from, to) = (from.join(&name), to.join(&name));
    if !from.is_file() || !is_inside {
        return Ok(if same(&from, &to) { Copied::IsThere } else { Copied::No });
    }
    if same(&from, &to) {
        return Ok(Copied::IsThere);
    }
    let fault = |e: io::Error| WriteError::Copy { from: from.clone(), to: to.clone(), reason: e.to_string() };
    let bytes = fs::read(&from).map_err(fault)?;
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(fault)?;
    }
    write_atomically(&to, |out| out.write_all(&bytes))?;
    Ok(Copied::Yes(to))
}

/// True for two names of one file that is there.
fn same(a: &Path, b: &Path) -> bool {
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
