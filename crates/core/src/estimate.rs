//! What a method answers for one surface point.

use crate::Vec3;

/// The answer of a method at one surface point.
///
/// `rays == 0` together with a NaN visibility means "not estimated yet" ([`Estimate::PENDING`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Cosine-weighted share of the hemisphere that is open within the AO distance, in [0, 1]; 1 is open.
    pub visibility: f32,
    /// Expected absolute error of `visibility` (one standard deviation where the method is unbiased), >= 0.
    pub error: f32,
    /// Rays traced for this point.
    pub rays: u32,
    /// Mean open direction in world space, of length at most 1; zero where nothing is open.
    pub bent: Vec3,
    /// What the cones said, for methods that march cones.
    pub cone: Option<ConeEstimate>,
}

/// The part of an estimate that came from cones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeEstimate {
    /// Weighted visibility of the cones alone, in [0, 1].
    pub visibility: f32,
    /// Weighted cone error (epsilon), >= 0.
    pub error: f32,
    /// Weighted share of the cones' result in the blend, in [0, 1]; 1 means that no ray was asked for.
    pub alpha: f32,
}

impl Estimate {
    /// A point that no method has reached yet.
    pub const PENDING: Self =
        Self { visibility: f32::NAN, error: f32::INFINITY, rays: 0, bent: Vec3::ZERO, cone: None };

    /// The answer where there is no surface to ask about.
    pub const INVALID: Self = Self { visibility: 0.0, ..Self::PENDING };

    /// True until a method has answered.
    pub fn is_pending(&self) -> bool {
        self.visibility.is_nan()
    }
}
