//! Ambient occlusion baked into models.
//!
//! ```text
//! Scene -> sheets.rs: which maps, read by which surfaces -> places.rs: an AtlasTarget -> Session -> AtlasMap
//!                                                                                                     |
//! model file -> document/: glTF kept as it is written <- assign.rs: a map becomes an occlusion texture <------+
//! ```
//!
//! vertex/: values at vertices instead, fitted to points all over the surface; glTF, PLY and OBJ that show them.
//!
//! buried.rs tells which texels lie inside other geometry: they are filled from their neighbours.
//!
//! [`Sheets`] finds the maps of a model, [`Places`] where to ask and where the model is cut, [`write_model`] writes the result. [`Slots`] finds which
//! corners share a value, [`VertexTarget`] where to ask and what the values are, [`write_vertex_model`], [`write_ply`] and [`write_obj`] write them.
//! [`Document`] is a glTF file that is changed in a few places and stays as it was in all others.

mod assign;
mod buried;
mod document;
mod places;
mod sheets;
mod unwrap;
mod vertex;
mod write;

pub use assign::{AssignError, Origins, assign};
pub use buried::buried;
pub use document::{Buffers, Document, DocumentError, Files, Kind};
pub use places::Places;
pub use sheets::{Sheet, Sheets, Unmapped, Unwrap, UvFault, Uvs};
pub use unwrap::NewUvs;
pub use vertex::{
    SlotSurface, Slots, VertexAttribute, VertexSettings, VertexTarget, VertexValues, assign_vertices,
    objects, write_obj, write_ply, write_vertex_model,
};
pub use write::{WriteError, Written, file_names, png, write_model};
