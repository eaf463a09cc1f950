//! What the method takes for granted about surfaces and rays.

/// The constants of method `hybrid` that a search can judge: how alike neighbours are taken to be, and how far guesses are trusted.
///
/// Those of [`HybridConstants::default`] were searched on the built-in scenes (`cargo run --release -p conray-bench --bin tune_hybrid`). Work
/// that is kept in a file does not tell them: who sets others sets them again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HybridConstants {
    /// Distance, in units of length, at which likeness has fallen to 1/e, as long as that reaches the neighbours;
    pub distance: f32,
    /// else so many sizes of the cell.
    pub cells: f32,
    /// The same for the distance from the tangent planes, in sizes of the cell.
    pub plane: f32,
    /// The same for one less the cosine between the normals.
    pub cosine: f32,
    /// Slope of visibility that is expected, per unit of length.
    pub slope: f32,
    /// Squared difference of visibility that is expected where planes and normals alone make likeness fall to 1/e, over 8.
    pub bend: f32,
    /// What a wider neighbourhood tells of errors counts for so many samples of a narrower one.
    pub prior_samples: f32,
    /// So many standard deviations are no chance: what few rays meet rarely scatters far more than what they meet often.
    pub beyond_chance: f32,
    /// The least that a guess can err, over the noise of its neighbours' rays: they are a little better together than apart.
    pub least_noise: f32,
    /// From so many units of rays on a guess counts for half as much as its expected squared error says: guesses of many pixels
    /// err to the same side, rays do not, so the mean of all pixels soon is right too.
    pub doubt_units: f32,
    /// A point's first rays count for so much more: they also help its neighbours, and find out where guesses are wrong.
    pub first_rays: f32,
    /// Share of the mean number of rays that every point must have.
    pub least_share: f32,
}

impl Default for HybridConstants {
    fn default() -> Self {
        Self {
            distance: 0.1,
            cells: 1.5,
            plane: 0.5,
            // 14 degrees.
            cosine: 0.03,
            slope: 1.4,
            bend: 0.01,
            prior_samples: 2.0,
            beyond_chance: 8.0,
            least_noise: 0.7,
            doubt_units: 96.0,
            first_rays: 4.0,
            least_share: 0.5,
        }
    }
}
