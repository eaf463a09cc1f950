//! Why a PLY file cannot be used.

use thiserror::Error;

/// Why a PLY file holds no usable points. Vertices and records are numbered from 0, lines from 1.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlyError {
    /// It does not begin as PLY files do.
    #[error("it is not a PLY file: the first line is not \"ply\"")]
    NotPly,
    /// A line of the header that cannot be understood.
    #[error("line {line} of the header: {problem}")]
    Header {
        /// Which line.
        line: usize,
        /// Why.
        problem: String,
    },
    /// The header does not end.
    #[error("the header has no end_header line")]
    HeaderEnd,
    /// No vertex element, or an empty one.
    #[error("there are no vertices")]
    NoVertices,
    /// A coordinate or a normal is missing.
    #[error("the vertices have no property \"{0}\": points need x, y, z and normals nx, ny, nz")]
    MissingProperty(&'static str),
    /// The file ends too early, or a count is wrong.
    #[error("the file ends before {element} {index} of {count} is complete")]
    Truncated {
        /// Name of the element.
        element: String,
        /// Which record.
        index: u64,
        /// How many are declared.
        count: u64,
    },
    /// A record that does not fit its declaration.
    #[error("{element} {index}: {problem}")]
    Record {
        /// Name of the element.
        element: String,
        /// Which record.
        index: u64,
        /// Why.
        problem: String,
    },
    /// A vertex that is no point.
    #[error("vertex {vertex}: {problem}")]
    Vertex {
        /// Which vertex.
        vertex: u64,
        /// Why.
        problem: String,
    },
    /// Every normal has zero length.
    #[error("all {0} normals have zero length")]
    NoNormals(u64),
    /// More vertices than the limit.
    #[error("{count} vertices are more than the limit of {limit}")]
    TooMany {
        /// How many are declared.
        count: u64,
        /// The limit.
        limit: u64,
    },
}
