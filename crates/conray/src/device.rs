//! Where estimates are made: on the CPU or on a graphics processor.

use crate::Error;
use conray_bvh::Bvh;
use conray_core::Geometry;
use conray_estimate::{AoPlan, Backend, CpuBackend};
use conray_voxel::Octree;
use std::sync::Arc;
#[cfg(feature = "gpu")]
use {
    conray_estimate::Method,
    conray_gpu::{Gpu, GpuBackend, GpuError},
};

/// Where estimates are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Device {
    /// On the CPU.
    #[default]
    Cpu,
    /// On a graphics processor; where there is none, or it lacks what the plan needs, that is an error.
    Gpu,
    /// On a graphics processor where there is one that is no program on the CPU, and it has all of the method; else on the CPU.
    Auto,
}

/// A backend, and where it works, for people.
pub(crate) struct Chosen {
    pub(crate) backend: Arc<dyn Backend>,
    pub(crate) place: String,
}

/// What backends are made of.
pub(crate) struct Parts<'a> {
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "the CPU takes any plan"))]
    pub(crate) plan: &'a AoPlan,
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "the CPU has it in its hierarchy"))]
    pub(crate) geometry: &'a Geometry,
    pub(crate) bvh: &'a Arc<Bvh>,
    pub(crate) octree: &'a Option<Arc<Octree>>,
}

impl Parts<'_> {
    /// The backend for a device, of the adapter whose name holds that text where one is named.
    pub(crate) fn choose(&self, device: Device, adapter: Option<&str>) -> Result<Chosen, Error> {
        match device {
            Device::Cpu => Ok(self.cpu("CPU".into())),
            Device::Gpu => self.gpu(adapter),
            Device::Auto => self.auto(adapter),
        }
    }

    fn cpu(&self, place: String) -> Chosen {
        Chosen { backend: Arc::new(CpuBackend::new(Arc::clone(self.bvh), self.octree.clone())), place }
    }
}

#[cfg(feature = "gpu")]
impl Parts<'_> {
    fn gpu(&self, adapter: Option<&str>) -> Result<Chosen, Error> {
        let device = |e: GpuError| Error::Device(e.to_string());
        GpuBackend::check(self.plan).map_err(device)?;
        Gpu::open(adapter).and_then(|gpu| self.on(gpu)).map_err(device)
    }

    fn auto(&self, adapter: Option<&str>) -> Result<Chosen, Error> {
        // What no device has needs no word.
        if GpuBackend::check(self.plan).is_err() {
            return Ok(self.cpu("CPU".into()));
        }
        // One that is named is meant, whatever it is.
        let gpu = if adapter.is_some() { Gpu::open(adapter) } else { Gpu::open_real() };
        Ok(match gpu {
            Err(GpuError::NoAdapter { wanted: None, .. }) => {
                self.cpu("CPU: there is no graphics adapter".into())
            }
            gpu => gpu.and_then(|gpu| self.on(gpu)).unwrap_or_else(|e| self.cpu(format!("CPU: {e}"))),
        })
    }

    fn on(&self, gpu: Gpu) -> Result<Chosen, GpuError> {
        let place = format!("{} ({})", gpu.facts().name, gpu.facts().backend);
        let traced = (self.plan.method != Method::Cones).then_some(self.geometry);
        let backend = GpuBackend::new(gpu, traced, self.octree.as_deref())?;
        Ok(Chosen { backend: Arc::new(backend), place })
    }
}

#[cfg(not(feature = "gpu"))]
impl Parts<'_> {
    fn gpu(&self, _: Option<&str>) -> Result<Chosen, Error> {
        Err(Error::Device("conray was built without feature gpu".into()))
    }

    fn auto(&self, _: Option<&str>) -> Result<Chosen, Error> {
        Ok(self.cpu("CPU".into()))
    }
}
