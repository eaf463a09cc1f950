//! Ambient occlusion baked into models.
//!
//! ```text
//! Scene -> sheets.rs: which maps, read by which surfaces -> texels.rs: an AtlasTarget -> Session -> AtlasMap
//!                                                                                                     |
//! model file -> document/: glTF kept as it is written <--------------- a map becomes an occlusion texture
//! ```
//!
//! [`Sheets`] finds the maps of a model, [`texels`] the places to ask about; [`Document`] is a glTF file that is changed in a few places and
//! stays as it was in all others.

mod document;
mod sheets;
mod texels;

pub use document::{Document, DocumentError, Files, Kind};
pub use sheets::{Sheet, Sheets, Unmapped, UvFault};
pub use texels::texels;
