//! Bundles answer as single rays do, bit for bit, at every level of SIMD.

mod common;

use common::shapes::{ceiling, icosphere, mesh, quad, soup, sphere};
use common::{Random, Scene};
use conray_bvh::{BUNDLE_RAYS, Bvh, Directions};
use conray_core::{Affine3A, Opacity, Ray, Vec3, simd_levels};

/// Compares bundles of all sizes; returns how many rays were blocked.
fn check(bvh: &Bvh, normal: Vec3, origin: Vec3, directions: &[Vec3], t_max: f32) -> usize {
    let single = |direction: &Vec3| {
        let leads_below = normal != Vec3::ZERO && direction.dot(normal) <= 0.0;
        if leads_below { 0.0 } else { bvh.transmittance(&Ray { origin, direction: *direction, t_max }) }
    };
    let expected: Vec<f32> = directions.iter().map(single).collect();
    let mut bundle = Directions::new();
    bundle.extend(directions.iter().copied());
    for level in simd_levels() {
        let mut found = vec![f32::NAN; directions.len()];
        bvh.clone().at_level(level).transmittances(origin, normal, &bundle, t_max, &mut found);
        let wrong = (0..found.len()).find(|&i| found[i].to_bits() != expected[i].to_bits());
        assert_eq!(
            wrong, None,
            "{level:?}: {found:?} instead of {expected:?} from {origin} along {directions:?}, {t_max}"
        );
    }
    expected.iter().filter(|&&open| open < 1.0).count()
}

fn bundle(random: &mut Random, count: usize) -> Vec<Vec3> {
    let some = |random: &mut Random| match random.below(8) {
        0 => [Vec3::X, Vec3::NEG_Y, Vec3::Z][random.below(3)],
        1 => Vec3::new(random.signed(), 0.0, random.signed()).normalize_or(Vec3::X),
        _ => random.direction(),
    };
    (0..count).map(|_| some(random)).collect()
}

#[test]
fn random_soups_at_all_scales_and_far_from_the_origin() {
    let mut random = Random(7);
    for (scale, centre) in [
        (1.0, Vec3::ZERO),
        (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
        (1e-3, Vec3::ZERO),
        (1e6, Vec3::ZERO),
        (1e6, Vec3::splat(-3e6)),
        (1e-12, Vec3::ZERO),
        (1e12, Vec3::ZERO),
        (1e-18, Vec3::ZERO),
        (1e18, Vec3::ZERO),
    ] {
        let bvh = Scene::default().with(soup(400, centre, scale, &mut random)).bvh();
        let mut blocked = 0;
        for round in 0..60 {
            let count = [BUNDLE_RAYS, 1, 16, 17, 40][round % 5];
            let directions = bundle(&mut random, count);
            let origin = centre + 1.2 * scale * random.cube();
            let t_max = if round % 3 == 0 { f32::INFINITY } else { 2.0 * scale * random.unit() };
            blocked += check(&bvh, Vec3::ZERO, origin, &directions, t_max);
        }
        assert!(blocked > 100, "{scale}: {blocked} blocked rays test little");
    }
}

#[test]
fn rays_through_edges_and_corners_of_a_closed_surface_are_all_blocked() {
    let (positions, triangles) = icosphere(2);
    let middles =
        triangles.iter().map(|t| ((positions[t[0] as usize] + positions[t[1] as usize]) / 2.0).normalize());
    let aims: Vec<Vec3> = positions.iter().copied().chain(middles).collect();
    let bvh = Scene::default().with(mesh(positions, triangles)).bvh();
    for aims in aims.chunks(BUNDLE_RAYS) {
        assert_eq!(check(&bvh, Vec3::ZERO, Vec3::ZERO, aims, f32::INFINITY), aims.len());
    }
}

#[test]
fn masks_fractions_and_instances() {
    let mut random = Random(3);
    let place = Affine3A::from_scale_rotation_translation(
        Vec3::new(0.5, 2.0, -1.0),
        conray_core::Quat::from_rotation_y(0.7),
        Vec3::new(0.3, 0.1, -0.4),
    );
    let bvh = Scene::default()
        .with(soup(100, Vec3::ZERO, 1.0, &mut random))
        .with_opacity(soup(100, Vec3::ZERO, 1.0, &mut random), Opacity::Constant(0.3), &[Affine3A::IDENTITY])
        .with_opacity(sphere(3, Vec3::ZERO, 0.5), Opacity::Constant(1.0), &[place, Affine3A::IDENTITY])
        .bvh();
    let mut blocked = 0;
    for _ in 0..60 {
        let origin = random.cube();
        blocked += check(&bvh, Vec3::ZERO, origin, &bundle(&mut random, BUNDLE_RAYS), 1.0);
    }
    assert!(blocked > 500, "{blocked}");
}

#[test]
fn distorted_and_singular_placements() {
    // Beyond some distortion bundles leave a placement to single rays; a flat one cannot be undone at all.
    let mut random = Random(5);
    for scale in [Vec3::new(1.0, 30.0, -0.1), Vec3::new(1e-3, 1e3, 1.0), Vec3::new(0.0, 1.0, 1.0)] {
        let place = |turn: f32| {
            Affine3A::from_rotation_z(turn)
                * Affine3A::from_scale(scale)
                * Affine3A::from_quat(conray_core::Quat::from_rotation_x(0.3))
        };
        let bvh = Scene::default()
            .with_opacity(sphere(3, Vec3::ZERO, 0.5), Opacity::Constant(1.0), &[place(0.0), place(1.0)])
            .bvh();
        let mut blocked = 0;
        for _ in 0..60 {
            let origin = random.cube() * scale.abs().max(Vec3::splat(0.1));
            blocked += check(&bvh, Vec3::ZERO, origin, &bundle(&mut random, BUNDLE_RAYS), f32::INFINITY);
        }
        assert!(blocked > 100, "{scale}: {blocked}");
    }
}

#[test]
fn rays_along_axes_meet_placed_spheres_from_inside() {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [axis, -axis, Vec3::ZERO - axis]).concat();
    for turn in [0.0, 0.7, std::f32::consts::FRAC_PI_2] {
        let place = Affine3A::from_scale_rotation_translation(
            Vec3::new(0.5, 2.0, -1.0),
            conray_core::Quat::from_rotation_y(turn),
            Vec3::new(0.3, 0.1, -0.4),
        );
        let bvh = Scene::default()
            .with_opacity(
                sphere(3, Vec3::ZERO, 0.5),
                Opacity::Constant(1.0),
                &[place, Affine3A::from_translation(9.0 * Vec3::X)],
            )
            .bvh();
        let origin = Vec3::new(0.32, -0.4, -0.43);
        assert_eq!(check(&bvh, Vec3::ZERO, origin, &axes, f32::INFINITY), axes.len(), "turned by {turn}");
    }
}

#[test]
fn slivers_coincident_and_inverted_triangles() {
    let mut random = Random(13);
    let corner = |random: &mut Random| 2.0 * random.cube();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..200u32 {
        let (a, b) = (corner(&mut random), corner(&mut random));
        // A third corner next to the line of the other two.
        positions.extend([a, b, a.lerp(b, random.unit()) + 1e-6 * random.cube()]);
        let c = corner(&mut random);
        positions.extend([a, b, c]);
        let n = 6 * i;
        triangles.extend([
            [n, n + 1, n + 2],
            [n + 3, n + 4, n + 5],
            [n + 3, n + 4, n + 5],
            [n + 5, n + 4, n + 3],
        ]);
    }
    // Aim at corners and at points of edges as well.
    let aims: Vec<Vec3> = (0..6 * 200)
        .map(|i| {
            positions[i]
                .lerp(positions[i / 3 * 3 + (i + 1) % 3], if i % 2 == 0 { 0.0 } else { random.unit() })
        })
        .collect();
    let bvh = Scene::default().with(mesh(positions, triangles)).bvh();
    let mut blocked = 0;
    for (i, aims) in aims.chunks(BUNDLE_RAYS).enumerate() {
        let origin = if i % 3 == 0 { Vec3::ZERO } else { random.cube() };
        let directions: Vec<Vec3> = aims.iter().map(|p| (*p - origin).normalize_or(Vec3::Z)).collect();
        blocked += check(&bvh, Vec3::ZERO, origin, &directions, f32::INFINITY);
    }
    assert!(blocked > 300, "{blocked}");
}

#[test]
fn with_the_surface_known_nothing_above_it_is_lost() {
    // A floor of many triangles under walls and a ceiling: the floor itself is dropped, the rest is not.
    let mut random = Random(11);
    let floor = quad(Vec3::new(-1.0, -1.0, 0.0), 2.0 * Vec3::X, 2.0 * Vec3::Y);
    let wall = quad(Vec3::new(0.5, -1.0, 0.0), 2.0 * Vec3::Y, Vec3::Z);
    let bvh = Scene::default().with(floor).with(wall).with(ceiling(0.8, 0.6)).bvh();
    let mut blocked = 0;
    for _ in 0..200 {
        let (x, y) = (random.signed(), random.signed());
        let point = conray_core::SurfacePoint::new(Vec3::new(x, y, 0.0), Vec3::Z);
        let directions: Vec<Vec3> =
            bundle(&mut random, 64).into_iter().map(|d| Vec3::new(d.x, d.y, d.z.abs())).collect();
        blocked += check(&bvh, Vec3::Z, point.ray_origin(), &directions, 0.9);
    }
    assert!(blocked > 1000, "{blocked}");
}

#[test]
fn nothing_nonsense_and_extremes() {
    let bvh = Scene::default().with(ceiling(1.0, 1.0)).bvh();
    for t_max in [0.0, -1.0, f32::NAN, 1.0, 1f32.next_up(), f32::INFINITY, f32::MIN_POSITIVE] {
        check(&bvh, Vec3::ZERO, Vec3::ZERO, &[Vec3::Z, Vec3::NEG_Z, Vec3::X], t_max);
    }
    for direction in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, 3.0 * Vec3::Z] {
        check(&bvh, Vec3::ZERO, Vec3::ZERO, &[Vec3::Z, direction], 2.0);
    }
    for origin in [Vec3::NAN, Vec3::INFINITY, Vec3::splat(f32::MAX), Vec3::Z] {
        check(&bvh, Vec3::ZERO, origin, &[Vec3::Z, Vec3::NEG_Z], 2.0);
    }
    check(&Scene::default().bvh(), Vec3::ZERO, Vec3::ZERO, &[Vec3::Z], 2.0);
    check(&bvh, Vec3::ZERO, Vec3::ZERO, &[], 2.0);
}
