//! A primitive of a glTF mesh to a triangle mesh.

use super::accessor::Accessor;
use super::data::Data;
use super::schema::Primitive;
use crate::WarningKind;
use crate::files::error::Fault;
use crate::files::intake::Intake;
use crate::files::normals::{repair_normals, unit};
use conray_core::{GeometryError, TriangleMesh, Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// UV sets beyond this many are not read.
const MAX_UV_SETS: usize = 16;

/// Reads a primitive called `name` in messages; `None` where it has no triangles.
///
/// Only the vertices that its triangles use are kept, in the order of their first use; told is which of the accessors they are. Without normals the mesh is flat,
/// as the specification says in section 3.7.2.1.
pub(super) fn read_primitive(
    data: &Data,
    name: &str,
    primitive: &Primitive,
    intake: &mut Intake,
) -> Result<Option<(TriangleMesh, Vec<u32>)>, Fault> {
    let mode = primitive.mode.unwrap_or(4);
    if mode > 6 {
        return Err(Fault::element(name, format!("mode {mode} is not known")));
    }
    let Some(&position) = primitive.attributes.get("POSITION").filter(|_| mode >= 4) else {
        intake.scene.warn(WarningKind::IgnoredPrimitives, 1, name);
        return Ok(None);
    };
    if !primitive.targets.is_empty() {
        intake.scene.warn(WarningKind::IgnoredFeature, 1, format!("morph targets of {name}, shown at rest"));
    }
    let positions = Accessor::new(data, position, name)?.with_width(3, position, "POSITION")?;
    if primitive.extensions.draco.is_some() && data.root.accessors[position].buffer_view.is_none() {
        return Err(Fault::unsupported("KHR_draco_mesh_compression"));
    }
    let corners = corner_count(data, name, primitive, positions.count)?;
    // Twelve bytes each for the corner's place in a triangle, position, normal, and map entry, eight for a UV set.
    data.spend((corners as u64).saturating_mul(if mode == 4 { 20 } else { 60 }))?;
    intake.limits.check_triangles(corners / if mode == 4 { 3 } else { 1 })?;
    let triangles = triangles(&indices(data, name, primitive, positions.count)?, mode, name, intake);
    if triangles.is_empty() {
        return Ok(None);
    }
    let (triangles, vertices) = compact(&triangles, positions.count, name)?;
    data.spend((vertices.len() as u64).saturating_mul(60))?;
    let fault = |e: GeometryError| Fault::element(name, e.to_string());
    let mut points = Vec::with_capacity(vertices.len());
    for &v in &vertices {
        let p = Vec3::from_array(positions.floats(v as usize));
        if !p.is_finite() {
            return Err(Fault::element(name, format!("vertex {v} is not finite")));
        }
        points.push(p);
    }
    let normals = normals(data, name, primitive, &positions, &vertices)?.map(|mut normals| {
        let (bad, first) = repair_normals(&points, &triangles, &mut normals);
        intake.scene.warn(WarningKind::BadNormals, bad, format!("vertex {first} of {name}"));
        normals
    });
    let mut mesh = TriangleMesh::new(points, triangles).map_err(fault)?;
    if let Some(normals) = normals {
        mesh = mesh.with_normals(normals).map_err(fault)?;
    }
    // Without normals the tangents are to be passed over: section 3.7.2.1 again.
    if intake.extras.tangents
        && !mesh.normals().is_empty()
        && let Some(tangents) = tangents(data, name, primitive, &positions, &vertices)?
    {
        mesh = mesh.with_tangents(tangents).map_err(fault)?;
    }
    for uvs in uv_sets(data, name, primitive, &positions, &vertices)? {
        mesh = mesh.with_uv_set(uvs).map_err(fault)?;
    }
    Ok(Some((mesh, vertices)))
}

fn corner_count(data: &Data, name: &str, primitive: &Primitive, vertices: usize) -> Result<usize, Fault> {
    match primitive.indices {
        Some(indices) => Ok(Accessor::new(data, indices, name)?.count),
        None => Ok(vertices),
    }
}

fn indices(data: &Data, name: &str, primitive: &Primitive, vertices: usize) -> Result<Vec<u32>, Fault> {
    let Some(index) = primitive.indices else {
        return Ok((0..u32::try_from(vertices).unwrap_or(u32::MAX)).collect());
    };
    let accessor = Accessor::new(data, index, name)?.with_width(1, index, "a list of indices")?;
    let not_unsigned = || Fault::element(format!("accessor {index}"), "indices must be unsigned integers");
    (0..accessor.count).map(|i| accessor.unsigned(i).ok_or_else(not_unsigned)).collect()
}

/// Lists, strips and fans: "glTF 2.0 Specification", section 3.7.2.1.
fn triangles(corners: &[u32], mode: u32, name: &str, intake: &mut Intake) -> Vec<[u32; 3]> {
    let differ = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    let mut out: Vec<[u32; 3]> = match mode {
        4 => corners.as_chunks::<3>().0.to_vec(),
        // Repeated corners restart a strip: they make no surface.
        5 => (corners.windows(3).enumerate())
            .map(|(i, w)| [w[0], w[1 + i % 2], w[2 - i % 2]])
            .filter(differ)
            .collect(),
        _ => corners.windows(2).skip(1).map(|w| [w[0], w[1], corners[0]]).filter(differ).collect(),
    };
    out.shrink_to_fit();
    if mode == 4 && !corners.len().is_multiple_of(3) {
        intake.scene.warn(WarningKind::IgnoredFaces, 1, format!("the last of {name}"));
    }
    out
}

/// Renumbers the vertices that triangles use by their first use; returns which ones they are.
fn compact(triangles: &[[u32; 3]], count: usize, name: &str) -> Result<(Vec<[u32; 3]>, Vec<u32>), Fault> {
    if let Some(index) = triangles.iter().flatten().find(|&&v| v as usize >= count) {
        let reason = format!("vertex index {index} is out of range (there are {count} vertices)");
        return Err(Fault::element(name, reason));
    }
    let mut vertices = Vec::new();
    let mut next = |v: u32| {
        vertices.push(v);
        vertices.len() as u32 - 1
    };
    // A primitive that uses a small part of a large shared list needs no table as long as the list.
    let renumbered = if triangles.len() < count / 16 {
        let mut new_of = HashMap::new();
        triangles.iter().map(|t| t.map(|v| *new_of.entry(v).or_insert_with(|| next(v)))).collect()
    } else {
        let mut new_of = vec![u32::MAX; count];
        let mut renumber = |v: u32| {
            let new = &mut new_of[v as usize];
            if *new == u32::MAX {
                *new = next(v);
            }
            *new
        };
        triangles.iter().map(|t| t.map(&mut renumber)).collect()
    };
    Ok((renumbered, vertices))
}

/// An attribute of as many elements as there are positions.
fn attribute<'a>(
    data: &'a Data,
    name: &str,
    primitive: &Primitive,
    key: &str,
    width: usize,
    positions: &Accessor,
) -> Result<Option<Accessor<'a>>, Fault> {
    let Some(&index) = primitive.attributes.get(key) else { return Ok(None) };
    let accessor = Accessor::new(data, index, name)?.with_width(width, index, key)?;
    if accessor.count < positions.count {
        let reason = format!("{key} has {} elements for {} vertices", accessor.count, positions.count);
        return Err(Fault::element(name, reason));
    }
    Ok(Some(accessor))
}

fn normals(
    data: &Data,
    name: &str,
    primitive: &Primitive,
    positions: &Accessor,
    vertices: &[u32],
) -> Result<Option<Vec<Vec3>>, Fault> {
    let accessor = attribute(data, name, primitive, "NORMAL", 3, positions)?;
    Ok(accessor.map(|a| vertices.iter().map(|&v| unit(Vec3::from_array(a.floats(v as usize)))).collect()))
}

/// Tangents as they are, of no length where they say nothing.
fn tangents(
    data: &Data,
    name: &str,
    primitive: &Primitive,
    positions: &Accessor,
    vertices: &[u32],
) -> Result<Option<Vec<Vec4>>, Fault> {
    let Some(accessor) = attribute(data, name, primitive, "TANGENT", 4, positions)? else { return Ok(None) };
    data.spend(16 * vertices.len() as u64)?;
    let tangent = |&v: &u32| {
        let [x, y, z, w] = accessor.floats(v as usize);
        unit(Vec3::new(x, y, z)).extend(if w < 0.0 { -1.0 } else { 1.0 })
    };
    Ok(Some(vertices.iter().map(tangent).collect()))
}

/// Set n at place n; sets that are left out are zero.
fn uv_sets(
    data: &Data,
    name: &str,
    primitive: &Primitive,
    positions: &Accessor,
    vertices: &[u32],
) -> Result<Vec<Vec<Vec2>>, Fault> {
    let key = |set: usize| format!("TEXCOORD_{set}");
    let count =
        (0..MAX_UV_SETS).rev().find(|&s| primitive.attributes.contains_key(&key(s))).map_or(0, |s| s + 1);
    data.spend((count.saturating_sub(1) as u64).saturating_mul(8 * vertices.len() as u64))?;
    (0..count)
        .map(|set| {
            let Some(accessor) = attribute(data, name, primitive, &key(set), 2, positions)? else {
                return Ok(vec![Vec2::ZERO; vertices.len()]);
            };
            let uv = |&v: &u32| Vec2::from_array(accessor.floats(v as usize));
            let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
            Ok(vertices.iter().map(|v| finite(uv(v))).collect())
        })
        .collect()
}
