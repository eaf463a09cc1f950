//! PLY: a polygon mesh.

mod header;
mod values;

use crate::WarningKind;
use crate::files::error::Fault;
use crate::files::intake::Intake;
use crate::files::limits::Limits;
use crate::files::normals::{fill_normals, repair_normals, unit};
use crate::files::polygon::triangulate;
use crate::files::soup::{Corner, NONE, Part, Soup};
use conray_core::{Affine3A, TriangleMesh, Vec2, Vec3};
use header::{Element, parse_header};
use values::Values;

/// What a PLY file holds.
#[derive(Default)]
struct PlyFile {
    positions: Vec<Vec3>,
    /// Unit normals, one per position or none at all; zero where the file has one without a direction.
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    ignored_faces: u64,
    first_ignored: u64,
}

/// Loads a PLY as one mesh. With normals in the file its vertices stay as they are, in their order; without, they
/// are split at creases.
pub(super) fn load(bytes: &[u8], intake: &mut Intake) -> Result<(), Fault> {
    let file = read(bytes, intake.limits)?;
    if file.triangles.is_empty() {
        return Err(Fault::NoTriangles);
    }
    intake.scene.warn(WarningKind::IgnoredFaces, file.ignored_faces, format!("face {}", file.first_ignored));
    let mesh = if file.normals.is_empty() { creased(file, intake)? } else { as_written(file, intake)? };
    intake.add_mesh(mesh, Affine3A::IDENTITY, String::new())
}

fn read(bytes: &[u8], limits: &Limits) -> Result<PlyFile, Fault> {
    let header = parse_header(bytes)?;
    let mut values = Values::new(bytes, &header);
    let mut file = PlyFile::default();
    let mut has_vertices = false;
    for element in &header.elements {
        values.element = (&element.name, 0);
        match element.name.as_str() {
            "vertex" if !has_vertices => {
                limits.check_vertices(usize::try_from(element.count).unwrap_or(usize::MAX))?;
                read_vertices(element, &mut values, &mut file)?;
                has_vertices = true;
            }
            "face" | "tristrips" => {
                if !has_vertices {
                    return Err(Fault::unsupported(format!(
                        "PLY with element `{}` before `vertex`",
                        element.name
                    )));
                }
                read_faces(element, &mut values, &mut file, limits)?;
            }
            _ => skip(element, &mut values)?,
        }
    }
    if has_vertices { Ok(file) } else { Err(Fault::file("there is no element `vertex`")) }
}

fn skip<'a>(element: &'a Element, values: &mut Values<'a>) -> Result<(), Fault> {
    // Elements without properties take no bytes, however many are declared.
    let count = if element.properties.is_empty() { 0 } else { element.count };
    for index in 0..count {
        values.element.1 = index;
        element.properties.iter().try_for_each(|p| values.skip(p))?;
    }
    Ok(())
}

fn read_vertices<'a>(element: &'a Element, values: &mut Values<'a>, file: &mut PlyFile) -> Result<(), Fault> {
    let names: [&[&str]; 8] = [
        &["x"],
        &["y"],
        &["z"],
        &["nx", "normal_x"],
        &["ny", "normal_y"],
        &["nz", "normal_z"],
        &["s", "u", "texture_u", "texture_s"],
        &["t", "v", "texture_v", "texture_t"],
    ];
    let place =
        names.map(|names| element.property(names).filter(|&p| element.properties[p].length.is_none()));
    if place[..3].iter().any(Option::is_none) && element.count > 0 {
        return Err(Fault::element("element `vertex`", "it has no x, y and z"));
    }
    let has = |slots: std::ops::Range<usize>| place[slots].iter().all(Option::is_some);
    let (has_normals, has_uvs) = (has(3..6), has(6..8));
    let count = element.count as usize;
    file.positions.reserve_exact(count);
    file.normals.reserve_exact(if has_normals { count } else { 0 });
    file.uvs.reserve_exact(if has_uvs { count } else { 0 });

    let slot_of: Vec<Option<usize>> =
        (0..element.properties.len()).map(|p| place.iter().position(|&q| q == Some(p))).collect();
    for index in 0..element.count {
        values.element.1 = index;
        let mut row = [0.0f32; 8];
        for (property, slot) in element.properties.iter().zip(&slot_of) {
            match slot {
                Some(slot) => row[*slot] = values.float(property.scalar)?,
                None => values.skip(property)?,
            }
        }
        let position = Vec3::from_slice(&row);
        if !position.is_finite() {
            return Err(values.fault("the vertex is not finite"));
        }
        file.positions.push(position);
        if has_normals {
            file.normals.push(unit(Vec3::from_slice(&row[3..])));
        }
        if has_uvs {
            let uv = Vec2::from_slice(&row[6..]);
            file.uvs.push(if uv.is_finite() { uv } else { Vec2::ZERO });
        }
    }
    Ok(())
}

fn read_faces<'a>(
    element: &'a Element,
    values: &mut Values<'a>,
    file: &mut PlyFile,
    limits: &Limits,
) -> Result<(), Fault> {
    let list = element
        .property(&["vertex_indices", "vertex_index"])
        .filter(|&p| element.properties[p].length.is_some());
    let Some(list) = list else {
        let fault = Fault::element(format!("element `{}`", element.name), "it has no list `vertex_indices`");
        return if element.count == 0 { Ok(()) } else { Err(fault) };
    };
    let is_strip = element.name == "tristrips";
    let mut corners: Vec<i64> = Vec::new();
    for index in 0..element.count {
        values.element.1 = index;
        for (p, property) in element.properties.iter().enumerate() {
            let (true, Some(length)) = (p == list, property.length) else {
                values.skip(property)?;
                continue;
            };
            corners.clear();
            for _ in 0..values.length(length, property.scalar)? {
                let vertex = values.integer(property.scalar)?;
                let vertices = file.positions.len();
                let is_restart = is_strip && vertex == -1;
                if !is_restart && usize::try_from(vertex).map_or(true, |v| v >= vertices) {
                    let there_are = format!("there are {vertices} vertices");
                    return Err(values.fault(format!("vertex index {vertex} is out of range ({there_are})")));
                }
                corners.push(vertex);
            }
            if is_strip { file.push_strips(&corners) } else { file.push_face(&corners, index) }
        }
        limits.check_triangles(file.triangles.len())?;
    }
    Ok(())
}

impl PlyFile {
    fn push_face(&mut self, corners: &[i64], index: u64) {
        let mut ring: Vec<u32> = corners.iter().map(|&v| v as u32).collect();
        ring.dedup();
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        if ring.len() < 3 {
            self.first_ignored = if self.ignored_faces == 0 { index } else { self.first_ignored };
            self.ignored_faces += 1;
            return;
        }
        if let [a, b, c] = ring[..] {
            self.triangles.push([a, b, c]);
            return;
        }
        let points: Vec<Vec3> = ring.iter().map(|&v| self.positions[v as usize]).collect();
        triangulate(&points, |t| self.triangles.push(t.map(|i| ring[i])));
    }

    /// Strips apart by -1; every second triangle of a strip turns the other way.
    fn push_strips(&mut self, corners: &[i64]) {
        for strip in corners.split(|&v| v == -1) {
            for (i, w) in strip.windows(3).enumerate() {
                let [a, b, c] = [w[0], w[1], w[2]].map(|v| v as u32);
                if a != b && b != c && c != a {
                    self.triangles.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
        }
    }
}

fn as_written(file: PlyFile, intake: &mut Intake) -> Result<TriangleMesh, Fault> {
    let (positions, mut normals) = (file.positions, file.normals);
    let (bad, first) = repair_normals(&positions, &file.triangles, &mut normals);
    intake.scene.warn(WarningKind::BadNormals, bad, format!("vertex {first}"));
    let fault = |e: conray_core::GeometryError| Fault::file(e.to_string());
    let mesh =
        TriangleMesh::new(positions, file.triangles).map_err(fault)?.with_normals(normals).map_err(fault)?;
    if file.uvs.is_empty() { Ok(mesh) } else { mesh.with_uv_set(file.uvs).map_err(fault) }
}

fn creased(file: PlyFile, intake: &mut Intake) -> Result<TriangleMesh, Fault> {
    let has_uvs = !file.uvs.is_empty();
    let corner = |v: u32| Corner { position: v, uv: if has_uvs { v } else { NONE }, normal: NONE };
    let mut soup = Soup {
        triangles: file.triangles.iter().map(|t| t.map(corner)).collect(),
        positions: file.positions,
        uvs: file.uvs,
        normals: Vec::new(),
    };
    // The new mesh has the vertices that are in use only.
    let (unused, first) = soup.unused_positions();
    intake.scene.warn(WarningKind::UnusedVertices, unused, format!("vertex {first}"));
    fill_normals(&mut soup);
    let runs = std::iter::once(0..soup.triangles.len()).collect();
    soup.mesh(Part { runs, ..Part::default() })
}
