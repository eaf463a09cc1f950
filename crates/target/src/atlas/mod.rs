//! Texture maps: every texel that a bilinear tap can read is asked about where its triangle is, not where its centre is.
//!
//! ```text
//! Surface: triangles with their UVs -> coverage.rs: the texels each touches, and where
//!    -> owners.rs: one triangle for each texel -> texels.rs: its surface points
//!                                                     |  estimates
//!    map.rs: values of texels <- resolve <------------+
//!    grow.rs: islands extended until they meet
//! ```

mod coverage;
mod grow;
mod map;
mod owners;
mod texels;

pub use map::AtlasMap;
pub use owners::UvUse;
pub use texels::{AtlasTarget, MapSize, Surface};
