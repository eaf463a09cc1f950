//! PLY: points in, the same file with their visibility out.
//!
//! The file's bytes are kept as they are and only the vertices are read and rewritten, so that colours, faces, lists,
//! comments and elements of other programs survive, and ten million points need little more memory than their bytes.
//!
//! Format: Turk, "The PLY Polygon File Format", 1994; both its type names and those of later files (`float32`, ...).

mod body;
mod error;
mod header;
mod points;
mod vertex;
mod write;

pub use error::PlyError;
pub use points::{MAX_POINTS, PointValues, PointsTarget, Skipped};

#[cfg(test)]
mod tests;
