//! Visibility at a point on z = 0 with normal +z, integrated over cosine-weighted rays, against closed forms. Every family
//! comes with a number that is wrong by little, which must be told apart.

mod common;

use common::shapes::{ceiling, disc, mesh, quad, sphere};
use common::{Scene, agrees, visibility};
use conray_bvh::Bvh;
use conray_core::{Affine3A, Falloff, Opacity, SurfacePoint, TriangleMesh, Vec3};

const SEEDS: u32 = 512;
const FAR: f32 = 1e5;

fn at_origin() -> SurfacePoint {
    SurfacePoint::new(Vec3::ZERO, Vec3::Z)
}

/// The mean agrees with the truth, and would not agree with the wrong number.
fn judge(case: &str, bvh: &Bvh, falloff: Falloff, distance: f32, truth: f64, wrong: f64) {
    let m = visibility(bvh, &at_origin(), falloff, distance, SEEDS);
    assert!(agrees(&m, truth), "{case}: {m:?}, {truth}");
    assert!(!agrees(&m, wrong), "{case} is not told from {wrong}: {m:?}");
}

fn one(mesh: TriangleMesh) -> Bvh {
    Scene::default().with(mesh).bvh()
}

fn wall(x: Vec3) -> TriangleMesh {
    // From below the horizon to far above it, at distance 1 along x.
    let along = Vec3::Z.cross(x) * FAR;
    quad(x - 0.5 * along - Vec3::Z, along, Vec3::Z * FAR)
}

#[test]
fn nothing_above_a_plane() {
    let bvh = one(ceiling(0.0, FAR));
    let m = visibility(&bvh, &at_origin(), Falloff::None, f32::INFINITY, SEEDS);
    assert_eq!((m.mean, m.m2), (1.0, 0.0));
    let m = visibility(&one(ceiling(1.0, FAR)), &at_origin(), Falloff::None, f32::INFINITY, SEEDS);
    assert!(!agrees(&m, 1.0));
}

#[test]
fn walls_and_corners() {
    let none = Falloff::None;
    let walled = Scene::default().with(ceiling(0.0, FAR)).with(wall(Vec3::X));
    judge("a wall", &walled.bvh(), none, f32::INFINITY, 0.5, 0.5005);
    let corner = Scene::default().with(wall(Vec3::X)).with(wall(Vec3::NEG_Y));
    judge("a corner", &corner.bvh(), none, f32::INFINITY, 0.25, 0.251);
}

#[test]
fn parallel_discs() {
    for (radius, h) in [(0.5f32, 1.0f32), (1.0, 1.0), (2.0, 0.7)] {
        let truth = |r: f32| 1.0 - f64::from(r * r) / f64::from(r * r + h * h);
        let bvh = one(disc(h, radius, 2048));
        judge("a disc", &bvh, Falloff::None, f32::INFINITY, truth(radius), truth(1.03 * radius));
    }
}

#[test]
fn spheres_above_the_horizon() {
    for (radius, d, angle_rad) in [(0.5f32, 1.0f32, 0.0f32), (0.5, 1.5, 0.7), (0.1, 0.5, 1.0)] {
        let centre = d * Vec3::new(angle_rad.sin(), 0.0, angle_rad.cos());
        assert!(centre.z > radius);
        // The faces of 20,480 lie within the sphere by up to 1.7e-4 of its radius, half of it on average.
        let bvh = one(sphere(5, centre, radius * (1.0 + 0.9e-4)));
        let truth = |r: f32| 1.0 - f64::from((r / d).powi(2) * angle_rad.cos());
        judge("a sphere", &bvh, Falloff::None, f32::INFINITY, truth(radius), truth(1.1 * radius));
    }
}

#[test]
fn a_ceiling_counts_within_the_distance_only() {
    let bvh = one(ceiling(1.0, FAR));
    for distance in [1.25f32, 2.0, 4.0] {
        let a = 1.0 / f64::from(distance);
        judge("a ceiling", &bvh, Falloff::None, distance, a * a, (a * 1.02).powi(2));
    }
    let m = visibility(&bvh, &at_origin(), Falloff::None, 0.999, SEEDS);
    assert_eq!(m.mean, 1.0);
}

/// With `a` = height over distance and `mu` the cosine: hits lie at x = a / mu of the distance, so visibility is the
/// integral of `2 mu (1 - weight(a / mu))` over mu from a to 1, plus `a^2` for what passes by.
fn ceiling_with_falloff(falloff: Falloff, a: f64) -> f64 {
    match falloff {
        Falloff::None => a * a,
        Falloff::Linear => 2.0 * a - a * a,
        Falloff::Smooth => -3.0 * a * a - 6.0 * a * a * a.ln() + 4.0 * a * a * a,
    }
}

#[test]
fn a_ceiling_fades_with_its_distance() {
    let bvh = one(ceiling(1.0, FAR));
    for falloff in [Falloff::Linear, Falloff::Smooth] {
        for distance in [1.25f32, 2.0, 10.0] {
            let truth = |d: f32| ceiling_with_falloff(falloff, 1.0 / f64::from(d));
            judge("falloff", &bvh, falloff, distance, truth(distance), truth(1.02 * distance));
        }
    }
}

fn layers(opacities: &[(f32, f32)]) -> Bvh {
    let layer = |scene: Scene, &(h, o): &(f32, f32)| {
        scene.with_opacity(ceiling(h, FAR), Opacity::Constant(o), &[Affine3A::IDENTITY])
    };
    opacities.iter().fold(Scene::default(), layer).bvh()
}

#[test]
fn ceilings_of_some_opacity() {
    let none = Falloff::None;
    judge("0.3", &layers(&[(1.0, 0.3)]), none, f32::INFINITY, 0.7, 0.701);
    judge("0.3, 0.6", &layers(&[(2.0, 0.6), (1.0, 0.3)]), none, f32::INFINITY, 0.28, 0.281);
    judge("0", &layers(&[(1.0, 0.0)]), none, f32::INFINITY, 1.0, 0.999);
    judge("not a number", &layers(&[(1.0, f32::NAN)]), none, f32::INFINITY, 1.0, 0.999);
    judge("above 1", &layers(&[(1.0, 7.0)]), none, f32::INFINITY, 0.0, 0.001);
}

#[test]
fn ceilings_of_some_opacity_fade_in_order() {
    for falloff in [Falloff::Linear, Falloff::Smooth] {
        let distance = 4.0;
        let occlusion = |h: f64| 1.0 - ceiling_with_falloff(falloff, h / 4.0);
        // The nearer layer weighs first, wherever it stands in the file.
        let truth = 1.0 - (0.3 * occlusion(1.0) + 0.7 * 0.6 * occlusion(2.0) + 0.7 * 0.4 * occlusion(3.0));
        let swapped = 1.0 - (0.6 * occlusion(2.0) + 0.4 * 0.3 * occlusion(1.0) + 0.7 * 0.4 * occlusion(3.0));
        for order in [[(1.0, 0.3), (2.0, 0.6), (3.0, 1.0)], [(3.0, 1.0), (2.0, 0.6), (1.0, 0.3)]] {
            judge("layers", &layers(&order), falloff, distance, truth, swapped);
        }
    }
}

#[test]
fn an_infinite_distance_fades_nothing() {
    let bvh = one(ceiling(1.0, FAR));
    for falloff in [Falloff::None, Falloff::Linear, Falloff::Smooth] {
        let m = visibility(&bvh, &at_origin(), falloff, f32::INFINITY, 16);
        assert!(m.mean < 1e-3, "{falloff}: {m:?}");
    }
}

#[test]
fn a_tent_shares_its_ridge_once() {
    // Two sheets of opacity 0.5 that meet over the point: rays through the ridge must not count both.
    let p = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let tent = mesh(
        vec![
            p(0.0, -1.0, 1.0),
            p(0.0, 1.0, 1.0),
            p(-1.0, -1.0, 0.5),
            p(-1.0, 1.0, 0.5),
            p(1.0, -1.0, 0.5),
            p(1.0, 1.0, 0.5),
        ],
        vec![[0, 1, 2], [2, 1, 3], [1, 0, 4], [1, 4, 5]],
    );
    let bvh = Scene::default().with_opacity(tent, Opacity::Constant(0.5), &[Affine3A::IDENTITY]).bvh();
    for i in 0..1000 {
        let y = (i as f32 - 500.0) / 600.0;
        let direction = p(0.0, y, 1.0).normalize();
        let ray = conray_core::Ray { origin: Vec3::ZERO, direction, t_max: f32::INFINITY };
        assert_eq!(bvh.transmittance(&ray), 0.5, "y {y}");
    }
}
