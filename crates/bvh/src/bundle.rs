//! Bundles: up to 64 rays from one origin, traced together.
//!
//! All rays of a hemisphere start at one point, so what depends on the origin alone is done once: boxes and triangles are
//! moved to the origin once per visit, a triangle becomes three half-spaces through it, boxes beyond the reach of every
//! ray or below the surface are dropped before any ray is looked at. What remains is tested sixteen at a time, either
//! sixteen boxes (or triangles) against one ray or sixteen rays against one box, whichever is less work.
//!
//! ```text
//! Directions -> Rays (what all share) -> walk: boxes.rs -> leaf.rs: triangles.rs, exact test -> Met
//!                                          top level -> placed.rs: boxes in the mesh's space, triangles in the world
//! ```
//!
//! # The same answers as single rays
//!
//! The wide triangle test (`triangles.rs`) knows the bound of its own rounding errors. Where a ray is inside or outside by
//! more than that, the answer is certain; everything else goes to the exact test of `triangle.rs`. So the answers are those
//! of [`Bvh::transmittance`], bit for bit, at every level of SIMD.

mod boxes;
mod directions;
mod leaf;
mod placed;
mod rays;
mod triangles;
mod walk;

use crate::bvh::Bvh;
use crate::visits::{Visit, count};
use conray_core::{Ray, Vec3};
pub use directions::Directions;
pub use fearless_simd::Level;
use fearless_simd::{Simd, dispatch};
use leaf::Triangles;
use placed::Placements;
use rays::Rays;
use walk::walk;

/// Rays of a bundle at most.
pub const BUNDLE_RAYS: usize = 64;

/// What became of the rays of a bundle; bit i stands for ray i.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Met {
    /// Blocked by an opaque surface, or led below the surface.
    blocked: u64,
    /// Met a surface of fractional opacity.
    unsettled: u64,
}

impl Bvh {
    /// Share of light in [0, 1] that passes along each of up to [`BUNDLE_RAYS`] rays of length `t_max` from one origin:
    /// what [`Bvh::transmittance`] says of each, many times faster.
    ///
    /// `normal` is that of the surface that the rays leave; rays that do not lead above it (`direction . normal <= 0`) meet
    /// that surface and give 0. Zero where there is none. Directions are unit vectors.
    ///
    /// # Panics
    /// If `out` is not as long as there are directions.
    pub fn transmittances(
        &self,
        origin: Vec3,
        normal: Vec3,
        directions: &Directions,
        t_max: f32,
        out: &mut [f32],
    ) {
        assert_eq!(out.len(), directions.len());
        let Some(met) = self.met(origin, normal, directions, t_max) else {
            return self.one_by_one(origin, normal, directions, t_max, out);
        };
        for (index, visible) in out.iter_mut().enumerate() {
            *visible = if met.blocked >> index & 1 == 1 { 0.0 } else { 1.0 };
        }
        let mut unsettled = met.unsettled & !met.blocked;
        while unsettled != 0 {
            let index = unsettled.trailing_zeros() as usize;
            unsettled &= unsettled - 1;
            out[index] = self.transmittance(&Ray { origin, direction: directions.get(index), t_max });
        }
    }

    /// `None` where the rays are not of the kind that bundles are for.
    fn met(&self, origin: Vec3, normal: Vec3, directions: &Directions, t_max: f32) -> Option<Met> {
        dispatch!(self.level, simd => met_with(simd, self, origin, normal, directions, t_max))
    }

    /// The rays that bundles are not for.
    #[cold]
    fn one_by_one(&self, origin: Vec3, normal: Vec3, directions: &Directions, t_max: f32, out: &mut [f32]) {
        for (index, visible) in out.iter_mut().enumerate() {
            let direction = directions.get(index);
            let leads_below = normal != Vec3::ZERO && direction.dot(normal) <= 0.0;
            *visible = if leads_below { 0.0 } else { self.transmittance(&Ray { origin, direction, t_max }) };
        }
    }
}

#[inline(always)]
fn met_with<S: Simd>(
    simd: S,
    bvh: &Bvh,
    origin: Vec3,
    normal: Vec3,
    directions: &Directions,
    t_max: f32,
) -> Option<Met> {
    let rays = Rays::new(simd, origin, normal, directions, t_max, bvh.reach)?;
    count(Visit::Bundle, 1);
    let mut met = Met { blocked: rays.below, unsettled: 0 };
    let mut triangles = Triangles {
        geometry: &bvh.geometry,
        tree: &bvh.flat,
        placed: None,
        rays: &rays,
        all: rays.all,
        met: &mut met,
    };
    walk(simd, &bvh.flat.tree, &rays.boxes, &mut triangles)?;
    if !bvh.top.placed.is_empty() {
        walk(simd, &bvh.top.tree, &rays.boxes, &mut Placements { bvh, rays: &rays, met: &mut met })?;
    }
    Some(met)
}
