//! Nothing, nonsense and extremes: defined answers, no panic.

mod common;

use common::shapes::{ceiling, mesh, quad, soup};
use common::{Random, Scene};
use conray_bvh::{Bvh, BvhError};
use conray_core::{Affine3A, Falloff, Geometry, Opacity, Ray, Vec3};
use proptest::prelude::*;
use std::sync::Arc;

fn up(t_max: f32) -> Ray {
    Ray { origin: Vec3::ZERO, direction: Vec3::Z, t_max }
}

fn is_open(bvh: &Bvh, ray: &Ray) -> bool {
    let fades = [Falloff::None, Falloff::Linear, Falloff::Smooth].map(|f| bvh.visibility(ray, f, 10.0));
    let open = bvh.transmittance(ray) == 1.0;
    assert_eq!((open, bvh.nearest(ray).is_none()), (fades == [1.0; 3], open));
    open
}

#[test]
fn empty_geometry_blocks_nothing() {
    let no_triangles = Scene::default().with(mesh(vec![Vec3::ZERO], vec![]));
    let no_instance = Scene::default().with_opacity(ceiling(1.0, 1.0), Opacity::Constant(1.0), &[]);
    let clear =
        Scene::default().with_opacity(ceiling(1.0, 1.0), Opacity::Constant(0.0), &[Affine3A::IDENTITY]);
    for scene in [Scene::default(), no_triangles, no_instance, clear] {
        let bvh = scene.bvh();
        assert!(is_open(&bvh, &up(f32::INFINITY)));
        assert!(bvh.bounds().is_empty());
        assert_eq!(bvh.stats().triangles, 0);
    }
}

#[test]
fn rays_that_can_hit_nothing() {
    let bvh = Scene::default().with(ceiling(1.0, 1.0)).bvh();
    assert!(!is_open(&bvh, &up(f32::INFINITY)));
    for t_max in [0.0, -0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
        assert!(is_open(&bvh, &up(t_max)), "{t_max}");
    }
    for direction in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 1.0)] {
        assert!(is_open(&bvh, &Ray { direction, ..up(9.0) }), "{direction}");
    }
    for origin in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, 0.0, f32::NEG_INFINITY)] {
        assert!(is_open(&bvh, &Ray { origin, ..up(9.0) }), "{origin}");
    }
}

#[test]
fn the_end_of_a_ray_is_not_part_of_it() {
    let bvh = Scene::default().with(ceiling(1.0, 1.0)).bvh();
    assert!(is_open(&bvh, &up(1.0)));
    assert!(!is_open(&bvh, &up(1f32.next_up())));
    let on_it = Ray { origin: Vec3::Z, ..up(1.0) };
    assert!(is_open(&bvh, &on_it), "nor is its start");
}

#[test]
fn distances_without_sense_under_a_falloff() {
    let bvh = Scene::default().with(ceiling(1.0, 1.0)).bvh();
    for distance in [0.0, -1.0, f32::NAN] {
        assert_eq!(bvh.visibility(&up(9.0), Falloff::Linear, distance), 1.0);
        assert_eq!(bvh.visibility(&up(9.0), Falloff::None, distance), 0.0);
    }
    assert_eq!(bvh.visibility(&up(9.0), Falloff::Linear, 4.0), 0.25);
    assert_eq!(bvh.visibility(&up(9.0), Falloff::Linear, f32::INFINITY), 0.0);
}

#[test]
fn rays_in_the_planes_of_boxes() {
    // Axis-aligned rays that lie exactly in the faces of nodes and leaves.
    let mut scene = Scene::default();
    for i in 0..8 {
        scene = scene.with(quad(Vec3::new(0.0, 0.0, i as f32), Vec3::X, Vec3::Y));
    }
    let bvh = scene.bvh();
    for x in [0.0f32, 0.5, 1.0] {
        for y in [0.25f32, 0.75] {
            let ray = Ray { origin: Vec3::new(x, y, -1.0), ..up(f32::INFINITY) };
            // On the outline, a sheet owns one of two opposite sides.
            let hit = bvh.nearest(&ray);
            assert!(x != 0.5 || hit.is_some_and(|h| h.t == 1.0), "{ray:?}");
        }
    }
    let sides = [0.0f32, 1.0].map(|x| {
        let ray = Ray { origin: Vec3::new(x, 0.3, -1.0), ..up(f32::INFINITY) };
        bvh.nearest(&ray).is_some()
    });
    assert_ne!(sides[0], sides[1]);
    // Within a sheet's plane there is nothing to hit.
    let along = Ray { origin: Vec3::new(-1.0, 0.3, 3.0), direction: Vec3::X, t_max: 9.0 };
    assert!(is_open(&bvh, &along));
}

#[test]
fn coincident_inverted_and_collapsed_triangles() {
    let p = [Vec3::new(-1.0, -1.0, 1.0), Vec3::new(3.0, -1.0, 1.0), Vec3::new(-1.0, 3.0, 1.0)];
    let mut triangles = vec![[0u32, 1, 2]; 500];
    triangles.extend([[0, 2, 1]; 500]);
    triangles.extend([[0, 0, 0]; 100]);
    triangles.extend([[0, 1, 1]; 100]);
    let bvh = Scene::default().with(mesh(p.to_vec(), triangles)).bvh();
    assert_eq!(bvh.stats().triangles, 1000);
    let hit = bvh.nearest(&up(f32::INFINITY)).unwrap();
    assert_eq!((hit.t, hit.triangle), (1.0, 0));
}

#[test]
fn hostile_layouts_build_quickly() {
    let n = 30_000u32;
    let nested = |i: u32| {
        let s = 1.0 + i as f32;
        [Vec3::new(-s, -s, 0.0), Vec3::new(s, -s, 0.0), Vec3::new(0.0, s, 0.0)]
    };
    let same = |_| [Vec3::ZERO, Vec3::X, Vec3::Y];
    let shapes: [&dyn Fn(u32) -> [Vec3; 3]; 2] = [&nested, &same];
    for shape in shapes {
        let positions = (0..n).flat_map(shape).collect();
        let bvh =
            Scene::default().with(mesh(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()));
        let bvh = bvh.bvh();
        assert!(bvh.stats().levels < 60, "{:?}", bvh.stats());
        let ray = Ray { origin: Vec3::new(0.2, 0.2, 1.0), direction: Vec3::NEG_Z, t_max: 2.0 };
        assert_eq!(bvh.nearest(&ray).unwrap().t, 1.0);
    }
}

#[test]
fn transforms_beyond_single_precision_are_refused_by_name() {
    let mut geometry = Geometry::default();
    let m = geometry.add_mesh(ceiling(1e30, 1e30)).unwrap();
    geometry.add_named_instance(m, Affine3A::from_scale(Vec3::splat(1e20)), "balloon".into()).unwrap();
    let error = Bvh::build(Arc::new(geometry)).unwrap_err();
    assert_eq!(error, BvhError::Overflow { instance: 0, name: "balloon".into() });
    assert!(error.to_string().contains("balloon"));
}

#[test]
fn the_largest_and_smallest_coordinates() {
    for scale in [f32::MAX / 4.0, 1e37, 1e-37, f32::MIN_POSITIVE] {
        let bvh = Scene::default().with(ceiling(0.0, scale)).bvh();
        for direction in [Vec3::NEG_Z, Vec3::new(0.0, 0.6, -0.8)] {
            let ray = Ray { origin: Vec3::Z * scale * 0.25, direction, t_max: f32::INFINITY };
            let hit = bvh.nearest(&ray).unwrap_or_else(|| panic!("{scale} {direction}"));
            assert!((hit.t / (0.25 * scale) + 1.0 / direction.z).abs() < 1e-5, "{scale} {hit:?}");
        }
    }
}

/// Numbers that break things.
fn nasty() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -2.0f32..2.0,
        2 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, 0.5]),
        1 => prop::sample::select(vec![
            f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, 1e-38, -1e-20, 1e20,
        ]),
    ]
}

fn nasty_vec() -> impl Strategy<Value = Vec3> {
    [nasty(), nasty(), nasty()].prop_map(Vec3::from_array)
}

proptest! {
    #[test]
    fn nonsense_rays_get_answers_in_range(origin in nasty_vec(), direction in nasty_vec(), t_max in nasty(), distance in nasty()) {
        let bvh = {
            let mut random = Random(20);
            let placed = soup(600, Vec3::ZERO, 1.0, &mut random);
            let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
            Scene::default()
                .with(soup(50, Vec3::ZERO, 1.0, &mut random))
                .with_opacity(placed, Opacity::Constant(0.5), &[Affine3A::IDENTITY, flat])
                .bvh()
        };
        for ray in [Ray { origin, direction, t_max }, Ray { origin, direction: direction.normalize_or_zero(), t_max }] {
            let t = bvh.transmittance(&ray);
            prop_assert!((0.0..=1.0).contains(&t));
            if let Some(hit) = bvh.nearest(&ray) {
                prop_assert!(hit.t > 0.0 && hit.t < t_max && hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.0 + 1e-6);
                prop_assert!(bvh.surface_point(&hit, &ray).position.is_finite());
            }
            for falloff in [Falloff::None, Falloff::Linear, Falloff::Smooth] {
                prop_assert!((0.0..=1.0).contains(&bvh.visibility(&ray, falloff, distance)));
            }
        }
    }

    #[test]
    fn nonsense_triangles_and_transforms_build(points in prop::collection::vec(nasty_vec(), 3..40), columns in prop::array::uniform12(nasty()), copies in 1usize..500) {
        let points: Vec<Vec3> = points.into_iter().filter(|p| p.is_finite()).collect();
        let n = points.len() as u32;
        prop_assume!(n > 0);
        let triangles = (0..copies as u32 * n).map(|i| [i % n, (i * 7 + i / n) % n, (i * 3 + 1) % n]).collect();
        let mut geometry = Geometry::default();
        let mesh = geometry.add_mesh(mesh(points, triangles)).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        let place = Affine3A::from_cols_array(&columns);
        let placed = place.is_finite() && geometry.add_instance(mesh, place).is_ok();
        match Bvh::build(Arc::new(geometry)) {
            Err(error) => prop_assert!(placed, "{error}"),
            Ok(bvh) => {
                bvh.validate().unwrap();
                for direction in [Vec3::Z, Vec3::new(0.6, -0.8, 0.0), Vec3::new(-0.48, 0.6, 0.64)] {
                    let t = bvh.transmittance(&Ray { origin: Vec3::new(0.1, 0.2, -0.3), direction, t_max: 5.0 });
                    prop_assert!((0.0..=1.0).contains(&t));
                }
            }
        }
    }
}
