//! Ways to find which rays are open: ours and the rivals', behind one trait.
//!
//! A kernel is given the same rays as every other, in the order that suits it, and may take them over into a layout of
//! its own before the clock starts. What is timed is the tracing alone.

mod conray;
mod embree;
mod obvhs;

use crate::hemispheres::Order;
use conray_core::{SurfacePoint, Vec3};

pub use conray::{Bundles, Single};
pub use embree::{EmbreeKernel, Mode, Packing};
pub use obvhs::Obvhs;

/// Whose kernel it is, which decides how well it must agree and what it is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Ours: must agree with each other to the last ray.
    Conray,
    /// Embree: the rival whose best mode is the measure.
    Embree,
    /// Another rival.
    Obvhs,
}

/// Some neighbouring points and their rays.
#[derive(Clone, Copy)]
pub struct Tile<'a> {
    /// Where the rays start.
    pub points: &'a [SurfacePoint],
    /// Unit directions, point by point, equally many for each.
    pub directions: &'a [Vec3],
}

impl<'a> Tile<'a> {
    /// Origin of its rays, surface point and directions for each point.
    pub fn hemispheres(self) -> impl Iterator<Item = (Vec3, &'a SurfacePoint, &'a [Vec3])> {
        let rays = (self.directions.len() / self.points.len().max(1)).max(1);
        self.points.iter().zip(self.directions.chunks(rays)).map(|(p, d)| (p.ray_origin(), p, d))
    }
}

/// A way to find which rays are open.
pub trait Kernel: Sync {
    /// Name in tables.
    fn name(&self) -> String;

    /// Whose it is.
    fn family(&self) -> Family;

    /// The order of a point's rays that suits it best.
    fn order(&self) -> Order;

    /// What one thread needs to trace with it.
    fn tracer(&self) -> Box<dyn Tracer + '_>;
}

impl<K: Kernel + ?Sized> Kernel for &K {
    fn name(&self) -> String {
        (**self).name()
    }

    fn family(&self) -> Family {
        (**self).family()
    }

    fn order(&self) -> Order {
        (**self).order()
    }

    fn tracer(&self) -> Box<dyn Tracer + '_> {
        (**self).tracer()
    }
}

/// A kernel at work on one thread.
pub trait Tracer {
    /// Takes rays over into the kernel's own layout. Not timed.
    fn prepare(&mut self, tile: Tile<'_>);

    /// Traces them all and keeps the answers as it finds them. Timed.
    fn trace(&mut self);

    /// Appends true for each open ray and false for each blocked one, in the order given. Not timed.
    fn answers(&self, open: &mut Vec<bool>);
}
