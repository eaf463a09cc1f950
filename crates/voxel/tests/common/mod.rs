//! Small scenes, and a ray caster that tries every triangle in double precision.
#![allow(dead_code, reason = "each test program uses a part")]

use conray_core::{
    Affine3A, ConeSet, Falloff, Frame, Geometry, HemisphereCones, Quat, TriangleMesh, Vec3, hash_u32,
    owen_sobol_2d,
};
use conray_voxel::{ConeQuery, MarchOptions, Octree, OctreeOptions};
use glam::DVec3;

/// Triangles as three corners each.
#[derive(Clone, Default)]
pub(crate) struct Soup(pub(crate) Vec<[Vec3; 3]>);

impl Soup {
    pub(crate) fn quad(mut self, [a, b, c, d]: [Vec3; 4]) -> Self {
        self.0.extend([[a, b, c], [a, c, d]]);
        self
    }

    /// A square of that half-size about a point, across a normal.
    pub(crate) fn square(self, centre: Vec3, normal: Vec3, half: f32) -> Self {
        let f = Frame::from_normal(normal);
        let at = |x: f32, y: f32| centre + half * (x * f.x + y * f.y);
        self.quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)])
    }

    pub(crate) fn cuboid(mut self, centre: Vec3, half: Vec3, turn: Quat) -> Self {
        let corner = |i: usize| {
            let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            centre + turn * (half * Vec3::new(sign(0), sign(1), sign(2)))
        };
        for face in [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]] {
            self = self.quad(face.map(corner));
        }
        self
    }

    pub(crate) fn ball(mut self, centre: Vec3, radius: f32, rows: u32) -> Self {
        let at = |i: u32, j: u32| {
            let theta = std::f32::consts::PI * i as f32 / rows as f32;
            let phi = std::f32::consts::PI * j as f32 / rows as f32;
            centre + radius * Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        for i in 0..rows {
            for j in 0..2 * rows {
                self = self.quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        self
    }

    /// A disc facing z.
    pub(crate) fn disc(mut self, centre: Vec3, radius: f32) -> Self {
        let at = |j: u32| {
            let (sin, cos) = (std::f32::consts::TAU * j as f32 / 64.0).sin_cos();
            centre + radius * Vec3::new(cos, sin, 0.0)
        };
        (0..64).for_each(|j| self.0.push([centre, at(j), at(j + 1)]));
        self
    }

    pub(crate) fn turned(mut self, turn: Quat) -> Self {
        self.0.iter_mut().flatten().for_each(|c| *c = turn * *c);
        self
    }

    pub(crate) fn mesh(&self) -> TriangleMesh {
        let positions = self.0.iter().flatten().copied().collect();
        let triangles = (0..self.0.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        TriangleMesh::new(positions, triangles).unwrap()
    }

    pub(crate) fn geometry(&self) -> Geometry {
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(self.mesh()).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        geometry
    }

    pub(crate) fn octree(&self, resolution: u32) -> Octree {
        built(&self.geometry(), resolution)
    }

    /// True where nothing lies within the distance.
    ///
    /// Möller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
    pub(crate) fn is_open(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        !self.0.iter().any(|t| {
            let [a, b, c] = t.map(Vec3::as_dvec3);
            let (e1, e2) = (b - a, c - a);
            let p = d.cross(e2);
            let det = e1.dot(p);
            let s: DVec3 = o - a;
            let (u, q) = (s.dot(p) / det, s.cross(e1));
            let (v, t) = (d.dot(q) / det, e2.dot(q) / det);
            // Not a number where the ray is parallel.
            u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < f64::from(distance)
        })
    }

    /// Visibility by `rays` rays in each cone's cell.
    pub(crate) fn visibility(&self, at: &Ask, cones: &HemisphereCones, rays: u32) -> f32 {
        let frame = Frame::from_normal(at.normal);
        let origin = at.position + at.normal * 1e-5;
        let share = |(k, cone): (u32, &conray_core::Cone)| {
            let open = (0..rays)
                .filter(|&i| {
                    let u = owen_sobol_2d(i, hash_u32(at.seed * 64 + k));
                    self.is_open(origin, frame.to_world(cone.sample(u)), at.distance)
                })
                .count();
            cone.weight * open as f32 / rays as f32
        };
        (0..).zip(cones.cones()).map(share).sum()
    }
}

/// A question: visibility here, within that distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ask {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) distance: f32,
    pub(crate) seed: u32,
}

pub(crate) fn built(geometry: &Geometry, resolution: u32) -> Octree {
    let octree = Octree::build(geometry, &OctreeOptions { resolution, ..Default::default() }).unwrap();
    octree.validate().unwrap();
    octree
}

/// Visibility by cones.
pub(crate) fn by_cones(octree: &Octree, at: &Ask, set: ConeSet, options: &MarchOptions) -> f32 {
    let frame = Frame::from_normal(at.normal);
    let cones = HemisphereCones::new(set);
    let march = |cone: &conray_core::Cone| {
        let query = ConeQuery {
            apex: at.position,
            axis: frame.to_world(cone.axis),
            half_angle_rad: cone.half_angle_rad,
            normal: at.normal,
            distance: at.distance,
            falloff: Falloff::None,
        };
        cone.weight * octree.march_with(&query, options).visibility
    };
    cones.cones().iter().map(march).sum()
}

/// A number in [0, 1) for each index.
pub(crate) fn random(index: u32) -> f32 {
    hash_u32(index) as f32 / 4_294_967_296.0
}

/// A rotation for each index.
pub(crate) fn turn(index: u32) -> Quat {
    let angle = |k: u32| std::f32::consts::TAU * random(1000 + 3 * index + k);
    Quat::from_euler(glam::EulerRot::ZXZ, angle(0), angle(1), angle(2))
}

pub(crate) fn root_mean_square(errors: impl IntoIterator<Item = f32>) -> f32 {
    let (mut sum, mut count) = (0.0f64, 0u32);
    for e in errors {
        sum += f64::from(e).powi(2);
        count += 1;
    }
    assert!(count > 0, "no case was tried");
    (sum / f64::from(count)).sqrt() as f32
}

/// Boxes and a ball on a floor.
pub(crate) fn still_life() -> Soup {
    let mut soup = Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0);
    for k in 0..12 {
        let at = |n: u32| random(7 * k + n);
        let centre = Vec3::new(1.4 * at(0) - 0.7, 1.4 * at(1) - 0.7, 0.3 * at(2));
        soup = soup.cuboid(centre, Vec3::new(at(3), at(4), at(5)) * 0.12 + 0.03, turn(k));
    }
    soup.ball(Vec3::new(0.0, 0.0, 0.15), 0.15, 8)
}
