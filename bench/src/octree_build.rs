//! What an octree costs to build: seconds, and bytes above what was there before.

use crate::{builds::Seconds, memory};
use conray_core::Geometry;
use conray_voxel::{Octree, OctreeOptions, VoxelError};
use std::time::Instant;

/// Builds of one octree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeBuild {
    /// Wall-clock seconds.
    pub seconds: Seconds,
    /// Bytes at the peak of the build as the octree counts them.
    pub peak_bytes: u64,
    /// How far the process rose above what it held before the first build; `None` where the system does not tell.
    pub process_bytes: Option<u64>,
    /// Bytes that the octree holds.
    pub memory_bytes: u64,
}

impl OctreeBuild {
    /// Builds it `times` times, one after the other. Call it before the process has freed much, or the system's count is
    /// too small: what is freed may be used again unseen.
    ///
    /// # Errors
    /// A resolution that no octree has, or what the builder says.
    pub fn time(geometry: &Geometry, resolution: u32, times: usize) -> Result<Self, VoxelError> {
        let options = OctreeOptions { resolution, ..OctreeOptions::default() };
        let (mut seconds, mut process_bytes, mut held) = (Vec::new(), None, (0, 0));
        for round in 0..times.max(1) {
            let before = memory::resident().filter(|_| memory::restart_peak());
            let start = Instant::now();
            let octree = Octree::build(geometry, &options)?;
            seconds.push(start.elapsed().as_secs_f64());
            if round == 0 {
                let after = memory::resident();
                process_bytes = before.zip(after).map(|(b, a)| a.peak.saturating_sub(b.now));
            }
            held = (octree.stats().peak_bytes, octree.memory_bytes());
        }
        let seconds = Seconds::of(seconds);
        Ok(Self { seconds, peak_bytes: held.0, process_bytes, memory_bytes: held.1 })
    }

    /// The larger of both counts of the peak.
    pub fn worst_peak_bytes(&self) -> u64 {
        self.peak_bytes.max(self.process_bytes.unwrap_or(0))
    }
}
