//! The vertices of a PLY file as a target.

use super::{
    PlyError,
    body::{BLOCK, VertexRange, Walk, find_vertices},
    header::{Element, Header},
    vertex::Fields,
};
use crate::{Target, TargetError, input, target::check_count};
use conray_core::{Estimate, SurfacePoint};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Most vertices of a file.
pub const MAX_POINTS: u64 = 1 << 28;

/// The vertices of a PLY file, each with position and normal.
///
/// Vertices need the properties `x`, `y`, `z`, `nx`, `ny`, `nz`; normals may have any length but zero. ASCII and both
/// binary encodings are read, an ASCII record to a line. The `id` of each point is its vertex's index; its footprint is
/// unknown (0).
///
/// A coordinate or normal that is NaN, infinite or beyond single precision is an error, for it says that the file is
/// broken. A **normal of zero length is not**: programs write it for vertices that no face uses. Such a vertex is
/// skipped and counted ([`PointsTarget::skipped`]), and its visibility is written as NaN. If all are such, that is an error.
#[derive(Clone, Debug)]
pub struct PointsTarget {
    pub(super) bytes: Vec<u8>,
    pub(super) header: Header,
    /// Index of the vertices among the elements.
    pub(super) vertex: usize,
    pub(super) vertices: VertexRange,
    points: Vec<SurfacePoint>,
    skipped: Option<Skipped>,
}

/// Vertices that could not be asked about, for a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// How many vertices have a normal of zero length.
    pub count: u64,
    /// The first of them.
    pub first: u64,
}

/// Estimates spread over all vertices of the file; pending where a vertex was skipped.
#[derive(Clone, Debug, PartialEq)]
pub struct PointValues {
    /// Visibility, 1 = open; NaN where there is no estimate.
    pub visibility: Vec<f32>,
    /// Expected error of the visibility; infinite where there is no estimate.
    pub error: Vec<f32>,
    /// Rays traced.
    pub rays: Vec<f32>,
}

impl PointsTarget {
    /// Reads a file. Errors name the file, the vertex or line, and the reason.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, TargetError> {
        let path = path.as_ref();
        Self::from_bytes(input::read_file(path)?)
            .map_err(|problem| TargetError::Points { path: PathBuf::from(path), problem })
    }

    /// Reads the bytes of a file. Counts are checked against their number before memory is taken.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, PlyError> {
        let header = Header::parse(&bytes)?;
        let vertex = (header.elements.iter().position(|e| e.name == "vertex"))
            .filter(|&i| header.elements[i].count > 0)
            .ok_or(PlyError::NoVertices)?;
        let element = &header.elements[vertex];
        let (count, limit) = (element.count, MAX_POINTS);
        if count > limit {
            return Err(PlyError::TooMany { count, limit });
        }
        let fields = Fields::find(element)?;
        let vertices = find_vertices(&bytes, &header, vertex)?;
        let walk = Walk { bytes: &bytes, encoding: header.encoding, element };
        let (points, skipped) = read_points(&walk, &fields, &vertices)?;
        Ok(Self { bytes, header, vertex, vertices, points, skipped })
    }

    /// Number of vertices in the file, skipped ones included.
    pub fn vertex_count(&self) -> u64 {
        self.element().count
    }

    /// The vertices that were skipped because their normals have zero length, if any.
    pub fn skipped(&self) -> Option<Skipped> {
        self.skipped
    }

    pub(super) fn element(&self) -> &Element {
        &self.header.elements[self.vertex]
    }
}

impl Target for PointsTarget {
    type Output = PointValues;

    fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    fn resolve(&self, estimates: &[Estimate]) -> Result<PointValues, TargetError> {
        check_count(&self.points, estimates)?;
        let count = self.vertex_count() as usize;
        let Estimate { visibility, error, rays, .. } = Estimate::PENDING;
        let mut values = PointValues {
            visibility: vec![visibility; count],
            error: vec![error; count],
            rays: vec![rays as f32; count],
        };
        for (point, estimate) in self.points.iter().zip(estimates) {
            let i = point.id as usize;
            values.visibility[i] = estimate.visibility;
            values.error[i] = estimate.error;
            values.rays[i] = estimate.rays as f32;
        }
        Ok(values)
    }
}

/// All points, block by block in parallel; the error is that of the first vertex at fault, whatever the thread count.
fn read_points(
    walk: &Walk,
    fields: &Fields,
    vertices: &VertexRange,
) -> Result<(Vec<SurfacePoint>, Option<Skipped>), PlyError> {
    let count = walk.element.count;
    let read_block = |(block, &start): (usize, &usize)| {
        let first = block as u64 * BLOCK;
        let (mut points, mut at) = (Vec::with_capacity(BLOCK as usize), start);
        for vertex in first..(first + BLOCK).min(count) {
            let (point, end) = fields.point(walk, at, vertex)?;
            points.extend(point);
            at = end;
        }
        Ok(points)
    };
    let blocks: Vec<Result<Vec<SurfacePoint>, PlyError>> =
        vertices.blocks.par_iter().enumerate().map(read_block).collect();
    let mut points = Vec::with_capacity(count as usize);
    for block in blocks {
        points.extend(block?);
    }
    if points.is_empty() {
        return Err(PlyError::NoNormals(count));
    }
    let missing = count - points.len() as u64;
    // Ids rise by one until the first gap.
    let first = points.partition_point(|p: &SurfacePoint| {
        let i = p.id as usize;
        points.get(i).is_some_and(|q| q.id == p.id)
    });
    let skipped = (missing > 0).then_some(Skipped { count: missing, first: first as u64 });
    Ok((points, skipped))
}
