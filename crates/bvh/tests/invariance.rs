//! What must not matter: order of triangles, threads, rigid motion, scale, flattening; and what must: more triangles.

mod common;

use common::shapes::{mesh, soup};
use common::{Random, Scene};
use conray_bvh::Bvh;
use conray_core::{Affine3A, Falloff, Opacity, Quat, Ray, TriangleMesh, Vec3};
use std::sync::Arc;

fn rays(n: u32, seed: u32) -> Vec<Ray> {
    let mut random = Random(seed);
    (0..n).map(|_| Ray { origin: 1.2 * random.cube(), direction: random.direction(), t_max: 2.0 }).collect()
}

fn answers(bvh: &Bvh, ray: &Ray) -> [f32; 4] {
    [
        bvh.transmittance(ray),
        bvh.visibility(ray, Falloff::Linear, 1.5),
        bvh.visibility(ray, Falloff::Smooth, 3.0),
        bvh.nearest(ray).map_or(-1.0, |hit| hit.t),
    ]
}

/// Opaque and half-transparent triangles, each of them twice, in the given order.
fn scene(order: impl Fn(usize) -> usize) -> Bvh {
    let mesh_of = |seed: u32| {
        let soup = soup(500, Vec3::ZERO, 1.0, &mut Random(seed));
        let twice: Vec<[u32; 3]> = soup.triangles().iter().flat_map(|&t| [t, t]).collect();
        let triangles = (0..1000).map(|i| twice[order(i)]).collect();
        mesh(soup.positions().to_vec(), triangles)
    };
    Scene::default()
        .with_opacity(mesh_of(1), Opacity::Constant(1.0), &[Affine3A::IDENTITY])
        .with_opacity(mesh_of(2), Opacity::Constant(0.3), &[Affine3A::IDENTITY])
        .bvh()
}

#[test]
fn the_order_of_triangles() {
    let orders: [&dyn Fn(usize) -> usize; 3] = [&|i| i, &|i| 999 - i, &|i| i * 387 % 1000];
    let [a, b, c] = orders.map(scene);
    let mut partial = 0;
    for ray in rays(3000, 3) {
        let expected = answers(&a, &ray);
        assert_eq!(expected, answers(&b, &ray), "{ray:?}");
        assert_eq!(expected, answers(&c, &ray), "{ray:?}");
        partial += u32::from(expected[0] > 0.0 && expected[0] < 1.0);
    }
    assert!(partial > 300, "{partial}");
}

#[test]
fn ties_go_to_the_lowest_numbers() {
    let bvh = scene(|i| i);
    let mut hits = 0;
    for hit in rays(1000, 4).iter().filter_map(|ray| bvh.nearest(ray)) {
        assert_eq!(hit.triangle % 2, 0, "of two equal triangles the first");
        hits += 1;
    }
    assert!(hits > 100);
    // Of two equal instances the first.
    let one = soup(600, Vec3::ZERO, 1.0, &mut Random(5));
    let bvh = Scene::default().with_opacity(one, Opacity::Constant(1.0), &[Affine3A::IDENTITY; 3]).bvh();
    assert!(rays(1000, 4).iter().filter_map(|ray| bvh.nearest(ray)).all(|hit| hit.instance == 0));
}

#[test]
fn the_number_of_threads() {
    let geometry = {
        let flat = soup(9000, Vec3::ZERO, 1.0, &mut Random(6));
        let placed = soup(5000, Vec3::ZERO, 1.0, &mut Random(7));
        let places = [Affine3A::IDENTITY, Affine3A::from_scale(Vec3::splat(0.5))];
        Scene::default().with(flat).with_opacity(placed, Opacity::Constant(0.5), &places).0
    };
    let geometry = Arc::new(geometry);
    let dump = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let bvh = pool.install(|| Bvh::build(geometry.clone())).unwrap();
        // All of the hierarchy, to the last bit, but not the geometry.
        let text = format!("{bvh:?}");
        text[text.find("flat:").unwrap()..].to_owned()
    };
    let one = dump(1);
    assert!(one.len() > 1_000_000);
    for threads in [2, 3, 7] {
        assert!(dump(threads) == one, "{threads} threads build another tree");
    }
}

fn moved(mesh_in: &TriangleMesh, place: &Affine3A) -> TriangleMesh {
    let positions = mesh_in.positions().iter().map(|&p| place.transform_point3(p)).collect();
    mesh(positions, mesh_in.triangles().to_vec())
}

#[test]
fn rigid_motion_and_scale() {
    let shape = soup(1000, Vec3::ZERO, 1.0, &mut Random(8));
    let here = Scene::default().with(shape.clone()).bvh();
    for scale in [1.0f32, 1e-6, 1e6] {
        let turn = Quat::from_axis_angle(Vec3::new(0.48, 0.6, 0.64), 2.0);
        let place = Affine3A::from_scale_rotation_translation(
            Vec3::splat(scale),
            turn,
            scale * Vec3::new(3.0, -2.0, 5.0),
        );
        let there = Scene::default().with(moved(&shape, &place)).bvh();
        let mut differ = 0;
        for ray in rays(3000, 9) {
            let direction = turn * ray.direction;
            let t_max = scale * ray.t_max;
            let twin = Ray { origin: place.transform_point3(ray.origin), direction, t_max };
            let fades = [(&here, &ray, 1.5), (&there, &twin, 1.5 * scale)];
            let [a, b] = fades.map(|(bvh, ray, distance)| bvh.visibility(ray, Falloff::Linear, distance));
            differ += u32::from((a - b).abs() > 1e-4);
        }
        // Only rays along an outline may change their minds.
        assert!(differ <= 6, "{differ} at scale {scale}");
    }
}

#[test]
fn flattened_or_instanced() {
    let shape = soup(600, Vec3::ZERO, 1.0, &mut Random(10));
    let mut random = Random(11);
    let places: Vec<Affine3A> = (0..4)
        .map(|_| {
            let turn = Quat::from_axis_angle(random.direction(), 2.0);
            Affine3A::from_scale_rotation_translation(random.cube(), turn, 0.3 * random.cube())
        })
        .collect();
    let instanced = Scene::default().with_opacity(shape.clone(), Opacity::Constant(0.5), &places).bvh();
    let copies =
        |scene: Scene, place: &Affine3A| scene.with_opacity(shape.clone(), Opacity::Constant(0.5), &[*place]);
    let flattened = places.iter().fold(Scene::default(), copies).bvh();
    assert_eq!((instanced.stats().instances, flattened.stats().instances), (4, 0));
    let mut hits = 0;
    for ray in rays(5000, 12) {
        assert_eq!(answers(&instanced, &ray), answers(&flattened, &ray), "{ray:?}");
        assert_eq!(instanced.nearest(&ray), flattened.nearest(&ray));
        hits += u32::from(flattened.nearest(&ray).is_some());
    }
    assert!(hits > 500);
}

#[test]
fn more_triangles_never_open_and_longer_rays_never_do() {
    let all = soup(600, Vec3::ZERO, 1.0, &mut Random(13));
    let some = mesh(all.positions().to_vec(), all.triangles()[..300].to_vec());
    for opacity in [1.0, 0.4] {
        let build = |mesh: &TriangleMesh| {
            Scene::default()
                .with_opacity(mesh.clone(), Opacity::Constant(opacity), &[Affine3A::IDENTITY])
                .bvh()
        };
        let (all, some) = (build(&all), build(&some));
        let mut closed = 0;
        for ray in rays(3000, 14) {
            let longer = Ray { t_max: 2.0 * ray.t_max, ..ray };
            assert!(all.transmittance(&ray) <= some.transmittance(&ray));
            assert!(all.transmittance(&longer) <= all.transmittance(&ray));
            let fade = |bvh: &Bvh, distance| bvh.visibility(&longer, Falloff::Smooth, distance);
            assert!(fade(&all, 1.0) <= fade(&some, 1.0) + 1e-6);
            assert!(fade(&all, 1.5) <= fade(&all, 1.0) + 1e-6);
            closed += u32::from(all.transmittance(&ray) < some.transmittance(&ray));
        }
        assert!(closed > 100);
    }
}
