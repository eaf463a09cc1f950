//! Bundles: up to 64 rays from one origin, traced together.
//!
//! All rays of a hemisphere start at one point, so what depends on the origin alone is done once: boxes and triangles are
//! moved to the origin once per visit, a triangle becomes three half-spaces through it, boxes beyond the reach of every
//! ray or below the surface are dropped before any ray is looked at. What remains is tested sixteen rays at a time.
//!
//! # The same answers as single rays
//!
//! The wide triangle test (`triangles.rs`) knows the bound of its own rounding errors. Where a ray is inside or outside by
//! more than that, the answer is certain; everything else goes to the exact test of `triangle.rs`. So the answers are those
//! of [`Bvh::transmittance`], bit for bit, at every level of SIMD.

mod boxes;
mod rays;
mod triangles;
mod walk;

use crate::bvh::Bvh;
use conray_core::{Ray, Vec3};
pub use fearless_simd::Level;
use fearless_simd::dispatch;
use rays::Rays;

/// Rays of a bundle at most.
pub const BUNDLE_RAYS: usize = 64;

/// What became of the rays of a bundle; bit i stands for ray i.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Met {
    /// Blocked by an opaque surface.
    pub(crate) blocked: u64,
    /// Met a surface whose opacity must be looked up, or may have met an instance.
    pub(crate) unsettled: u64,
}

impl Bvh {
    /// Share of light in [0, 1] that passes along each of up to [`BUNDLE_RAYS`] rays of length `t_max` from one origin:
    /// what [`Bvh::transmittance`] says of each, many times faster.
    ///
    /// `normal` is that of the surface that the rays leave; they must not lead below it. Zero where there is none.
    /// Directions are unit vectors; neighbours in the list should look about the same way.
    ///
    /// # Panics
    /// If there are more directions than [`BUNDLE_RAYS`] or `out` is not as long.
    pub fn transmittances(
        &self,
        origin: Vec3,
        normal: Vec3,
        directions: &[Vec3],
        t_max: f32,
        out: &mut [f32],
    ) {
        self.transmittances_at(Level::new(), origin, normal, directions, t_max, out);
    }

    /// As [`Bvh::transmittances`], at a level of SIMD of the caller's choice.
    pub fn transmittances_at(
        &self,
        level: Level,
        origin: Vec3,
        normal: Vec3,
        directions: &[Vec3],
        t_max: f32,
        out: &mut [f32],
    ) {
        assert!(directions.len() <= BUNDLE_RAYS && out.len() == directions.len());
        let met = Rays::new(origin, normal, directions, t_max, self.reach())
            .and_then(|rays| dispatch!(level, simd => walk::walk(simd, &self.flat, &rays)));
        let instances = !self.top.placed.is_empty();
        for (index, (visible, &direction)) in out.iter_mut().zip(directions).enumerate() {
            let bit = 1 << index;
            *visible = match met {
                Some(met) if met.blocked & bit != 0 => 0.0,
                Some(met) if met.unsettled & bit == 0 && !instances => 1.0,
                _ => self.transmittance(&Ray { origin, direction, t_max }),
            };
        }
    }

    /// A length that no distance within the scene exceeds by much.
    fn reach(&self) -> f32 {
        self.flat.tree.bounds.diagonal()
    }
}
