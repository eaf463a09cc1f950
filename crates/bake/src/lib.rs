//! Ambient occlusion baked into models.
//!
//! ```text
//! Scene -> sheets.rs: which maps, read by which surfaces -> places.rs: where to ask
//!    -> run.rs: portion by portion an AtlasTarget -> Session -> AtlasMap, filled, level at seams, extended -----------------+
//!                                                                                                            |
//! model file -> document/: glTF kept as it is written <- assign.rs: a map becomes an occlusion texture <------+
//! ```
//!
//! vertex/: values at vertices instead, fitted to points all over the surface; glTF, PLY and OBJ that show them.
//!
//! facing.rs: which way points look, also by normal maps (normal_maps.rs) in tangent frames (frames.rs); bent.rs: directions told in these.
//!
//! inside.rs tells which points lie inside other geometry; buried.rs fills their texels from their neighbours.
//!
//! [`Sheets`] finds the maps of a model, [`Places`] where to ask and where the model is cut, [`write_model`] writes the result. [`Slots`] finds which
//! corners share a value, [`VertexTarget`] where to ask and what the values are, [`write_vertex_model`], [`write_ply`] and [`write_obj`] write them.
//! [`Document`] is a glTF file that is changed in a few places and stays as it was in all others.

mod answers;
mod assign;
mod bent;
mod buried;
mod document;
mod extent;
mod facing;
mod frames;
mod inside;
mod mapped_obj;
mod memory;
mod normal_maps;
mod packed;
mod places;
mod run;
mod scope;
mod shares;
mod sheets;
mod unwrap;
mod vertex;
mod write;

pub use answers::Apart;
pub use assign::{AssignError, Origins, assign};
pub use bent::BentSpace;
pub use buried::Buried;
pub use document::{Buffers, Document, DocumentError, Files, Kind};
pub use extent::{MAX_MAP_SIDE, MapExtent};
pub use facing::{Facing, Normals};
pub use inside::inside;
pub use mapped_obj::{write_mapped_obj, write_mtl};
pub use memory::Memory;
pub use normal_maps::NormalMaps;
pub use places::Places;
pub use run::{Baked, MapOptions, PORTION, bake_maps};
pub use scope::{Chosen, Ground, Scope, ScopeError};
pub use sheets::{Sheet, Sheets, Unmapped, Unwrap, UvFault, Uvs};
pub use unwrap::NewUvs;
pub use vertex::{
    SlotSurface, Slots, VertexAttribute, VertexBake, VertexSettings, VertexTarget, VertexValues,
    assign_vertices, bake_vertices, objects, write_obj, write_ply, write_vertex_model,
};
pub use write::{BentColours, Look, PngOptions, WriteError, Written, bent_png, file_names, png, write_model};
