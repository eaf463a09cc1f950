//! Sessions of one scene by different settings, which share what was built.

use crate::{
    Error, Observer, Session, SessionOptions,
    device::{Chosen, Parts},
    session::{build_octree, check_memory},
};
use conray_estimate::{AoPlan, AoSettings, Backend};
use conray_voxel::Octree;
use std::sync::Arc;

impl Session {
    /// A session of the same scene by other settings: BVH and threads are shared, the octree too where it is the one asked for. Only what is missing is
    /// built: an octree for a method that marches cones, and what a graphics processor needs.
    ///
    /// The opacity of materials ([`AoSettings::alpha`]) and the threads stay those of the first build.
    ///
    /// # Errors
    /// As of [`Session::build_observed`].
    pub fn with(
        &self,
        settings: &AoSettings,
        options: &SessionOptions,
        observer: Observer<'_>,
    ) -> Result<Self, Error> {
        self.shared(settings, options, settings.method.needs_octree(), observer)
    }

    /// The same with an octree in any case, to look at.
    ///
    /// # Errors
    /// As of [`Session::build_observed`].
    pub fn with_octree(
        &self,
        settings: &AoSettings,
        options: &SessionOptions,
        observer: Observer<'_>,
    ) -> Result<Self, Error> {
        self.shared(settings, options, true, observer)
    }

    fn shared(
        &self,
        settings: &AoSettings,
        options: &SessionOptions,
        needs_octree: bool,
        observer: Observer<'_>,
    ) -> Result<Self, Error> {
        let (geometry, bvh, bounds) = (Arc::clone(&self.geometry), Arc::clone(&self.bvh), self.bounds);
        let (plan, pool, mut report) =
            (AoPlan::new(settings, bounds)?, self.pool.clone(), self.report.clone());
        check_memory(&geometry, settings, &report)?;
        let octree_of = (settings.voxels, settings.max_memory);
        let mut octree = self.octree.clone().filter(|_| octree_of == self.octree_of);
        if octree.is_none() {
            (report.octree_seconds, report.octree_bytes, report.voxels) = (0.0, 0, 0);
            if needs_octree {
                octree = Some(build_octree(&geometry, &pool, settings, observer, &mut report)?);
            }
        }
        let backend = match self.backend_for(&plan, options, &octree) {
            Some(backend) => backend,
            None => {
                let parts = Parts { plan: &plan, geometry: &geometry, bvh: &bvh, octree: &octree };
                let Chosen { backend, place } =
                    pool.install(|| parts.choose(options.device, options.adapter.as_deref()))?;
                report.device = place;
                backend
            }
        };
        let options = options.clone();
        Ok(Self { geometry, bounds, plan, bvh, octree, backend, pool, options, octree_of, report })
    }

    /// This session's backend, where another plan would get the same: what is on a device need not be taken there again.
    fn backend_for(
        &self,
        plan: &AoPlan,
        options: &SessionOptions,
        octree: &Option<Arc<Octree>>,
    ) -> Option<Arc<dyn Backend>> {
        let same_octree = match (&self.octree, octree) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (one, other) => one.is_none() && other.is_none(),
        };
        let same_device = (self.options.device, &self.options.adapter) == (options.device, &options.adapter);
        let same_kernels = (self.plan.method, self.plan.sampling) == (plan.method, plan.sampling);
        (same_octree && same_device && same_kernels).then(|| Arc::clone(&self.backend))
    }
}
