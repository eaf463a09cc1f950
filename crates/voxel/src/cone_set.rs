//! All cones of surface points at once: sixteen side by side, eight points together.
//!
//! The distances at which a cone is sampled depend on its aperture and not on what it meets. Cones of one aperture share
//! them, so levels, node sizes and weights are the same for all and computed once for many points; the cones of a point
//! differ in their positions only (`paths.rs`). A part of the march, steps on the same levels, is asked at once where the
//! filter meets anything (`asked.rs`); most places do not. Samples that do are looked up sixteen at a time, whichever points,
//! cones and steps they belong to (`samples.rs`, `nodes.rs`), and what they find composes cone by cone (`passage.rs`).
//! `docs/profiles/cones.md` says where the time goes.
//!
//! The results are those of [`Octree::march_with`], bit for bit, at every level of SIMD.

mod asked;
mod kernel;
mod lanes;
mod nodes;
mod passage;
mod paths;
mod samples;

use crate::{ConeQuery, ConeResult, Density, MarchOptions, Octree, steps::MarchPlan, steps::Steps};
use conray_core::{Falloff, Frame, HemisphereCones, Vec3};
pub use fearless_simd::Level;
use fearless_simd::dispatch;
use kernel::{Group, POINTS, Scratch};
use lanes::{Fan, LANES, LocalAxes};
use std::cell::RefCell;

/// Where a set of cones stands, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConePoint {
    /// Position on the surface.
    pub apex: Vec3,
    /// Unit geometric normal of the surface, on the cones' side.
    pub normal: Vec3,
    /// The hemisphere lies about the third axis of this frame of unit vectors.
    pub frame: Frame,
}

impl ConePoint {
    /// At a surface point with that geometric normal, the hemisphere about a unit vector: as a rule the shading normal.
    #[inline]
    pub fn about(axis: Vec3, apex: Vec3, normal: Vec3) -> Self {
        Self { apex, normal, frame: Frame::from_normal(axis) }
    }
}

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
    plan: MarchPlan,
}

thread_local! {
    /// Some kilobytes that would take longer to clear for each point than a step of the march.
    static SCRATCH: RefCell<Scratch> = const { RefCell::new(Scratch::new()) };
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
            plan: MarchPlan::new(Steps::new(self, half_angle_rad, distance, falloff, options, 0.0)),
        }
    }
}

impl ConeMarch<'_> {
    /// The same at a level of SIMD of the caller's choice; the results do not depend on it.
    #[must_use]
    pub fn at_level(self, simd: Level) -> Self {
        Self { simd, ..self }
    }

    /// Marches the cones of some surface points. `results`, for each point one for each cone, are what [`Octree::march_with`]
    /// says of each. Eight points and more take less time each than one alone.
    ///
    /// # Panics
    /// If there are not as many results as cones of all points.
    pub fn march(&self, points: &[ConePoint], results: &mut [ConeResult]) {
        let expected = points.len() * self.count;
        assert!(expected == results.len(), "{} results for {expected} cones", results.len());
        SCRATCH.with_borrow_mut(|scratch| {
            let groups = points.chunks(POINTS).zip(results.chunks_mut(POINTS * self.count));
            groups.for_each(|(points, results)| self.march_group(points, results, scratch));
        });
    }

    /// Marches the cones of up to [`POINTS`] points.
    fn march_group(&self, points: &[ConePoint], results: &mut [ConeResult], scratch: &mut Scratch) {
        let mut fans = [const { None }; POINTS];
        for (fan, point) in fans.iter_mut().zip(points) {
            *fan = self.fan(point);
        }
        let fans = &fans[..points.len()];
        let mut found = [[ConeResult { visibility: 1.0, error: 0.0 }; LANES]; POINTS];
        for (set, axes) in self.axes.iter().enumerate() {
            let group = Group { octree: self.octree, plan: &self.plan, fans, axes };
            dispatch!(self.simd, simd => group.march(simd, scratch, &mut found));
            for (results, found) in results.chunks_mut(self.count).zip(&found) {
                let results = results.chunks_mut(LANES).nth(set).unwrap_or_default();
                results.copy_from_slice(&found[..results.len()]);
            }
        }
        for ((point, fan), results) in points.iter().zip(fans).zip(results.chunks_mut(self.count)) {
            if fan.is_none() {
                self.march_singly(point, results);
            }
        }
    }

    /// Marches the cones of a point that the kernel is not made for.
    #[cold]
    fn march_singly(&self, point: &ConePoint, results: &mut [ConeResult]) {
        let axes = self.axes.iter().flat_map(|axes| (0..LANES).map(|lane| axes.axis(lane)));
        for (result, axis) in results.iter_mut().zip(axes) {
            let Self { half_angle_rad, distance, falloff, .. } = *self;
            let (apex, normal, axis) = (point.apex, point.normal, point.frame.to_world(axis));
            let query = ConeQuery { apex, axis, half_angle_rad, normal, distance, falloff };
            *result = self.octree.march_with(&query, &self.options);
        }
    }

    /// `None` for what the kernel is not made for: members that are not finite, vectors off unit length, an apex outside
    /// the octree's cube, opacities by axis.
    #[inline]
    fn fan(&self, point: &ConePoint) -> Option<Fan> {
        let is_usable = self.options.density == Density::Mean && !self.distance.is_nan();
        let apex = self.octree.leaf_units(point.apex);
        let side = self.octree.resolution() as f32;
        is_usable.then(|| Fan::new(apex, point.normal, point.frame, side)).flatten()
    }
}
