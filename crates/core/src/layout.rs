//! How the points of a target lie to each other.

/// What the ids of points say about their neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Nothing.
    #[default]
    Scattered,
    /// Points are pixels: `id` is `first + y * width + x`, rows from the top, no id twice.
    Image {
        /// Id of the upper left pixel.
        first: u32,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
}
