//! All cones of a surface point at once: sixteen side by side.
//!
//! The distances at which a cone is sampled depend on its aperture and not on what it meets. Cones of one aperture share
//! them, so levels, node sizes and weights are the same for all and computed once for many points; the cones of a point
//! differ in their positions only. Each step asks for sixteen positions at once whether the filter meets anything
//! (`kernel.rs`); most do not. The nodes of those that do are read one cone after the other (`places.rs`), and what they find
//! composes side by side again (`passage.rs`). `docs/profiles/cones.md` says where the time goes.
//!
//! The results are those of [`Octree::march_with`], bit for bit, at every level of SIMD.

mod kernel;
mod lanes;
mod passage;
mod places;
mod slopes;

use crate::{ConeQuery, ConeResult, Density, MarchOptions, Octree, steps::Step, steps::Steps};
use conray_core::{Falloff, Frame, HemisphereCones, Vec3};
pub use fearless_simd::Level;
use fearless_simd::dispatch;
use lanes::{Fan, LANES, LocalAxes};

/// A set of cones, prepared for any number of points.
#[derive(Clone, Debug)]
pub struct ConeMarch<'a> {
    octree: &'a Octree,
    half_angle_rad: f32,
    distance: f32,
    falloff: Falloff,
    options: MarchOptions,
    simd: Level,
    axes: Vec<LocalAxes>,
    count: usize,
    steps: Vec<Step>,
}

impl Octree {
    /// Prepares to march the cones of a hemisphere, each with the aperture that stands for all of them
    /// ([`HemisphereCones::half_angle_rad`]); AO distance in world units and falloff are as in [`ConeQuery`].
    pub fn cone_march(
        &self,
        cones: &HemisphereCones,
        distance: f32,
        falloff: Falloff,
        options: &MarchOptions,
    ) -> ConeMarch<'_> {
        let half_angle_rad = cones.half_angle_rad();
        ConeMarch {
            octree: self,
            half_angle_rad,
            distance,
            falloff,
            options: *options,
            simd: Level::new(),
            axes: cones.cones().chunks(LANES).map(LocalAxes::new).collect(),
            count: cones.cones().len(),
            steps: Steps::new(self, half_angle_rad, distance, falloff, options, 0.0).collect(),
        }
    }
}

impl ConeMarch<'_> {
    /// The same at a level of SIMD of the caller's choice; the results do not depend on it.
    #[must_use]
    pub fn at_level(self, simd: Level) -> Self {
        Self { simd, ..self }
    }

    /// Marches the cones of one surface point: `apex` and unit `normal` as in [`ConeQuery`], and the frame about whose
    /// third axis the hemisphere lies. `results`, one for each cone, are what [`Octree::march_with`] says of each.
    ///
    /// # Panics
    /// If there are not as many results as cones.
    pub fn march(&self, apex: Vec3, normal: Vec3, frame: &Frame, results: &mut [ConeResult]) {
        assert!(self.count == results.len(), "{} results for {} cones", results.len(), self.count);
        let fan = self.fan(apex, normal, frame);
        for (axes, results) in self.axes.iter().zip(results.chunks_mut(LANES)) {
            if let Some(fan) = &fan {
                let found =
                    dispatch!(self.simd, simd => kernel::march(simd, self.octree, &self.steps, fan, axes));
                results.copy_from_slice(&found[..results.len()]);
            } else {
                for (lane, result) in results.iter_mut().enumerate() {
                    let query = self.query(apex, normal, frame.to_world(axes.axis(lane)));
                    *result = self.octree.march_with(&query, &self.options);
                }
            }
        }
    }

    /// `None` for what the kernel is not made for: members that are not finite, vectors off unit length, an apex outside
    /// the octree's cube, opacities by axis.
    #[inline]
    fn fan(&self, apex: Vec3, normal: Vec3, frame: &Frame) -> Option<Fan> {
        let is_usable = self.options.density == Density::Mean && !self.distance.is_nan();
        let apex = self.octree.leaf_units(apex);
        is_usable.then(|| Fan::new(apex, normal, *frame, self.octree.resolution() as f32)).flatten()
    }

    fn query(&self, apex: Vec3, normal: Vec3, axis: Vec3) -> ConeQuery {
        let Self { half_angle_rad, distance, falloff, .. } = *self;
        ConeQuery { apex, axis, half_angle_rad, normal, distance, falloff }
    }
}
