//! STL, text and binary: triangles without connections.
//!
//! After "StereoLithography Interface Specification", 3D Systems, 1988. Equal corners are welded; the normals in the
//! file, which say no more than the corners do, are not read.

use super::error::{Fault, shown};
use super::intake::Intake;
use super::normals::fill_normals;
use super::soup::{Corner, NONE, Part, Soup};
use super::text::{Lines, float, name, word};
use super::weld;
use conray_core::{Affine3A, Vec3};
use std::collections::HashMap;

/// Bytes of free text at the start of a binary file; the count of triangles follows.
const HEADER_BYTES: usize = 80;
/// Bytes of a triangle: normal and three corners as floats, two more bytes.
const TRIANGLE_BYTES: usize = 50;

/// Loads an STL as one mesh.
pub(super) fn load(bytes: &[u8], intake: &mut Intake) -> Result<(), Fault> {
    let mut soup = Welded::default();
    let name = if is_text(bytes) {
        read_text(bytes, &mut soup, intake)?
    } else {
        read_binary(bytes, &mut soup, intake)?
    };
    let mut soup = soup.soup;
    if soup.triangles.is_empty() {
        return Err(Fault::NoTriangles);
    }
    fill_normals(&mut soup);
    let part =
        Part { name: name.clone(), material: 0, runs: std::iter::once(0..soup.triangles.len()).collect() };
    intake.add_mesh(soup.mesh(part)?, Affine3A::IDENTITY, name)
}

/// Binary files may start with `solid` too: one whose length fits its count is binary.
fn is_text(bytes: &[u8]) -> bool {
    let fits = count(bytes).is_some_and(|n| {
        bytes.len() as u64 == (HEADER_BYTES + 4) as u64 + u64::from(n) * TRIANGLE_BYTES as u64
    });
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    !fits && text.len() >= 5 && text[..5].eq_ignore_ascii_case(b"solid")
}

fn count(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(HEADER_BYTES..HEADER_BYTES + 4)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

/// A soup whose equal positions are one.
#[derive(Default)]
struct Welded {
    soup: Soup,
    index_of: HashMap<[u32; 3], u32>,
}

impl Welded {
    fn push(&mut self, corners: [Vec3; 3]) {
        let triangle = corners.map(|p| {
            let position = *self.index_of.entry(weld::key(p)).or_insert_with(|| {
                self.soup.positions.push(p);
                self.soup.positions.len() as u32 - 1
            });
            Corner { position, uv: NONE, normal: NONE }
        });
        self.soup.triangles.push(triangle);
    }
}

fn read_binary(bytes: &[u8], out: &mut Welded, intake: &Intake) -> Result<String, Fault> {
    let truncated = |what: String| Fault::byte(bytes.len(), format!("the file ends {what}"));
    let count = count(bytes).ok_or_else(|| truncated("within the header of 84 bytes".into()))? as usize;
    intake.limits.check_triangles(count)?;
    let body = &bytes[HEADER_BYTES + 4..];
    let there = body.len() / TRIANGLE_BYTES;
    if there < count {
        return Err(truncated(format!("within triangle {} of {count}", there + 1)));
    }
    out.soup.triangles.reserve_exact(count);
    for (t, triangle) in body.chunks_exact(TRIANGLE_BYTES).take(count).enumerate() {
        let number = |i: usize| f32::from_le_bytes(triangle[4 * i..4 * i + 4].try_into().unwrap_or_default());
        let corners = [3, 6, 9].map(|i| Vec3::new(number(i), number(i + 1), number(i + 2)));
        if !corners.iter().all(|c| c.is_finite()) {
            return Err(Fault::element(format!("triangle {}", t + 1), "a corner is not finite"));
        }
        out.push(corners);
    }
    Ok(String::new())
}

fn read_text(bytes: &[u8], out: &mut Welded, intake: &Intake) -> Result<String, Fault> {
    let (mut solid, mut corners, mut last_line) = (None, Vec::with_capacity(3), 0);
    let mut inside = false;
    for (line, content) in Lines::new(bytes) {
        last_line = line;
        let mut rest = &content[..];
        match word(&mut rest).to_ascii_lowercase().as_slice() {
            b"solid" => solid = solid.or(Some(name(rest))),
            b"facet" if inside => return Err(Fault::line(line, "`facet` within a facet")),
            b"facet" => inside = true,
            b"vertex" if !inside => return Err(Fault::line(line, "`vertex` outside a facet")),
            b"vertex" => corners.push(corner(rest, line)?),
            b"endfacet" => {
                let triangle = <[Vec3; 3]>::try_from(std::mem::take(&mut corners)).map_err(|c| {
                    Fault::line(line, format!("a facet needs 3 vertices, this one has {}", c.len()))
                })?;
                out.push(triangle);
                inside = false;
                intake.limits.check_triangles(out.soup.triangles.len())?;
            }
            b"" | b"outer" | b"endloop" | b"endsolid" => {}
            other => return Err(Fault::line(line, format!("`{}` is not a word of STL", shown(other)))),
        }
    }
    if inside {
        return Err(Fault::line(last_line, "the file ends within a facet"));
    }
    Ok(solid.unwrap_or_default())
}

fn corner(mut rest: &[u8], line: u64) -> Result<Vec3, Fault> {
    let mut p = [0.0; 3];
    for x in &mut p {
        let word = word(&mut rest);
        *x = float(word).ok_or_else(|| Fault::line(line, format!("`{}` is not a number", shown(word))))?;
    }
    let p = Vec3::from_array(p);
    if p.is_finite() { Ok(p) } else { Err(Fault::line(line, "the vertex is not finite")) }
}
