//! One vertex to one surface point.

use super::{
    PlyError,
    body::{Walk, decode, next_token, parse_number},
    header::{Element, Encoding, Kind},
};
use conray_core::{SurfacePoint, Vec3};
use glam::DVec3;

/// What a point needs, in this order.
const FIELDS: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

/// Which property of the vertices holds which field.
#[derive(Clone, Debug)]
pub(super) struct Fields {
    /// For each property in turn: its field, if it is one.
    of_property: Vec<Option<usize>>,
}

impl Fields {
    /// Fails with the first field that is missing or a list.
    pub(super) fn find(element: &Element) -> Result<Self, PlyError> {
        let scalar = |p: &super::header::Property| matches!(p.kind, Kind::Scalar(_));
        for field in FIELDS {
            if !element.properties.iter().any(|p| p.name == field && scalar(p)) {
                return Err(PlyError::MissingProperty(field));
            }
        }
        let of_property =
            element.properties.iter().map(|p| FIELDS.iter().position(|f| *f == p.name)).collect();
        Ok(Self { of_property })
    }

    /// The point of the record `at` a place, and where the record ends; `None` for a normal of zero length.
    pub(super) fn point(
        &self,
        walk: &Walk,
        at: usize,
        vertex: u64,
    ) -> Result<(Option<SurfacePoint>, usize), PlyError> {
        let (values, end) = match walk.encoding {
            Encoding::Ascii => self.ascii(walk, at, vertex)?,
            _ => self.binary(walk, at, vertex)?,
        };
        Ok((surface_point(values, vertex)?, end))
    }

    fn binary(&self, walk: &Walk, at: usize, vertex: u64) -> Result<([f64; 6], usize), PlyError> {
        let (mut values, mut at) = ([0.0; 6], at);
        for (property, field) in walk.element.properties.iter().zip(&self.of_property) {
            let end = walk.value_end(at, property.kind, vertex)?;
            if let (Some(field), Kind::Scalar(scalar)) = (*field, property.kind) {
                values[field] = decode(&walk.bytes[at..end], scalar, walk.encoding);
            }
            at = end;
        }
        Ok((values, at))
    }

    fn ascii(&self, walk: &Walk, at: usize, vertex: u64) -> Result<([f64; 6], usize), PlyError> {
        let line = walk.record(at, vertex)?;
        let (mut values, mut rest) = ([0.0; 6], &walk.bytes[line.clone()]);
        for (property, field) in walk.element.properties.iter().zip(&self.of_property) {
            if let (Some(field), Some((token, _))) = (*field, next_token(rest)) {
                values[field] = parse_number(token).ok_or_else(|| {
                    let text = String::from_utf8_lossy(&token[..token.len().min(40)]);
                    walk.bad(vertex, format!("{} is {text:?}, which is no number", property.name))
                })?;
            }
            rest = walk.skip_tokens(rest, property.kind, vertex)?;
        }
        Ok((values, line.end))
    }
}

/// The point of x, y, z, nx, ny, nz; its id is the vertex.
fn surface_point(values: [f64; 6], vertex: u64) -> Result<Option<SurfacePoint>, PlyError> {
    for (name, value) in FIELDS.iter().zip(values) {
        // Also what single precision cannot hold.
        if !(value as f32).is_finite() {
            return Err(PlyError::Vertex { vertex, problem: format!("{name} is {value}") });
        }
    }
    let [x, y, z, nx, ny, nz] = values;
    let normal = DVec3::new(nx, ny, nz);
    // Scaled first: tiny normals of double precision would underflow when squared.
    let largest = normal.abs().max_element();
    if largest == 0.0 {
        return Ok(None);
    }
    let position = Vec3::new(x as f32, y as f32, z as f32);
    let normal = (normal / largest).normalize().as_vec3();
    // The id fits: there are at most MAX_POINTS vertices.
    Ok(Some(SurfacePoint::new(position, normal).with_id(vertex as u32)))
}
