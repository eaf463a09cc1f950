//! Texture maps: every texel that a bilinear tap can read is asked about where its triangle is, not where its centre is.
//!
//! ```text
//! Surface: triangles with their UVs -> coverage.rs: the texels each touches, and where
//!    -> owners.rs: one triangle for each texel -> texels.rs: its surface points
//!                                                     |  estimates
//!    map.rs: values of texels <- resolve <------------+
//!    grow.rs: islands extended until they meet
//!    seams.rs: the two sides of cuts in a smooth surface, compared; level.rs: and made to agree
//! ```

mod coverage;
mod grow;
mod level;
mod map;
mod owners;
mod seams;
mod texels;

pub use level::level;
pub use map::AtlasMap;
pub use owners::UvUse;
pub use seams::{Corner, Seam, SeamReport, SeamSide, seams};
pub use texels::{AtlasTarget, MapSize, Surface};
