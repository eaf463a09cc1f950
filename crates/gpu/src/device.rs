//! Adapters and devices.

use crate::{GpuError, clock::Clock};
use bytemuck::{NoUninit, cast_slice};
use std::sync::{Arc, Mutex, PoisonError};

/// Least size of a buffer: that of the largest struct that a shader binds.
const LEAST_BYTES: u64 = 112;

/// What is known of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterFacts {
    /// Its name.
    pub name: String,
    /// The interface it is reached by: vulkan, metal, dx12.
    pub backend: String,
    /// The driver and what it says of itself.
    pub driver: String,
    /// True where it is a program on the CPU.
    pub is_software: bool,
    /// The largest buffer that a shader can read, in bytes.
    pub largest_binding: u64,
}

impl AdapterFacts {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        Self {
            name: if info.name.is_empty() { "graphics processor".into() } else { info.name },
            backend: info.backend.to_string(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
            is_software: info.device_type == wgpu::DeviceType::Cpu,
            largest_binding: adapter.limits().max_storage_buffer_binding_size,
        }
    }
}

fn instance() -> wgpu::Instance {
    let native = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: native | wgpu::Backends::BROWSER_WEBGPU,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}

async fn found() -> Vec<(wgpu::Adapter, AdapterFacts)> {
    let adapters = instance().enumerate_adapters(wgpu::Backends::all()).await;
    let with_facts = |adapter: wgpu::Adapter| {
        let facts = AdapterFacts::of(&adapter);
        (adapter, facts)
    };
    let mut found: Vec<_> = adapters.into_iter().map(with_facts).collect();
    // Programs on the CPU last.
    found.sort_by_key(|(_, facts)| facts.is_software);
    found
}

/// Whether an adapter's name holds a text, whatever the case.
fn is_named(name: Option<&str>) -> impl Fn(&AdapterFacts) -> bool {
    let wanted = name.map(str::to_lowercase);
    move |facts| wanted.as_ref().is_none_or(|wanted| facts.name.to_lowercase().contains(wanted))
}

/// The adapters of this machine, real ones first.
pub fn adapters() -> Vec<AdapterFacts> {
    pollster::block_on(found()).into_iter().map(|(_, facts)| facts).collect()
}

/// A device at work.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    facts: AdapterFacts,
    /// The first thing that went wrong outside of what is asked about.
    failure: Arc<Mutex<Option<String>>>,
    /// Where it was asked for and the adapter has one.
    pub(crate) clock: Option<Clock>,
}

impl Gpu {
    /// Opens the first adapter whose name holds that text, whatever the case; without one the first that there is.
    ///
    /// # Errors
    /// There is none, or it gives no device.
    pub fn open(name: Option<&str>) -> Result<Self, GpuError> {
        Self::open_named(name, false)
    }

    /// The same as a future: for a page, which may not block.
    ///
    /// # Errors
    /// As [`Gpu::open`].
    pub async fn open_later(name: Option<&str>) -> Result<Self, GpuError> {
        Self::open_where(name, is_named(name), false).await
    }

    /// The same with a clock, where the adapter has one: each run of a kernel is timed and waited for (see [`Gpu::kernel_times`]).
    ///
    /// # Errors
    /// As [`Gpu::open`].
    pub fn open_timed(name: Option<&str>) -> Result<Self, GpuError> {
        Self::open_named(name, true)
    }

    /// Opens the first adapter that is no program on the CPU.
    ///
    /// # Errors
    /// There is none, or it gives no device.
    pub fn open_real() -> Result<Self, GpuError> {
        pollster::block_on(Self::open_real_later())
    }

    /// The same as a future.
    ///
    /// # Errors
    /// As [`Gpu::open_real`].
    pub async fn open_real_later() -> Result<Self, GpuError> {
        Self::open_where(None, |facts| !facts.is_software, false).await
    }

    fn open_named(name: Option<&str>, timed: bool) -> Result<Self, GpuError> {
        pollster::block_on(Self::open_where(name, is_named(name), timed))
    }

    async fn open_where(
        name: Option<&str>,
        fits: impl Fn(&AdapterFacts) -> bool,
        timed: bool,
    ) -> Result<Self, GpuError> {
        let all = found().await;
        let told: Vec<String> = all.iter().map(|(_, facts)| facts.name.clone()).collect();
        let Some((adapter, facts)) = all.into_iter().find(|(_, facts)| fits(facts)) else {
            let found = if told.is_empty() { "is none".into() } else { format!("are {}", told.join(", ")) };
            return Err(GpuError::NoAdapter { wanted: name.map(Into::into), found });
        };
        // Sizes as the adapter has them, for large scenes; all else as every adapter has it.
        let limits = wgpu::Limits::default().using_resolution(adapter.limits());
        let most = adapter.limits();
        let limits = wgpu::Limits {
            max_buffer_size: most.max_buffer_size,
            max_storage_buffer_binding_size: most.max_storage_buffer_binding_size,
            ..limits
        };
        let wanted = if timed { wgpu::Features::TIMESTAMP_QUERY } else { wgpu::Features::empty() };
        let features = wanted & adapter.features();
        let request = wgpu::DeviceDescriptor {
            label: Some("conray"),
            required_features: features,
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = adapter
            .request_device(&request)
            .await
            .map_err(|e| GpuError::NoDevice { adapter: facts.name.clone(), reason: e.to_string() })?;
        let failure = Arc::new(Mutex::new(None));
        let (lost, uncaught) = (Arc::clone(&failure), Arc::clone(&failure));
        device.set_device_lost_callback(move |_, reason| note(&lost, reason));
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| note(&uncaught, e.to_string())));
        let clock = (!features.is_empty()).then(|| Clock::new(&device, &queue));
        Ok(Self { device, queue, facts, failure, clock })
    }

    /// The adapter.
    pub fn facts(&self) -> &AdapterFacts {
        &self.facts
    }

    /// Gives the device back at once: what is asked of it afterwards fails, as when it is lost.
    pub fn destroy(&self) {
        self.device.destroy();
    }

    /// Refuses what one buffer cannot hold.
    pub(crate) fn check_size(&self, what: &'static str, bytes: u64) -> Result<(), GpuError> {
        let limits = self.device.limits();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if bytes <= limit {
            return Ok(());
        }
        Err(GpuError::TooLarge { what, bytes, adapter: self.facts.name.clone(), limit })
    }

    /// Fails where the device has failed.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.clone().map_or(Ok(()), |reason| Err(self.failed(reason)))
    }

    pub(crate) fn failed(&self, reason: impl Into<String>) -> GpuError {
        GpuError::Failed { adapter: self.facts.name.clone(), reason: reason.into() }
    }

    /// A buffer with these bytes; at least as large as a binding must be.
    pub(crate) fn buffer(
        &self,
        what: &'static str,
        bytes: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let buffer = self.empty(what, bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        self.check()?;
        Ok(buffer)
    }

    /// A buffer for so many values that will be written later, all zero until then; it can be read too.
    pub(crate) fn room<T>(&self, what: &'static str, count: usize) -> Result<wgpu::Buffer, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer = self.empty(what, (count * size_of::<T>()) as u64, usage)?;
        self.check()?;
        Ok(buffer)
    }

    /// Writes values in place of those at the beginning of a buffer.
    pub(crate) fn write<T: NoUninit>(&self, buffer: &wgpu::Buffer, values: &[T]) -> Result<(), GpuError> {
        self.queue.write_buffer(buffer, 0, cast_slice(values));
        self.check()
    }

    /// A buffer for so many answers, all zero at first, to be read.
    pub(crate) fn answers<T>(&self, what: &'static str, count: usize) -> Result<wgpu::Buffer, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let buffer = self.empty(what, (count * size_of::<T>()) as u64, usage)?;
        self.check()?;
        Ok(buffer)
    }

    /// Buffers are zero at first.
    fn empty(
        &self,
        what: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let size = bytes.next_multiple_of(16).max(LEAST_BYTES);
        self.check_size(what, size)?;
        let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        Ok(self.device.create_buffer(&descriptor))
    }
}

fn note(failure: &Mutex<Option<String>>, reason: String) {
    failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(reason);
}
