//! The compressed wide BVH of the crate `obvhs`, with its own triangle test.

use super::{Family, Kernel, Tile, Tracer};
use crate::hemispheres::Order;
use conray_core::{Geometry, Vec3, Vec3A};
use fearless_simd::{Level, Simd, dispatch};
use glam::UVec2;
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::Ray,
    rt_triangle::RtTriangle,
    traverse,
    triangle::Triangle,
};
use std::time::Duration;

/// A scene in obvhs.
pub struct Obvhs {
    bvh: CwBvh,
    /// In the order of the leaves, so that no index is looked up.
    triangles: Vec<RtTriangle>,
    distance: f32,
    build_seconds: f64,
}

impl Obvhs {
    /// Builds at the crate's best quality: split triangles, every node tried for reinsertion.
    pub fn build(geometry: &Geometry, distance: f32) -> Self {
        let mut triangles = Vec::new();
        for (index, instance) in geometry.instances().iter().enumerate() {
            let mesh = geometry.mesh_of(index);
            let place = |p: Vec3| Vec3A::from(instance.world_from_mesh.transform_point3(p));
            triangles.extend((0..mesh.triangles().len()).map(|t| {
                let [v0, v1, v2] = mesh.corners(t).map(place);
                Triangle { v0, v1, v2 }
            }));
        }
        let mut taken = Duration::ZERO;
        let bvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::very_slow_build(), &mut taken);
        let leaves = bvh.primitive_indices.iter().map(|&i| RtTriangle::from(&triangles[i as usize]));
        let triangles = leaves.collect();
        Self { bvh, triangles, distance, build_seconds: taken.as_secs_f64() }
    }

    /// Wall-clock seconds of the build as the crate counts them.
    pub fn build_seconds(&self) -> f64 {
        self.build_seconds
    }

    /// True where nothing is in the way.
    #[inline(always)]
    fn is_open(&self, ray: &Ray) -> bool {
        let mut state = self.bvh.new_traversal(ray.direction);
        let mut node;
        let mut open = true;
        'search: {
            traverse!(self.bvh, node, state, node.intersect_ray(ray, state.oct_inv4), {
                if self.triangles[state.primitive_id as usize].intersect(ray) < ray.tmax {
                    open = false;
                    break 'search;
                }
            });
        }
        open
    }
}

impl Kernel for Obvhs {
    fn name(&self) -> String {
        "obvhs, CWBVH".into()
    }

    fn family(&self) -> Family {
        Family::Obvhs
    }

    fn order(&self) -> Order {
        Order::Morton
    }

    fn tracer(&self) -> Box<dyn Tracer + '_> {
        Box::new(ObvhsTracer { kernel: self, level: Level::new(), rays: Vec::new(), open: Vec::new() })
    }
}

struct ObvhsTracer<'a> {
    kernel: &'a Obvhs,
    level: Level,
    rays: Vec<Ray>,
    open: Vec<bool>,
}

impl Tracer for ObvhsTracer<'_> {
    fn prepare(&mut self, tile: Tile<'_>) {
        self.rays.clear();
        for (origin, _, directions) in tile.hemispheres() {
            let ray = |&d: &Vec3| Ray::new(origin.into(), d.into(), 0.0, self.kernel.distance);
            self.rays.extend(directions.iter().map(ray));
        }
        self.open.resize(self.rays.len(), false);
    }

    /// Compiled for what the processor can, as a program built for one machine would be.
    fn trace(&mut self) {
        let (kernel, rays, open) = (self.kernel, &self.rays, &mut self.open);
        dispatch!(self.level, simd => simd.vectorize(
            #[inline(always)]
            || rays.iter().zip(open).for_each(|(ray, open)| *open = kernel.is_open(ray))
        ));
    }

    fn answers(&self, open: &mut Vec<bool>) {
        open.extend(&self.open);
    }
}
