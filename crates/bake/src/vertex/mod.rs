//! Vertex bakes: values at vertices such that what a renderer draws between them is as near to the visibility of the surface as can be.
//!
//! A value that is sampled at a vertex says nothing of the triangles about it: a vertex inside a wall darkens a lit floor. Here points all over the
//! surface are asked about, and the values are fitted to them (Kavan, Bargteil, Sloan, "Least Squares Vertex Baking", 2011).
//!
//! ```text
//! instances -> slots.rs: which corners share a value -> samples.rs: points all over their triangles -> Session
//!                                                                                                        |  estimates
//! write.rs: glTF, plain.rs: PLY and OBJ <- fit.rs: the values, by solve.rs, smooth by kinks.rs <---------+
//! ```

mod fit;
mod kinks;
mod plain;
mod run;
mod samples;
mod slots;
mod solve;
mod values;
mod write;

pub(crate) use plain::title;
pub use plain::{write_obj, write_ply};
pub use run::{VertexBake, bake_vertices};
pub use samples::{VertexSettings, VertexTarget};
pub use slots::{SlotSurface, Slots, objects};
pub use values::VertexValues;
pub use write::{VertexAttribute, assign_vertices, write_vertex_model};
