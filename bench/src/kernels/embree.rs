//! Embree's kernels: single rays, and packets of 4, 8 and 16 with and without the coherent hint.

use super::{Family, Kernel, Tile, Tracer};
use crate::{
    embree::{Embree, Packet, Ray1},
    hemispheres::Order,
};
use conray_core::Ray;
use std::fmt;

/// Which function is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// `rtcOccluded1`.
    Single,
    /// `rtcOccluded4`, `8` or `16`.
    Packets {
        /// Rays of a packet.
        size: usize,
        /// With `RTC_RAY_QUERY_FLAG_COHERENT`.
        coherent: bool,
    },
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 7] = [
        Self::Single,
        Self::Packets { size: 4, coherent: false },
        Self::Packets { size: 4, coherent: true },
        Self::Packets { size: 8, coherent: false },
        Self::Packets { size: 8, coherent: true },
        Self::Packets { size: 16, coherent: false },
        Self::Packets { size: 16, coherent: true },
    ];
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Single => f.write_str("rtcOccluded1"),
            Self::Packets { size, coherent: false } => write!(f, "rtcOccluded{size}"),
            Self::Packets { size, coherent: true } => write!(f, "rtcOccluded{size}, coherent"),
        }
    }
}

/// A mode on a scene.
pub struct EmbreeKernel<'a> {
    /// What is traced.
    pub embree: &'a Embree,
    /// What the scene's device and flags are called in tables; empty for the defaults.
    pub variant: &'a str,
    /// Which function is called.
    pub mode: Mode,
    /// The order of a point's rays.
    pub order: Order,
    /// AO distance in world units.
    pub distance: f32,
}

impl Kernel for EmbreeKernel<'_> {
    fn name(&self) -> String {
        let variant = if self.variant.is_empty() { String::new() } else { format!(" [{}]", self.variant) };
        format!("Embree{variant}, {}, {}", self.mode, format!("{:?}", self.order).to_lowercase())
    }

    fn family(&self) -> Family {
        Family::Embree
    }

    fn order(&self) -> Order {
        self.order
    }

    fn tracer(&self) -> Box<dyn Tracer + '_> {
        match self.mode {
            Mode::Single => Box::new(Singles { kernel: self, rays: Vec::new() }),
            Mode::Packets { size: 4, coherent } => self.packets::<4>(coherent),
            Mode::Packets { size: 8, coherent } => self.packets::<8>(coherent),
            Mode::Packets { coherent, .. } => self.packets::<16>(coherent),
        }
    }
}

impl EmbreeKernel<'_> {
    fn packets<const N: usize>(&self, coherent: bool) -> Box<dyn Tracer + '_> {
        Box::new(Packets::<N> { kernel: self, coherent, packets: Vec::new() })
    }
}

struct Singles<'a> {
    kernel: &'a EmbreeKernel<'a>,
    rays: Vec<Ray1>,
}

impl Tracer for Singles<'_> {
    fn prepare(&mut self, tile: Tile<'_>) {
        self.rays.clear();
        let t_max = self.kernel.distance;
        for (origin, _, directions) in tile.hemispheres() {
            let rays = directions.iter().map(|&direction| Ray1::new(&Ray { origin, direction, t_max }));
            self.rays.extend(rays);
        }
    }

    fn trace(&mut self) {
        self.kernel.embree.occluded1(&mut self.rays);
    }

    fn answers(&self, open: &mut Vec<bool>) {
        open.extend(self.rays.iter().map(Ray1::is_open));
    }
}

struct Packets<'a, const N: usize> {
    kernel: &'a EmbreeKernel<'a>,
    coherent: bool,
    packets: Vec<Packet<N>>,
}

impl<const N: usize> Tracer for Packets<'_, N> {
    /// Rays of a point that fill no packet would be left out: their number must be a multiple of `N`.
    fn prepare(&mut self, tile: Tile<'_>) {
        self.packets.clear();
        for (origin, _, directions) in tile.hemispheres() {
            assert!(directions.len().is_multiple_of(N), "packets of {N} out of {} rays", directions.len());
            let packets = directions.chunks(N).map(|d| Packet::new(origin, d, self.kernel.distance));
            self.packets.extend(packets);
        }
    }

    fn trace(&mut self) {
        self.kernel.embree.occluded(&mut self.packets, self.coherent);
    }

    fn answers(&self, open: &mut Vec<bool>) {
        open.extend(self.packets.iter().flat_map(Packet::open));
    }
}
