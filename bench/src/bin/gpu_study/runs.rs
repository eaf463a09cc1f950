//! A method on a device once, and what it came to.

use conray::{AoSettings, Control, Estimate, Method, SurfacePoint};
use conray_bvh::Bvh;
use conray_core::Bounds;
use conray_estimate::{AoPlan, Backend, Budget, CpuBackend, Hybrid, RayErrors, SettingsError};
use conray_gpu::{GpuBackend, KernelTime};
use std::{error::Error, sync::Arc, time::Instant};

/// All that methods work on.
pub(crate) struct Stage {
    pub(crate) bvh: Arc<Bvh>,
    pub(crate) device: Arc<GpuBackend>,
    pub(crate) bounds: Bounds,
    pub(crate) size: [u32; 2],
    pub(crate) voxels: u32,
}

/// What one run of a method came to.
pub(crate) struct Run {
    pub(crate) seconds: f64,
    pub(crate) kernels: Vec<KernelTime>,
    pub(crate) estimates: Vec<Estimate>,
    /// Traced, also those that are in no estimate.
    pub(crate) rays: u64,
    /// How rays err, where the method found out.
    pub(crate) errors: Option<RayErrors>,
}

impl Run {
    pub(crate) fn on_device(&self) -> f64 {
        self.kernels.iter().map(|time| time.seconds).sum()
    }

    pub(crate) fn rmse(&self, truth: &[Estimate]) -> f64 {
        rmse(&self.estimates, truth)
    }
}

pub(crate) fn rmse(found: &[Estimate], truth: &[Estimate]) -> f64 {
    let squares = found.iter().zip(truth).map(|(a, b)| f64::from(a.visibility - b.visibility).powi(2));
    (squares.sum::<f64>() / truth.len().max(1) as f64).sqrt()
}

impl Stage {
    pub(crate) fn plan(&self, method: Method, rays: u32) -> Result<AoPlan, SettingsError> {
        let settings = AoSettings { method, voxels: self.voxels, rays: Some(rays), ..AoSettings::default() };
        AoPlan::new(&settings, self.bounds)
    }

    /// Rays of another seed: on the CPU where the device is one too, for there they are faster.
    pub(crate) fn truth(&self, rays: u32, points: &[SurfacePoint]) -> Result<Vec<Estimate>, Box<dyn Error>> {
        let plan = AoPlan { seed: 0x7e57, ..self.plan(Method::Rays, rays)? };
        if !self.device.gpu().facts().is_software {
            return self.estimated(&plan, rays, points);
        }
        let mut estimates = vec![Estimate::PENDING; points.len()];
        let cpu = CpuBackend::new(Arc::clone(&self.bvh), None);
        cpu.estimate(&plan, 0..rays, points, &mut estimates, Control::none())?;
        Ok(estimates)
    }

    fn estimated(
        &self,
        plan: &AoPlan,
        samples: u32,
        points: &[SurfacePoint],
    ) -> Result<Vec<Estimate>, Box<dyn Error>> {
        let mut estimates = vec![Estimate::PENDING; points.len()];
        self.device.estimate(plan, 0..samples, points, &mut estimates, Control::none())?;
        Ok(estimates)
    }

    /// A method point by point, with so many rays.
    pub(crate) fn run(
        &self,
        method: Method,
        rays: u32,
        points: &[SurfacePoint],
    ) -> Result<Run, Box<dyn Error>> {
        let plan = self.plan(method, rays)?;
        self.device.gpu().kernel_times();
        let start = Instant::now();
        let estimates = self.estimated(&plan, plan.samples(), points)?;
        let seconds = start.elapsed().as_secs_f64();
        let rays = estimates.iter().map(|e| u64::from(e.rays)).sum();
        Ok(Run { seconds, kernels: self.device.gpu().kernel_times(), estimates, rays, errors: None })
    }

    /// Method `hybrid` until it expects that error.
    pub(crate) fn refine(&self, error: f32, points: &[SurfacePoint]) -> Result<Run, Box<dyn Error>> {
        let plan = self.plan(Method::Hybrid, 1 << 16)?;
        self.device.gpu().kernel_times();
        let start = Instant::now();
        let mut hybrid = Hybrid::of_image(&plan, points, 0, self.size);
        let budget = Budget { error: Some(error), ..Budget::rays(1 << 16) };
        hybrid.refine_on(self.device.hybrid_device(), &plan, &self.bvh, points, budget, Control::none());
        if let Some(failure) = hybrid.failure() {
            return Err(failure.to_string().into());
        }
        let estimates = hybrid.estimates();
        let (seconds, kernels) = (start.elapsed().as_secs_f64(), self.device.gpu().kernel_times());
        Ok(Run { seconds, kernels, estimates, rays: hybrid.rays(), errors: Some(hybrid.ray_errors()) })
    }
}

/// The run of median time among several.
pub(crate) fn median<E>(repeats: usize, mut run: impl FnMut() -> Result<Run, E>) -> Result<Run, E> {
    let mut runs = (0..repeats.max(1)).map(|_| run()).collect::<Result<Vec<_>, _>>()?;
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    Ok(runs.swap_remove(runs.len() / 2))
}

/// A line of the table.
pub(crate) fn tell(name: &str, run: &Run, truth: &[Estimate]) {
    let (rays, on_device) = (run.rays as f64 / 1e6, run.on_device());
    let told = |time: &KernelTime| format!("{} {:.3} ms in {}", time.kernel, 1e3 * time.seconds, time.runs);
    let kernels: Vec<String> = run.kernels.iter().map(told).collect();
    println!(
        "{name:8} {:>10.4} {on_device:>10.4} {rays:>9.2} {:>9.1} {:>8.4}  {}",
        run.seconds,
        if on_device > 0.0 { rays / on_device } else { 0.0 },
        run.rmse(truth),
        if kernels.is_empty() { "the adapter has no clock".into() } else { kernels.join(", ") }
    );
}
