//! How long kernels run, by the device's own clock.

use crate::{Gpu, GpuError};
use std::sync::{Mutex, PoisonError};

/// The runs of one entry point.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelTime {
    /// Its name.
    pub kernel: &'static str,
    /// How often it ran.
    pub runs: u32,
    /// Seconds in all, from the start of its first thread to the end of its last.
    pub seconds: f64,
}

/// Two time stamps about each of some runs.
pub(crate) struct Clock {
    pub(crate) stamps: wgpu::QuerySet,
    pub(crate) resolved: wgpu::Buffer,
    /// Of one tick.
    seconds: f64,
    times: Mutex<Vec<KernelTime>>,
}

impl Clock {
    /// Runs between two answers at most.
    pub(crate) const RUNS: usize = 32;

    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let stamps = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("time stamps"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * Self::RUNS as u32,
        });
        let resolved = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("time stamps"),
            size: (2 * Self::RUNS * size_of::<u64>()) as u64,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let seconds = 1e-9 * f64::from(queue.get_timestamp_period());
        Self { stamps, resolved, seconds, times: Mutex::new(Vec::new()) }
    }

    /// Adds the runs that the stamps are about.
    pub(crate) fn note(&self, gpu: &Gpu, kernels: &[&'static str]) -> Result<(), GpuError> {
        let stamps: Vec<u64> = gpu.read(&self.resolved, 2 * kernels.len())?;
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        for (&kernel, stamps) in kernels.iter().zip(stamps.chunks(2)) {
            let seconds = stamps[1].saturating_sub(stamps[0]) as f64 * self.seconds;
            match times.iter_mut().find(|time| time.kernel == kernel) {
                Some(time) => {
                    time.runs += 1;
                    time.seconds += seconds;
                }
                None => times.push(KernelTime { kernel, runs: 1, seconds }),
            }
        }
        Ok(())
    }
}

impl Gpu {
    /// What kernels took since the last call, in the order of their first runs; nothing where the device was not opened with a clock, or has none.
    pub fn kernel_times(&self) -> Vec<KernelTime> {
        let take =
            |clock: &Clock| std::mem::take(&mut *clock.times.lock().unwrap_or_else(PoisonError::into_inner));
        self.clock.as_ref().map(take).unwrap_or_default()
    }
}
