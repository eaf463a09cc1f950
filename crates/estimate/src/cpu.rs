//! The backend that runs on the processor's cores.

use crate::{
    AoPlan, Backend, BackendError, Control, Method,
    methods::{self, Marches},
};
use conray_bvh::{Bvh, Level};
use conray_core::{Estimate, SurfacePoint};
use conray_voxel::{ConeResult, Octree};
use rayon::prelude::*;
use std::{ops::Range, sync::Arc};

/// Points handed to a thread at a time: enough to make handing over cheap, few enough to stop soon.
const CHUNK: usize = 64;

/// Carries out plans on the threads of rayon's current pool.
#[derive(Clone)]
pub struct CpuBackend {
    bvh: Arc<Bvh>,
    octree: Option<Arc<Octree>>,
}

impl CpuBackend {
    /// A backend over these structures; method `rays` needs no octree.
    pub fn new(bvh: Arc<Bvh>, octree: Option<Arc<Octree>>) -> Self {
        Self { bvh, octree }
    }

    /// The same at a level of SIMD of the caller's choice; it is the hierarchy's, at first the processor's best. Estimates are
    /// the same bits at every level.
    #[must_use]
    pub fn at_level(self, level: Level) -> Self {
        Self { bvh: Arc::new(Arc::unwrap_or_clone(self.bvh).at_level(level)), ..self }
    }
}

impl Backend for CpuBackend {
    fn estimate(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        estimates: &mut [Estimate],
        control: Control<'_>,
    ) -> Result<(), BackendError> {
        BackendError::check_lengths(points, estimates)?;
        let marches = || {
            let octree = self.octree.as_deref().ok_or(BackendError::NoOctree(plan.method))?;
            Ok(methods::Marches::new(plan, octree, self.bvh.level()))
        };
        match plan.method {
            // One by one, points have no neighbours to share with: see `Hybrid`.
            Method::Rays | Method::Hybrid => {
                let rays = methods::Rays { plan, bvh: &self.bvh, samples };
                each_chunk(points, estimates, control, |points, estimates| {
                    for (point, out) in points.iter().zip(estimates) {
                        *out = if point.is_valid() { rays.estimate(point) } else { Estimate::INVALID };
                    }
                });
            }
            Method::Cones => {
                let cones = methods::Cones { marches: marches()? };
                each_marched(&cones.marches, points, estimates, control, |point, results| {
                    cones.estimate(point, results)
                });
            }
            Method::Paper => {
                let paper = methods::Paper { plan, bvh: &self.bvh, marches: marches()?, frames: samples };
                each_marched(&paper.marches, points, estimates, control, |point, results| {
                    paper.estimate(point, results)
                });
            }
        }
        Ok(())
    }
}

/// Fills in the estimates in parallel, chunk by chunk.
fn each_chunk(
    points: &[SurfacePoint],
    estimates: &mut [Estimate],
    control: Control<'_>,
    fill: impl Fn(&[SurfacePoint], &mut [Estimate]) + Sync,
) {
    points.par_chunks(CHUNK).zip(estimates.par_chunks_mut(CHUNK)).for_each(|(points, estimates)| {
        if control.is_cancelled() {
            return;
        }
        fill(points, estimates);
        (control.progress)(points.len());
    });
}

/// The same for a method with cones, which are marched for all points of a chunk together.
fn each_marched(
    marches: &Marches<'_>,
    points: &[SurfacePoint],
    estimates: &mut [Estimate],
    control: Control<'_>,
    estimate: impl Fn(&SurfacePoint, &[ConeResult]) -> Estimate + Sync,
) {
    each_chunk(points, estimates, control, |points, estimates| {
        let valid: Vec<_> = points.iter().filter(|point| point.is_valid()).copied().collect();
        let results = marches.march(&valid);
        let mut results = results.chunks(marches.count());
        for (point, out) in points.iter().zip(estimates) {
            let results = if point.is_valid() { results.next() } else { None };
            *out = results.map_or(Estimate::INVALID, |results| estimate(point, results));
        }
    });
}
