//! Our kernels.

use super::{Family, Kernel, Tile, Tracer};
use crate::hemispheres::Order;
use conray_bvh::{BUNDLE_RAYS, Bvh, Directions};
use conray_core::{Ray, Vec3};

/// Single rays: the reference, as its answers are exact.
pub struct Single<'a> {
    /// What is traced.
    pub bvh: &'a Bvh,
    /// AO distance in world units.
    pub distance: f32,
}

/// Bundles of rays from one origin.
pub struct Bundles<'a> {
    /// What is traced.
    pub bvh: &'a Bvh,
    /// AO distance in world units.
    pub distance: f32,
}

impl Kernel for Single<'_> {
    fn name(&self) -> String {
        "conray, single rays".into()
    }

    fn family(&self) -> Family {
        Family::Conray
    }

    fn order(&self) -> Order {
        Order::Morton
    }

    fn tracer(&self) -> Box<dyn Tracer + '_> {
        Box::new(SingleTracer { kernel: self, rays: Vec::new(), open: Vec::new() })
    }
}

struct SingleTracer<'a> {
    kernel: &'a Single<'a>,
    rays: Vec<Ray>,
    open: Vec<bool>,
}

impl Tracer for SingleTracer<'_> {
    fn prepare(&mut self, tile: Tile<'_>) {
        self.rays.clear();
        let t_max = self.kernel.distance;
        for (origin, _, directions) in tile.hemispheres() {
            self.rays.extend(directions.iter().map(|&direction| Ray { origin, direction, t_max }));
        }
        self.open.resize(self.rays.len(), false);
    }

    fn trace(&mut self) {
        for (ray, open) in self.rays.iter().zip(&mut self.open) {
            *open = self.kernel.bvh.transmittance(ray) > 0.5;
        }
    }

    fn answers(&self, open: &mut Vec<bool>) {
        open.extend(&self.open);
    }
}

impl Kernel for Bundles<'_> {
    fn name(&self) -> String {
        "conray, bundles".into()
    }

    fn family(&self) -> Family {
        Family::Conray
    }

    fn order(&self) -> Order {
        Order::Morton
    }

    fn tracer(&self) -> Box<dyn Tracer + '_> {
        Box::new(BundleTracer { kernel: self, bundles: Vec::new(), used: 0, passing: Vec::new() })
    }
}

struct BundleTracer<'a> {
    kernel: &'a Bundles<'a>,
    /// Origin, normal and directions; those beyond `used` are kept for later tiles.
    bundles: Vec<(Vec3, Vec3, Directions)>,
    used: usize,
    /// Share of light that passes along each ray.
    passing: Vec<f32>,
}

impl Tracer for BundleTracer<'_> {
    fn prepare(&mut self, tile: Tile<'_>) {
        let (mut used, mut rays) = (0, 0);
        for (origin, point, directions) in tile.hemispheres() {
            for directions in directions.chunks(BUNDLE_RAYS) {
                if used == self.bundles.len() {
                    self.bundles.push((origin, point.geometric_normal, Directions::new()));
                }
                let bundle = &mut self.bundles[used];
                (bundle.0, bundle.1) = (origin, point.geometric_normal);
                bundle.2.clear();
                bundle.2.extend(directions.iter().copied());
                used += 1;
                rays += directions.len();
            }
        }
        self.used = used;
        self.passing.resize(rays, 0.0);
    }

    fn trace(&mut self) {
        let mut passing = &mut self.passing[..];
        for (origin, normal, directions) in &self.bundles[..self.used] {
            let (found, to_find) = passing.split_at_mut(directions.len());
            self.kernel.bvh.transmittances(*origin, *normal, directions, self.kernel.distance, found);
            passing = to_find;
        }
    }

    fn answers(&self, open: &mut Vec<bool>) {
        open.extend(self.passing.iter().map(|&t| t > 0.5));
    }
}
