//! A session: what was built for one scene, ready to answer.

use crate::{
    Device, Error, Event, Observer, Outcome, Stage,
    device::{Chosen, Parts},
    threads::Threads,
};
use conray_bvh::Bvh;
use conray_core::{Bounds, Estimate, Geometry, SurfacePoint, Vec2, Vec3, View};
use conray_estimate::{Alpha, AoPlan, AoSettings, Backend, BackendError, Control, SettingsError};
use conray_target::{Camera, CameraTarget};
use conray_voxel::{Octree, OctreeOptions};
use std::{ops::Range, sync::Arc};
use web_time::Instant;

/// How a session works; nothing here changes a result by more than rounding.
#[derive(Clone, Debug, Default)]
pub struct SessionOptions {
    /// Threads to work on; 0 is one per core.
    pub threads: usize,
    /// Where estimates are made. Results of a graphics processor differ from those of the CPU by rounding.
    pub device: Device,
    /// Part of the name of the adapter that is meant; without one the first.
    pub adapter: Option<String>,
}

/// Times and sizes of what was built.
#[derive(Clone, Debug, Default)]
pub struct BuildReport {
    /// Wall-clock time of the BVH build.
    pub bvh_seconds: f64,
    /// Size of the BVH.
    pub bvh_bytes: u64,
    /// Wall-clock time of the octree build; 0 without one.
    pub octree_seconds: f64,
    /// Size of the octree; 0 without one.
    pub octree_bytes: u64,
    /// Leaves along the longest side of the scene; 0 without an octree, less than asked for where memory was short.
    pub voxels: u32,
    /// Where estimates are made, for people: the CPU, with the reason where a graphics processor could have been meant, or an adapter.
    pub device: String,
}

/// A scene made ready for AO queries.
pub struct Session {
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) bounds: Bounds,
    pub(crate) plan: AoPlan,
    pub(crate) bvh: Arc<Bvh>,
    pub(crate) octree: Option<Arc<Octree>>,
    pub(crate) backend: Arc<dyn Backend>,
    pub(crate) pool: Threads,
    pub(crate) options: SessionOptions,
    /// Voxels and memory that the octree was asked for with.
    pub(crate) octree_of: (u32, Option<u64>),
    pub(crate) report: BuildReport,
}

impl Session {
    /// Builds what the settings need for a scene, on all cores.
    ///
    /// # Errors
    /// A setting outside its range, or too little memory allowed for the smallest octree.
    pub fn build(geometry: Geometry, settings: &AoSettings) -> Result<Self, Error> {
        Self::build_observed(geometry, settings, &SessionOptions::default(), &|_| {})
    }

    /// As [`Session::build`], with options and a receiver of events.
    pub fn build_observed(
        mut geometry: Geometry,
        settings: &AoSettings,
        options: &SessionOptions,
        observer: Observer<'_>,
    ) -> Result<Self, Error> {
        let bounds = geometry.bounds();
        let plan = AoPlan::new(settings, bounds)?;
        let pool = Threads::start(options.threads)?;
        if settings.alpha == Alpha::Opaque {
            geometry.make_opaque();
        }
        let geometry = Arc::new(geometry);
        let (bvh, bvh_seconds) =
            timed(Stage::Bvh, observer, || pool.install(|| Bvh::build(Arc::clone(&geometry))))?;
        let mut report = BuildReport { bvh_seconds, bvh_bytes: bvh.memory_bytes(), ..Default::default() };
        let octree = if settings.method.needs_octree() {
            Some(build_octree(&geometry, &pool, settings, observer, &mut report)?)
        } else {
            check_memory(&geometry, settings, &report)?;
            None
        };
        let bvh = Arc::new(bvh);
        let parts = Parts { plan: &plan, geometry: &geometry, bvh: &bvh, octree: &octree };
        let Chosen { backend, place } =
            pool.install(|| parts.choose(options.device, options.adapter.as_deref()))?;
        report.device = place;
        let (options, octree_of) = (options.clone(), (settings.voxels, settings.max_memory));
        Ok(Self { geometry, bounds, plan, bvh, octree, backend, pool, options, octree_of, report })
    }

    /// A session of some instances alone, on the CPU, with the same plan and threads; its octree has as many leaves along its longest side as that of the
    /// whole scene.
    ///
    /// # Errors
    /// What a build refuses.
    pub fn only(&self, instances: &[u32]) -> Result<Self, Error> {
        let geometry = Arc::new(self.geometry.only(instances));
        let start = Instant::now();
        let bvh =
            Arc::new(self.pool.install(|| Bvh::build(Arc::clone(&geometry)))?.at_level(self.bvh.level()));
        let mut report = BuildReport {
            bvh_seconds: start.elapsed().as_secs_f64(),
            bvh_bytes: bvh.memory_bytes(),
            ..Default::default()
        };
        let octree = match &self.octree {
            None => None,
            Some(octree) => {
                let (start, resolution) = (Instant::now(), octree.resolution());
                let options = OctreeOptions { resolution, ..OctreeOptions::default() };
                let octree = self.pool.install(|| Octree::build(&geometry, &options))?;
                report.octree_seconds = start.elapsed().as_secs_f64();
                report.octree_bytes = octree.memory_bytes();
                report.voxels = octree.resolution();
                Some(Arc::new(octree))
            }
        };
        let parts = Parts { plan: &self.plan, geometry: &geometry, bvh: &bvh, octree: &octree };
        let Chosen { backend, place } = parts.choose(Device::Cpu, None)?;
        report.device = place;
        let (bounds, plan, pool) = (geometry.bounds(), self.plan.clone(), self.pool.clone());
        let options = SessionOptions { device: Device::Cpu, adapter: None, ..self.options.clone() };
        let octree_of = self.octree_of;
        Ok(Self { geometry, bounds, plan, bvh, octree, backend, pool, options, octree_of, report })
    }

    /// Bytes of the scene and of what was built for it.
    pub fn memory_bytes(&self) -> u64 {
        geometry_bytes(&self.geometry) + self.report.bvh_bytes + self.report.octree_bytes
    }

    /// The scene.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// World bounds of the scene.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// What the settings came to for this scene.
    pub fn plan(&self) -> &AoPlan {
        &self.plan
    }

    /// The BVH; sessions of one scene share it.
    pub fn bvh(&self) -> &Arc<Bvh> {
        &self.bvh
    }

    /// The octree, where the method marches cones; sessions of one scene share it.
    pub fn octree(&self) -> Option<&Arc<Octree>> {
        self.octree.as_ref()
    }

    /// Times and sizes of what was built.
    pub fn report(&self) -> &BuildReport {
        &self.report
    }

    /// Bytes that an octree of that many leaves along the longest side would take at the peak of its build; 0 where
    /// there is nothing to voxelise or the resolution is outside its range.
    pub fn estimate_octree_bytes(&self, voxels: u32) -> u64 {
        self.pool.install(|| Octree::estimate_memory(&self.geometry, voxels))
    }

    /// The surface points that a camera sees, one per pixel centre.
    ///
    /// # Errors
    /// A view or a size that makes no picture.
    pub fn camera(&self, view: &View, width: u32, height: u32) -> Result<CameraTarget, Error> {
        let camera = Camera::new(view, width, height)?;
        let hit = |ray: &conray_core::Ray| self.bvh.nearest(ray).map(|hit| self.bvh.surface_point(&hit, ray));
        Ok(self.pool.install(|| CameraTarget::trace(camera, hit)))
    }

    /// Estimates every point, in order.
    ///
    /// # Errors
    /// A device that fails.
    pub fn estimate(&self, points: &[SurfacePoint]) -> Result<Vec<Estimate>, Error> {
        let Outcome { estimates, work } = self.run(points, Control::none())?;
        work.failure.map_or(Ok(estimates), |reason| Err(BackendError::Device(reason).into()))
    }

    /// What other settings come to for this scene, to be carried out by [`Session::estimate_plan`].
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn plan_for(&self, settings: &AoSettings) -> Result<AoPlan, Error> {
        Ok(AoPlan::new(settings, self.bounds)?)
    }

    /// Carries out a part of another plan with the structures already built, in one pass over the points.
    ///
    /// `samples` says which part of each point's sequence: ray indices for methods `rays` and `hybrid` (which is
    /// `rays` where points are taken one by one), frames for the others.
    /// Estimates of disjoint parts are put together by [`conray_estimate::merge`].
    ///
    /// # Errors
    /// A method that needs an octree in a session built without.
    pub fn estimate_plan(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Vec<Estimate>, Error> {
        let mut estimates = vec![Estimate::PENDING; points.len()];
        self.install(|| self.backend.estimate(plan, samples, points, &mut estimates, control))?;
        Ok(estimates)
    }

    /// Runs work on the session's threads: rayon's parallel iterators inside it use them.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// How many threads the session works on.
    pub fn threads(&self) -> usize {
        self.pool.count()
    }

    /// The other settings of this session with the structures already built.
    ///
    /// Only what the plan says may change: method (to one whose structures exist), distance, falloff, rays, sampling,
    /// cones, beta, gamma, max-rays, seed.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn set_plan(&mut self, settings: &AoSettings) -> Result<(), Error> {
        self.plan = AoPlan::new(settings, self.bounds)?;
        Ok(())
    }
}

/// The octree that the settings ask for, told in the report.
pub(crate) fn build_octree(
    geometry: &Geometry,
    pool: &Threads,
    settings: &AoSettings,
    observer: Observer<'_>,
    report: &mut BuildReport,
) -> Result<Arc<Octree>, Error> {
    let max_memory_bytes = memory_left(settings, report.bvh_bytes + geometry_bytes(geometry))?;
    let options = OctreeOptions { resolution: settings.voxels, max_memory_bytes, ..OctreeOptions::default() };
    let (octree, seconds) =
        timed(Stage::Octree, observer, || pool.install(|| Octree::build(geometry, &options)))?;
    report.octree_seconds = seconds;
    report.octree_bytes = octree.memory_bytes();
    report.voxels = octree.resolution();
    if report.voxels < settings.voxels {
        let message = format!(
            "the octree has {} voxels along the longest side instead of {}, to stay within the memory allowed",
            report.voxels, settings.voxels
        );
        observer(Event::Warning { message });
    }
    Ok(Arc::new(octree))
}

/// Whether scene and BVH alone stay within the memory allowed.
pub(crate) fn check_memory(
    geometry: &Geometry,
    settings: &AoSettings,
    report: &BuildReport,
) -> Result<(), SettingsError> {
    memory_left(settings, report.bvh_bytes + geometry_bytes(geometry)).map(drop)
}

/// What is left of the memory allowed once the scene and its BVH are there; `None` without a limit.
fn memory_left(settings: &AoSettings, taken: u64) -> Result<Option<u64>, SettingsError> {
    match settings.max_memory {
        Some(allowed) if taken >= allowed => Err(SettingsError {
            option: "max-memory",
            found: allowed.to_string(),
            expected: format!("the scene and its BVH alone take {taken} bytes"),
        }),
        limit => Ok(limit.map(|allowed| allowed - taken)),
    }
}

/// Bytes of the vertex and index arrays.
fn geometry_bytes(geometry: &Geometry) -> u64 {
    let mesh_bytes = |m: &conray_core::TriangleMesh| {
        size_of_val(m.positions())
            + size_of_val(m.normals())
            + size_of_val(m.tangents())
            + size_of_val(m.triangles())
            + m.uv_sets().len() * m.positions().len() * size_of::<Vec2>()
    };
    debug_assert_eq!(size_of::<Vec3>(), 12);
    let meshes = geometry.meshes().iter().map(mesh_bytes).sum::<usize>() as u64;
    // Materials may share a texture; the few bytes counted twice are allowed for.
    let normals = geometry.materials().iter().filter_map(|material| material.normal_map.as_ref());
    meshes + normals.map(|map| map.texture.memory_bytes()).sum::<u64>()
}

/// Runs one stage between its events and gives its wall-clock seconds.
fn timed<T, E>(
    stage: Stage,
    observer: Observer<'_>,
    work: impl FnOnce() -> Result<T, E>,
) -> Result<(T, f64), E> {
    observer(Event::Started { stage });
    let start = Instant::now();
    let result = work()?;
    let seconds = start.elapsed().as_secs_f64();
    observer(Event::Finished { stage, seconds });
    Ok((result, seconds))
}
