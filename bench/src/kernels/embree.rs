//! Embree's kernels: single rays, and packets of 4, 8 and 16 with and without the coherent hint.

use super::{Family, Kernel, Tile, Tracer};
use crate::{
    embree::{Embree, Packet, Ray1},
    hemispheres::Order,
};
use conray_core::{Ray, SurfacePoint, Vec3};
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
        /// Which rays make a packet.
        packing: Packing,
    },
}

/// Which rays make a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// Neighbours in the order of one point's rays: one origin, and a cone of directions.
    Point,
    /// Rays at the same place in the order of neighbouring points: almost one direction, and origins in a row.
    Row,
}

impl Mode {
    /// Every mode.
    pub fn all() -> Vec<Self> {
        let mut modes = vec![Self::Single];
        for packing in [Packing::Point, Packing::Row] {
            for size in [4, 8, 16] {
                modes.extend([false, true].map(|coherent| Self::Packets { size, coherent, packing }));
            }
        }
        modes
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Packets { size, coherent, packing } = self else { return f.write_str("rtcOccluded1") };
        let hint = if *coherent { ", coherent" } else { "" };
        let row = if *packing == Packing::Row { ", rows" } else { "" };
        write!(f, "rtcOccluded{size}{hint}{row}")
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
        let Mode::Packets { size, coherent, packing } = self.mode else {
            return Box::new(Singles { kernel: self, rays: Vec::new() });
        };
        match size {
            4 => Box::new(Packets::<4>::new(self, coherent, packing)),
            8 => Box::new(Packets::<8>::new(self, coherent, packing)),
            _ => Box::new(Packets::<16>::new(self, coherent, packing)),
        }
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
    packing: Packing,
    packets: Vec<Packet<N>>,
    /// Place in the tile of each packet's rays.
    places: Vec<[usize; N]>,
    rays: usize,
}

impl<'a, const N: usize> Packets<'a, N> {
    fn new(kernel: &'a EmbreeKernel<'a>, coherent: bool, packing: Packing) -> Self {
        Self { kernel, coherent, packing, packets: Vec::new(), places: Vec::new(), rays: 0 }
    }

    /// Places in the tile of the rays of each packet, for that many points with that many rays each.
    ///
    /// Points at the end that fill no row have packets of their own.
    fn place(&mut self, points: usize, rays: usize) {
        assert!(rays.is_multiple_of(N), "packets of {N} out of {rays} rays");
        let rows = if self.packing == Packing::Row { points / N } else { 0 };
        self.places.clear();
        for row in 0..rows {
            let first = row * N * rays;
            self.places.extend((0..rays).map(|i| std::array::from_fn(|p| first + p * rays + i)));
        }
        for first in (rows * N * rays..points * rays).step_by(N) {
            self.places.push(std::array::from_fn(|i| first + i));
        }
    }
}

impl<const N: usize> Tracer for Packets<'_, N> {
    /// Rays of a point that fill no packet would be left out: their number must be a multiple of `N`.
    fn prepare(&mut self, tile: Tile<'_>) {
        self.rays = tile.directions.len();
        let rays = self.rays / tile.points.len();
        self.place(tile.points.len(), rays);
        let origins: Vec<Vec3> = tile.points.iter().map(SurfacePoint::ray_origin).collect();
        let packet = |places: &[usize; N]| {
            let (origins, directions) =
                (places.map(|i| origins[i / rays]), places.map(|i| tile.directions[i]));
            Packet::new(origins, directions, self.kernel.distance)
        };
        self.packets.clear();
        self.packets.extend(self.places.iter().map(packet));
    }

    fn trace(&mut self) {
        self.kernel.embree.occluded(&mut self.packets, self.coherent);
    }

    fn answers(&self, open: &mut Vec<bool>) {
        let start = open.len();
        open.resize(start + self.rays, false);
        for (packet, places) in self.packets.iter().zip(&self.places) {
            for (&place, answer) in places.iter().zip(packet.open()) {
                open[start + place] = answer;
            }
        }
    }
}
