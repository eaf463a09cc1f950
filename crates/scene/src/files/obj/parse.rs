//! OBJ text to triangles whose corners refer to positions, UVs and normals.
//!
//! After "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual, Wavefront, 1995: polygons only, no
//! free-form surfaces.

use super::faces::FaceReader;
use crate::WarningKind;
use crate::files::error::{Fault, shown};
use crate::files::intake::Intake;
use crate::files::normals::unit;
use crate::files::soup::{NONE, Soup};
use crate::files::text::{Lines, float, name, word};
use conray_core::{Vec2, Vec3};
use std::collections::HashMap;

/// What an OBJ file says, before its materials are looked up.
#[derive(Default)]
pub(super) struct ObjFile {
    /// The triangles; corners without a normal still lack it.
    pub soup: Soup,
    /// Stretches of triangles under one object, group and material.
    pub runs: Vec<Run>,
    /// Names of objects, groups and materials.
    pub names: Names,
    /// The `mtllib` statements.
    pub material_files: Vec<String>,
    /// Whether `o` occurs; else `g` names the objects.
    pub has_objects: bool,
}

/// A stretch of triangles, as far as the start of the next one; names are indices into [`Names`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Run {
    /// Its first triangle.
    pub start: usize,
    /// Name after `o`.
    pub object: u32,
    /// Names after `g`.
    pub group: u32,
    /// Name after `usemtl`.
    pub material: u32,
}

/// Each name once; index 0 is the empty name.
pub(super) struct Names {
    list: Vec<String>,
    index_of: HashMap<String, u32>,
}

impl Default for Names {
    fn default() -> Self {
        Self { list: vec![String::new()], index_of: HashMap::from([(String::new(), 0)]) }
    }
}

impl Names {
    fn index(&mut self, name: String) -> u32 {
        *self.index_of.entry(name).or_insert_with_key(|name| {
            self.list.push(name.clone());
            self.list.len() as u32 - 1
        })
    }

    /// The name of an index.
    pub(super) fn get(&self, index: u32) -> &str {
        &self.list[index as usize]
    }
}

/// Reads a whole OBJ file.
pub(super) fn parse(text: &[u8], intake: &mut Intake) -> Result<ObjFile, Fault> {
    let (mut file, mut faces, mut run) = (ObjFile::default(), FaceReader::default(), Run::default());
    for (line, content) in Lines::joined(text) {
        let mut rest = &content[..];
        let keyword = word(&mut rest);
        match keyword {
            b"v" => {
                let position = vector::<3>(rest, line, "v")?;
                if !position.iter().all(|x| x.is_finite()) {
                    return Err(Fault::line(line, "the vertex is not finite"));
                }
                file.soup.positions.push(Vec3::from_array(position));
            }
            b"vt" => file.soup.uvs.push(texture_coordinate(rest, line, intake)?),
            b"vn" => {
                let normal = Vec3::from_array(vector::<3>(rest, line, "vn")?);
                // Zero marks a bad one until the corners that use it have been told.
                file.soup.normals.push(unit(normal));
            }
            b"f" | b"fo" => {
                if file.runs.last().is_none_or(|last| Run { start: last.start, ..run } != *last) {
                    file.runs.push(Run { start: file.soup.triangles.len(), ..run });
                }
                faces.read(rest, line, &mut file.soup)?;
                intake.limits.check_triangles(file.soup.triangles.len())?;
            }
            b"o" => (run.object, file.has_objects) = (file.names.index(name(rest)), true),
            b"g" => run.group = file.names.index(name(rest)),
            b"usemtl" => run.material = file.names.index(name(rest)),
            b"mtllib" => file.material_files.push(name(rest)),
            b"l" | b"p" => intake.scene.warn(WarningKind::IgnoredPrimitives, 1, format!("line {line}")),
            // Smoothing groups, levels of detail and display hints change no surface.
            b"" | b"s" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" | b"mg" | b"shadow_obj"
            | b"trace_obj" => {}
            _ if keyword.starts_with(b"#") => {}
            _ => {
                let example = format!("`{}` in line {line}", shown(keyword));
                intake.scene.warn(WarningKind::IgnoredFeature, 1, example);
            }
        }
    }
    let counts = [file.soup.positions.len(), file.soup.uvs.len(), file.soup.normals.len()];
    counts.iter().try_for_each(|&count| intake.limits.check_vertices(count))?;
    faces.finish(counts)?;
    intake.scene.warn(WarningKind::IgnoredFaces, faces.ignored, format!("line {}", faces.ignored_line));
    drop_bad_normals(&mut file.soup, intake);
    Ok(file)
}

/// The first `N` numbers of a statement; more are let be (weights, vertex colours).
#[inline]
fn vector<const N: usize>(mut rest: &[u8], line: u64, keyword: &str) -> Result<[f32; N], Fault> {
    let mut out = [0.0; N];
    for slot in &mut out {
        let word = word(&mut rest);
        *slot = float(word).ok_or_else(|| {
            Fault::line(
                line,
                match word {
                    b"" => format!("`{keyword}` needs {N} numbers"),
                    _ => format!("`{}` is not a number", shown(word)),
                },
            )
        })?;
    }
    Ok(out)
}

/// One or two numbers; those that are not finite become 0.
fn texture_coordinate(mut rest: &[u8], line: u64, intake: &mut Intake) -> Result<Vec2, Fault> {
    let [u] = vector::<1>(rest, line, "vt")?;
    word(&mut rest);
    let v = if rest.trim_ascii().is_empty() { 0.0 } else { vector::<1>(rest, line, "vt")?[0] };
    let uv = Vec2::new(u, v);
    if uv.is_finite() {
        return Ok(uv);
    }
    let example = format!("a texture coordinate that is not finite in line {line}, taken as 0");
    intake.scene.warn(WarningKind::IgnoredFeature, 1, example);
    Ok(Vec2::ZERO)
}

/// Corners with a normal of no length get one from their faces later.
fn drop_bad_normals(soup: &mut Soup, intake: &mut Intake) {
    let bad = soup.normals.iter().filter(|n| **n == Vec3::ZERO).count() as u64;
    let Some(first) = soup.normals.iter().position(|n| *n == Vec3::ZERO) else { return };
    intake.scene.warn(WarningKind::BadNormals, bad, format!("normal {}", first + 1));
    for corner in soup.triangles.as_flattened_mut() {
        if soup.normals.get(corner.normal as usize) == Some(&Vec3::ZERO) {
            corner.normal = NONE;
        }
    }
}
