//! What the rays of each pixel found, and how far that can be trusted.

use conray_core::Vec3;
use rayon::prelude::*;

/// The unit in which points get rays: a bundle, an aligned block of their sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bundle {
    /// Rays of one.
    pub(super) rays: u32,
    /// Cells of the square on each side, within which its rays count as independent: so many that four rays lie in each.
    pub(super) side: u32,
}

impl Bundle {
    /// Where there are few rays: more points get some.
    pub(super) const SMALL: Self = Self { rays: 16, side: 2 };
    /// As many as are traced together.
    pub(super) const FULL: Self = Self { rays: conray_bvh::BUNDLE_RAYS as u32, side: 4 };

    /// For a budget of so many rays a point. Full ones cost less for each ray.
    pub(super) fn of(rays_per_point: f64) -> Self {
        if rays_per_point < MANY { Self::SMALL } else { Self::FULL }
    }
}

/// From so many rays a point on, full bundles leave less error in the same time.
pub(super) const MANY: f64 = 32.0;

/// Sums over the bundles of one point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tally {
    /// Bundles traced.
    pub(super) bundles: u32,
    /// Sum over bundles of the mean visibility.
    pub(super) sum: f32,
    /// Sum over bundles of the variance of a bundle's mean, as if its rays were independent within each cell of the square.
    pub(super) variance: f32,
    /// Sum over bundles of the mean open direction.
    pub(super) bent: Vec3,
}

impl Tally {
    /// Mean visibility; 0 without rays.
    pub(super) fn mean(&self) -> f32 {
        self.sum / self.bundles.max(1) as f32
    }

    /// Mean over the bundles of their variance within cells; 0 without rays.
    pub(super) fn cells_variance(&self) -> f32 {
        self.variance / self.bundles.max(1) as f32
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.bundles += other.bundles;
        self.sum += other.sum;
        self.variance += other.variance;
        self.bent += other.bent;
    }
}

/// How rays err in a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rays {
    pub(super) unit: Bundle,
    /// Variance of a bundle over what rays that are independent in each cell would have.
    pub(super) stratified: f32,
}

impl Rays {
    /// Variance of the mean of so many bundles, from the variance within cells of one.
    ///
    /// It falls as `bundles^-3/2`: visibility jumps along curves in the square of directions, and there stratified points err
    /// so (Mitchell, "Consequences of Stratified Sampling in Graphics", 1996).
    pub(super) fn variance(&self, cells_variance: f32, bundles: u32) -> f32 {
        let bundles = bundles as f32;
        self.bundle(cells_variance) / (bundles * bundles.sqrt())
    }

    /// That of one bundle. Where all rays agree, one in a hundred bundles may still hold one ray that does not.
    pub(super) fn bundle(&self, cells_variance: f32) -> f32 {
        let unseen = 0.01 / (self.unit.rays * self.unit.rays) as f32;
        self.stratified * cells_variance + unseen
    }
}

/// Mean variance of a bundle over all pixels that have rays.
pub(super) fn mean_bundle(tallies: &[Tally], rays: &Rays) -> f32 {
    // Part by part, so that the order of the sum does not depend on threads.
    let part = |tallies: &[Tally]| {
        let with_rays = tallies.iter().filter(|t| t.bundles > 0);
        with_rays.fold((0.0, 0u32), |(sum, count), t| (sum + f64::from(t.cells_variance()), count + 1))
    };
    let parts: Vec<(f64, u32)> = tallies.par_chunks(1 << 14).map(part).collect();
    let (sum, count) = parts.into_iter().fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    rays.bundle((sum / f64::from(count.max(1))) as f32)
}
