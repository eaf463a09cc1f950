//! Plans carried out on a device.

use crate::{
    Gpu, GpuError,
    bundles::BundleRays,
    cone_rays::{Asked, ConeRays},
    cones::Cones,
    frame::FrameKernels,
    points::{AoUniform, GpuTally},
    rays::Rays,
    scene::GpuScene,
    weighing::{WeighKernels, Weigher},
};
use conray_core::{Estimate, Geometry, SurfacePoint};
use conray_estimate::{
    AoPlan, Backend, BackendError, Batch, BatchFound, BlendAnswers, ConeAnswers, Control, HybridConstants,
    HybridDevice, Method, PlaceWeigher, Places, RayTally,
};
use conray_voxel::{ConeResult, Octree};
use rayon::prelude::*;
use std::{ops::Range, sync::OnceLock};

/// Points, or cones of points, whose rays are traced together: with as many rays each as a workgroup has threads short enough that no driver takes the device
/// for stuck.
const TRACED_AT_ONCE: usize = 1 << 18;
/// Cones that are marched together where none gets rays.
const MARCHED_AT_ONCE: usize = 1 << 20;

/// As many times fewer where the device is a program on the CPU: so that it hears within a second or two that it is to stop.
const SLOWER: usize = 32;

/// Estimates points on a device.
pub struct GpuBackend {
    gpu: Gpu,
    pub(crate) rays: Option<Rays>,
    cones: Option<Cones>,
    cone_rays: Option<ConeRays>,
    bundles: Option<BundleRays>,
    /// Compiled at the first weighing.
    weighing: OnceLock<Result<WeighKernels, GpuError>>,
    /// Compiled for the first picture.
    frames: OnceLock<Result<FrameKernels, GpuError>>,
}

/// The refusal of what was not uploaded.
pub(crate) fn absent(method: Method) -> GpuError {
    GpuError::NotUploaded(method)
}

impl GpuBackend {
    /// Uploads what methods need, and compiles their shaders: the scene for `rays` and `hybrid`, an octree for `cones`, both for `paper`.
    ///
    /// # Errors
    /// What is too large for the adapter, with the numbers, a shader that it refuses, or a device that fails.
    pub fn new(gpu: Gpu, geometry: Option<&Geometry>, octree: Option<&Octree>) -> Result<Self, GpuError> {
        let rays = geometry.map(|geometry| Rays::new(&gpu, GpuScene::new(&gpu, geometry)?)).transpose()?;
        let cones = octree.map(|octree| Cones::new(&gpu, octree)).transpose()?;
        let cone_rays = match (&rays, &cones) {
            (Some(rays), Some(_)) => Some(ConeRays::new(&gpu, rays)?),
            _ => None,
        };
        let bundles = rays.as_ref().map(|rays| BundleRays::new(&gpu, rays)).transpose()?;
        Ok(Self { gpu, rays, cones, cone_rays, bundles, weighing: OnceLock::new(), frames: OnceLock::new() })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Refuses a plan that is not built for devices.
    ///
    /// # Errors
    /// What is missing.
    pub fn check(plan: &AoPlan) -> Result<(), GpuError> {
        match plan.method {
            Method::Rays | Method::Hybrid => AoUniform::new(plan, 0..1, 0).map(|_| ()),
            Method::Cones | Method::Paper => Ok(()),
        }
    }

    /// The kernels that weigh.
    pub(crate) fn weigh_kernels(&self) -> Result<&WeighKernels, GpuError> {
        self.weighing.get_or_init(|| WeighKernels::new(&self.gpu)).as_ref().map_err(Clone::clone)
    }

    /// The kernels of pictures.
    pub(crate) fn frame_kernels(&self) -> Result<&FrameKernels, GpuError> {
        let rays = self.rays.as_ref().ok_or_else(|| absent(Method::Hybrid))?;
        let weighed = &self.weigh_kernels()?.shared;
        let made = self.frames.get_or_init(|| FrameKernels::new(&self.gpu, &rays.scene.layout, weighed));
        made.as_ref().map_err(Clone::clone)
    }

    /// [`Backend::estimate`] as a future: for a page, where nobody may wait for a device. It hears that it is to stop between the parts of its work.
    ///
    /// # Errors
    /// What was not uploaded for the plan, or a device that fails.
    pub async fn estimate_later(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        estimates: &mut [Estimate],
        control: Control<'_>,
    ) -> Result<(), BackendError> {
        BackendError::check_lengths(points, estimates)?;
        let cones = plan.cones.cones().len();
        let slowness = if self.gpu.facts().is_software { SLOWER } else { 1 };
        let at_once = match plan.method {
            Method::Cones => MARCHED_AT_ONCE / cones,
            Method::Paper => TRACED_AT_ONCE / cones,
            _ => TRACED_AT_ONCE,
        };
        let at_once = at_once / slowness;
        let device = |e: GpuError| BackendError::Device(e.to_string());
        Self::check(plan).map_err(device)?;
        for (points, estimates) in points.chunks(at_once).zip(estimates.chunks_mut(at_once)) {
            if control.is_cancelled() {
                return Ok(());
            }
            let found = self.estimated(plan, samples.clone(), points, control).await.map_err(device)?;
            let Some(found) = found else { return Ok(()) };
            for ((estimate, found), point) in estimates.iter_mut().zip(found).zip(points) {
                *estimate = if point.is_valid() { found } else { Estimate::INVALID };
            }
            (control.progress)(points.len());
        }
        Ok(())
    }

    async fn estimated(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Option<Vec<Estimate>>, GpuError> {
        let absent = || absent(plan.method);
        let rays = || self.rays.as_ref().ok_or_else(absent);
        let cones = || self.cones.as_ref().ok_or_else(absent);
        match plan.method {
            // One by one, points have no neighbours to share with.
            Method::Rays | Method::Hybrid => {
                let found = rays()?.tallies(&self.gpu, plan, samples, points, control).await?;
                Ok(found.map(|found| found.par_iter().map(|tally| tally.tally().estimate()).collect()))
            }
            Method::Cones => {
                let mut found = cones()?.march(&self.gpu, plan, points).await?;
                let answers = ConeAnswers::new(plan);
                let each = points.par_iter().zip(found.par_chunks_mut(plan.cones.cones().len()));
                Ok(Some(each.map(|(point, results)| answers.estimate(point, results)).collect()))
            }
            Method::Paper => {
                let marched = cones()?.march(&self.gpu, plan, points).await?;
                let cone_rays = self.cone_rays.as_ref().ok_or_else(absent)?;
                self.blended((cone_rays, rays()?), marched, plan, samples, points, control).await
            }
        }
    }

    /// What cones that were marched come to, with rays inside of those that are not trusted.
    async fn blended(
        &self,
        (cone_rays, rays): (&ConeRays, &Rays),
        mut marched: Vec<ConeResult>,
        plan: &AoPlan,
        frames: Range<u32>,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Option<Vec<Estimate>>, GpuError> {
        let count = plan.cones.cones().len();
        let answers = BlendAnswers::new(plan);
        let counts: Vec<u32> = points
            .par_iter()
            .zip(marched.par_chunks_mut(count))
            .flat_map_iter(|(point, results)| answers.ray_counts(point, results))
            .collect();
        let asked = Asked { frames, points, counts: &counts };
        let found = cone_rays.tallies(&self.gpu, rays, plan, &asked, control).await?;
        let Some(found) = found else { return Ok(None) };
        let tallies: Vec<RayTally> = found.par_iter().map(GpuTally::tally).collect();
        let each = points.par_iter().zip(marched.par_chunks(count)).zip(tallies.par_chunks(count));
        let each = each.map(|((point, results), tallies)| answers.estimate(point, results, tallies));
        Ok(Some(each.collect()))
    }
}

impl Backend for GpuBackend {
    fn estimate(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        estimates: &mut [Estimate],
        control: Control<'_>,
    ) -> Result<(), BackendError> {
        pollster::block_on(self.estimate_later(plan, samples, points, estimates, control))
    }

    fn hybrid_device(&self) -> Option<&dyn HybridDevice> {
        self.bundles.is_some().then_some(self)
    }
}

impl HybridDevice for GpuBackend {
    fn trace(
        &self,
        plan: &AoPlan,
        points: &[SurfacePoint],
        batches: &[Batch],
        salt: u32,
    ) -> Result<Vec<BatchFound>, BackendError> {
        let (Some(bundles), Some(rays)) = (&self.bundles, &self.rays) else {
            return Err(BackendError::Device(GpuError::NotUploaded(plan.method).to_string()));
        };
        let found = bundles.trace(&self.gpu, rays, plan, points, batches, salt);
        found.map_err(|e| BackendError::Device(e.to_string()))
    }
    fn weigher<'a>(
        &'a self,
        constants: &HybridConstants,
        places: &Places<'_>,
    ) -> Result<Option<Box<dyn PlaceWeigher + 'a>>, BackendError> {
        let kernels = self.weigh_kernels();
        let made = kernels.and_then(|kernels| Weigher::new(&self.gpu, kernels, constants, places));
        let boxed = |weigher: Weigher<'a>| Box::new(weigher) as Box<dyn PlaceWeigher + 'a>;
        made.map(|weigher| weigher.map(boxed)).map_err(|e| BackendError::Device(e.to_string()))
    }
}
