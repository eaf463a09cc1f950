//! Scenes and oracles that several tests share.
#![allow(dead_code, reason = "each test file uses a part of this")]

pub(crate) mod brute;
pub(crate) mod obj;
pub(crate) mod shapes;

use conray_bvh::Bvh;
use conray_core::{
    Affine3A, Falloff, Frame, Geometry, Material, Moments, Opacity, Ray, SurfacePoint, TriangleMesh, Vec3,
    cosine_hemisphere, hash_u32, owen_sobol_2d,
};
use std::sync::Arc;

/// A stream of random numbers; the same seed gives the same stream.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    pub(crate) fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        hash_u32(self.0)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    /// In [-1, 1).
    pub(crate) fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        ((u64::from(self.bits()) * n as u64) >> 32) as usize
    }

    /// In the cube [-1, 1)^3.
    pub(crate) fn cube(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    /// Uniform on the sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            if (0.01..=1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// Barycentric weights of corners 1 and 2; one time in eight on an edge, one in eight on a corner.
    pub(crate) fn barycentric(&mut self) -> (f32, f32) {
        let (mut u, mut v) = (self.unit(), self.unit());
        match self.below(8) {
            0 => v = 0.0,
            1 => (u, v) = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)][self.below(3)],
            _ => {}
        }
        if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) }
    }
}

/// Meshes with opacities, placed.
#[derive(Default)]
pub(crate) struct Scene(pub(crate) Geometry);

impl Scene {
    /// Adds an opaque mesh as it is.
    pub(crate) fn with(self, mesh: TriangleMesh) -> Self {
        self.with_opacity(mesh, Opacity::Constant(1.0), &[Affine3A::IDENTITY])
    }

    /// Adds a mesh with an opacity, placed as often as there are transforms.
    pub(crate) fn with_opacity(
        mut self,
        mesh: TriangleMesh,
        opacity: Opacity,
        placements: &[Affine3A],
    ) -> Self {
        let material = self.0.add_material(Material { opacity, ..Material::default() });
        let mesh = self.0.add_mesh(mesh.with_material(material)).unwrap();
        for &placement in placements {
            self.0.add_instance(mesh, placement).unwrap();
        }
        self
    }

    /// The hierarchy, validated.
    pub(crate) fn bvh(self) -> Bvh {
        let bvh = Bvh::build(Arc::new(self.0)).unwrap();
        bvh.validate().unwrap();
        bvh
    }
}

/// Visibility at a point: the mean over seeds, each of 64 stratified rays.
pub(crate) fn visibility(
    bvh: &Bvh,
    point: &SurfacePoint,
    falloff: Falloff,
    distance: f32,
    seeds: u32,
) -> Moments {
    let frame = Frame::from_normal(point.shading_normal);
    let origin = point.ray_origin();
    let mean = |seed: u32| {
        let ray = |i: u32| {
            let direction = frame.to_world(cosine_hemisphere(owen_sobol_2d(i, seed)));
            let ray = Ray { origin, direction, t_max: distance };
            f64::from(bvh.visibility(&ray, falloff, distance))
        };
        (0..64).map(ray).sum::<f64>() / 64.0
    };
    (0..seeds).map(mean).collect()
}

/// Whether a mean agrees with a number within four standard errors (and the rounding of single results).
pub(crate) fn agrees(m: &Moments, truth: f64) -> bool {
    (m.mean - truth).abs() <= 4.0 * m.standard_error() + 1e-6
}
