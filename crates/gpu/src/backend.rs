//! Plans carried out on a device.

use crate::{Gpu, GpuError, GpuScene, cone_rays::ConeRays, cones::Cones, points::AoUniform, rays::Rays};
use conray_core::{Estimate, Geometry, SurfacePoint};
use conray_estimate::{AoPlan, Backend, BackendError, BlendAnswers, ConeAnswers, Control, Method, RayTally};
use conray_voxel::Octree;
use std::ops::Range;

/// Points, or cones of points, whose rays are traced together: with as many rays each as a workgroup has threads short enough that no driver takes the device
/// for stuck.
const TRACED_AT_ONCE: usize = 1 << 18;
/// Cones that are marched together where none gets rays.
const MARCHED_AT_ONCE: usize = 1 << 20;

/// Estimates points on a device.
pub struct GpuBackend {
    gpu: Gpu,
    rays: Option<Rays>,
    cones: Option<Cones>,
    blend: Option<ConeRays>,
}

impl GpuBackend {
    /// Uploads what methods need, and compiles their shaders: the scene for `rays`, an octree for `cones`, both for `paper`.
    ///
    /// # Errors
    /// What is too large for the adapter, with the numbers, a shader that it refuses, or a device that fails.
    pub fn new(gpu: Gpu, geometry: Option<&Geometry>, octree: Option<&Octree>) -> Result<Self, GpuError> {
        let rays = geometry.map(|geometry| Rays::new(&gpu, GpuScene::new(&gpu, geometry)?)).transpose()?;
        let cones = octree.map(|octree| Cones::new(&gpu, octree)).transpose()?;
        let blend = match (&rays, &cones) {
            (Some(rays), Some(_)) => Some(ConeRays::new(&gpu, rays)?),
            _ => None,
        };
        Ok(Self { gpu, rays, cones, blend })
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
            Method::Rays => AoUniform::new(plan, 0..1, 0).map(|_| ()),
            Method::Cones | Method::Paper => Ok(()),
            method => Err(GpuError::Method(method)),
        }
    }

    fn estimated(
        &self,
        plan: &AoPlan,
        samples: Range<u32>,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Option<Vec<Estimate>>, GpuError> {
        match (plan.method, &self.rays, &self.cones) {
            (Method::Rays, Some(rays), _) => {
                let found = rays.tallies(&self.gpu, plan, samples, points, control)?;
                Ok(found.map(|found| found.iter().map(|tally| tally.tally().estimate()).collect()))
            }
            (Method::Cones, _, Some(cones)) => {
                let mut found = cones.march(&self.gpu, plan, points)?;
                let answers = ConeAnswers::new(plan);
                let each = points.iter().zip(found.chunks_mut(plan.cones.cones().len()));
                Ok(Some(each.map(|(point, results)| answers.estimate(point, results)).collect()))
            }
            (Method::Paper, Some(rays), Some(cones)) => {
                self.blended(rays, cones, plan, samples, points, control)
            }
            (method, ..) => Err(GpuError::Method(method)),
        }
    }

    /// Cones where they are trusted, rays inside of them elsewhere.
    fn blended(
        &self,
        rays: &Rays,
        cones: &Cones,
        plan: &AoPlan,
        frames: Range<u32>,
        points: &[SurfacePoint],
        control: Control<'_>,
    ) -> Result<Option<Vec<Estimate>>, GpuError> {
        let Some(blend) = &self.blend else { return Err(GpuError::Method(plan.method)) };
        let count = plan.cones.cones().len();
        let answers = BlendAnswers::new(plan);
        let mut marched = cones.march(&self.gpu, plan, points)?;
        let counts: Vec<u32> = points
            .iter()
            .zip(marched.chunks_mut(count))
            .flat_map(|(point, results)| answers.ray_counts(point, results))
            .collect();
        let found = blend.tallies(&self.gpu, rays, plan, frames, points, &counts, control)?;
        let Some(found) = found else { return Ok(None) };
        let tallies: Vec<RayTally> = found.iter().map(|tally| tally.tally()).collect();
        let each = points.iter().zip(marched.chunks(count)).zip(tallies.chunks(count));
        Ok(Some(each.map(|((point, results), tallies)| answers.estimate(point, results, tallies)).collect()))
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
        if points.len() != estimates.len() {
            return Err(BackendError::LengthMismatch { points: points.len(), estimates: estimates.len() });
        }
        let cones = plan.cones.cones().len();
        let at_once = match plan.method {
            Method::Cones => MARCHED_AT_ONCE / cones,
            Method::Paper => TRACED_AT_ONCE / cones,
            _ => TRACED_AT_ONCE,
        };
        let device = |e: GpuError| BackendError::Device(e.to_string());
        Self::check(plan).map_err(device)?;
        for (points, estimates) in points.chunks(at_once).zip(estimates.chunks_mut(at_once)) {
            if control.is_cancelled() {
                return Ok(());
            }
            let found = self.estimated(plan, samples.clone(), points, control).map_err(device)?;
            let Some(found) = found else { return Ok(()) };
            for ((estimate, found), point) in estimates.iter_mut().zip(found).zip(points) {
                let invalid = Estimate { visibility: 0.0, error: f32::INFINITY, ..Estimate::PENDING };
                *estimate = if point.is_valid() { found } else { invalid };
            }
            (control.progress)(points.len());
        }
        Ok(())
    }
}
