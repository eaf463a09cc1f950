//! No ray leaves a closed mesh, wherever it is, however large, however it is aimed.

mod common;

use common::shapes::{cube, icosphere, mesh};
use common::{Random, Scene};
use conray_bvh::Bvh;
use conray_core::{Affine3A, Opacity, Quat, Ray, TriangleMesh, Vec3};

const FAR_AWAY: Vec3 = Vec3::new(148_376.0, 1234.0, -223_423.0);

/// World corners of a random triangle's point: inside, on an edge or on a corner.
fn target(bvh: &Bvh, random: &mut Random) -> Vec3 {
    let instance = random.below(bvh.geometry().instances().len()) as u32;
    let triangles = bvh.geometry().mesh_of(instance as usize).triangles().len();
    let corners = bvh.world_corners(instance, random.below(triangles) as u32);
    let (u, v) = random.barycentric();
    conray_bvh::triangle_point(&corners, u, v)
}

/// How many of some rays from about `inside` escape.
fn escapes(bvh: &Bvh, inside: Vec3, wander: f32, rays: u32, random: &mut Random) -> u32 {
    let mut escaped = 0;
    for _ in 0..rays {
        let origin = inside + wander * random.cube();
        let direction = (target(bvh, random) - origin).normalize();
        let ray = Ray { origin, direction, t_max: f32::INFINITY };
        let open = [bvh.transmittance(&ray) != 0.0, bvh.nearest(&ray).is_none()];
        assert_eq!(open[0], open[1], "the queries disagree about {ray:?}");
        escaped += u32::from(open[0]);
    }
    escaped
}

fn moved((positions, triangles): (Vec<Vec3>, Vec<[u32; 3]>), centre: Vec3, scale: f32) -> TriangleMesh {
    mesh(positions.iter().map(|&p| centre + scale * p).collect(), triangles)
}

#[test]
fn nothing_escapes_a_sphere_or_a_cube() {
    let mut random = Random(5);
    let places = [1e-18f32, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e18].map(|scale| (Vec3::ZERO, scale));
    let far_places = [1.0f32, 10.0, 1e3, 1e6].map(|scale| (FAR_AWAY, scale));
    for (centre, scale) in places.into_iter().chain(far_places) {
        for shape in [icosphere(0), icosphere(3), cube()] {
            let bvh = Scene::default().with(moved(shape, centre, scale)).bvh();
            assert_eq!(escapes(&bvh, centre, 0.3 * scale, 3000, &mut random), 0, "{centre} {scale}");
        }
    }
}

#[test]
fn nothing_escapes_instances() {
    let mut random = Random(6);
    let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 1.1);
    for scale in [Vec3::ONE, Vec3::new(-2.0, 2.0, 2.0), Vec3::new(1e-3, 1e3, 1.0), Vec3::splat(1e-5)] {
        let place = |at: Vec3| Affine3A::from_scale_rotation_translation(scale, turn, at);
        let (positions, triangles) = icosphere(3);
        let bvh = Scene::default()
            .with_opacity(
                mesh(positions, triangles),
                Opacity::Constant(1.0),
                &[place(Vec3::ZERO), place(FAR_AWAY)],
            )
            .bvh();
        assert_eq!(bvh.stats().instances, 2);
        let escaped = (0..2000)
            .filter(|_| {
                let ray = Ray { origin: Vec3::ZERO, direction: random.direction(), t_max: f32::INFINITY };
                bvh.transmittance(&ray) != 0.0
            })
            .count();
        assert_eq!(escaped, 0, "{scale}");
    }
}

#[test]
fn a_missing_triangle_is_found() {
    let mut random = Random(7);
    let (positions, mut triangles) = icosphere(2);
    triangles.pop();
    let bvh = Scene::default().with(mesh(positions, triangles)).bvh();
    let escaped = (0..20_000)
        .filter(|_| {
            let ray = Ray { origin: Vec3::ZERO, direction: random.direction(), t_max: f32::INFINITY };
            bvh.transmittance(&ray) == 1.0
        })
        .count();
    // One of 320 triangles.
    assert!((30..110).contains(&escaped), "{escaped}");
}

#[test]
fn fans_and_slivers_close_too() {
    // A double cone of 3,000 slivers: all meet in two points, and every other corner lies on a straight edge.
    let n = 1500u32;
    let rim = |i: u32| {
        let (sin, cos) = (std::f32::consts::TAU * (i / 2) as f32 / (n / 2) as f32).sin_cos();
        let next = (std::f32::consts::TAU * (i / 2 + 1) as f32 / (n / 2) as f32).sin_cos();
        let p = Vec3::new(cos, sin, 0.0);
        if i.is_multiple_of(2) { p } else { 0.5 * (p + Vec3::new(next.1, next.0, 0.0)) }
    };
    let positions: Vec<Vec3> = (0..n).map(rim).chain([Vec3::Z, Vec3::NEG_Z]).collect();
    let triangles = (0..n).flat_map(|i| [[i, (i + 1) % n, n], [(i + 1) % n, i, n + 1]]).collect();
    let bvh = Scene::default().with(moved((positions, triangles), Vec3::new(0.3, -7.0, 11.0), 3.0)).bvh();
    assert_eq!(escapes(&bvh, Vec3::new(0.3, -7.0, 11.0), 0.5, 20_000, &mut Random(8)), 0);
}
