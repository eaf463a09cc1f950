//! Texture maps: every texel that a bilinear tap can read is asked about where its triangle is, not where its centre is.
//!
//! ```text
//! Atlas: maps, and triangles with their UVs -> portion.rs: rows that are asked about together
//!    -> coverage.rs: the texels each triangle touches, and where -> owners.rs: one triangle for each texel
//!    -> texels.rs: a portion's surface points, in an image
//!                                       |  estimates
//!    map.rs: values of texels <- resolve +
//!    grow.rs: islands extended until they meet; across.rs: texels without a value filled, also over seams
//!    seams.rs: the two sides of cuts in a smooth surface, compared; level.rs: and made to agree
//! ```

mod across;
mod coverage;
mod grow;
mod level;
mod map;
mod owners;
mod portion;
mod seams;
mod texels;

pub use across::fill;
pub use level::level;
pub use map::{AtlasMap, Texel};
pub use owners::UvUse;
pub use portion::{Part, Portion};
pub use seams::{Corner, Seam, SeamReport, SeamSide, seams};
pub use texels::{Atlas, AtlasTarget, MapSize, Surface};
