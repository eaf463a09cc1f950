//! Seconds that hierarchies take to build: ours and Embree's in turn, on the same threads.

use crate::{
    embree::{Device, Embree, SceneFlags},
    race::median,
};
use conray_bvh::Bvh;
use conray_core::Geometry;
use std::{sync::Arc, time::Instant};

/// Seconds of something done several times: median, fastest, slowest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seconds {
    /// The middle one.
    pub median: f64,
    /// Fastest and slowest.
    pub spread: (f64, f64),
}

impl Seconds {
    /// Of one or more runs.
    pub fn of(mut seconds: Vec<f64>) -> Self {
        let median = median(&mut seconds);
        let ends = (seconds.first().copied().unwrap_or(0.0), seconds.last().copied().unwrap_or(0.0));
        Self { median, spread: ends }
    }
}

/// Builds of one geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Builds {
    /// [`Bvh::build`], from meshes and placements to a hierarchy that answers.
    pub conray: Seconds,
    /// `rtcCommitScene` at quality high, with the triangles already in Embree's buffers.
    pub embree: Seconds,
}

impl Builds {
    /// Builds both `times` times in turn, after one of each that does not count. Our share of Embree's favour: moving
    /// the triangles into the world is in our time and not in its.
    ///
    /// # Errors
    /// What a builder says.
    pub fn time(geometry: &Geometry, device: &Arc<Device>, times: usize) -> Result<Self, String> {
        let geometry = Arc::new(geometry.clone());
        let (mut conray, mut embree) = (Vec::new(), Vec::new());
        for round in 0..=times {
            let start = Instant::now();
            let bvh = Bvh::build(Arc::clone(&geometry)).map_err(|e| e.to_string())?;
            let seconds = start.elapsed().as_secs_f64();
            drop(bvh);
            let theirs = Embree::build(device, &geometry, SceneFlags::default())?.build_seconds();
            if round > 0 {
                conray.push(seconds);
                embree.push(theirs);
            }
        }
        Ok(Self { conray: Seconds::of(conray), embree: Seconds::of(embree) })
    }

    /// Our time in units of Embree's.
    pub fn ratio(&self) -> f64 {
        self.conray.median / self.embree.median
    }
}
