//! Rays that leave a surface do not meet it again, and walls right beside it are seen nevertheless.

mod common;

use common::shapes::{cube, mesh, quad};
use common::{Random, Scene};
use conray_bvh::{Bvh, Hit};
use conray_core::{Affine3A, Frame, Opacity, Quat, Ray, SurfacePoint, Vec2, Vec3, cosine_hemisphere};

const FAR_AWAY: Vec3 = Vec3::new(148_376.0, 1234.0, -223_423.0);

/// A point of a triangle, on a side chosen at random, and away from the outline by a share `inset` of the way.
fn point_on(bvh: &Bvh, instance: u32, triangle: u32, inset: f32, random: &mut Random) -> SurfacePoint {
    let (u, v) = random.barycentric();
    let [u, v] = [u, v].map(|b| b + inset * (1.0 / 3.0 - b));
    let hit = Hit { t: 1.0, instance, triangle, u, v };
    let viewer = Ray { origin: Vec3::ZERO, direction: random.direction(), t_max: f32::INFINITY };
    bvh.surface_point(&hit, &viewer)
}

/// A direction above the surface: at random, grazing, or the normal itself.
fn upward(point: &SurfacePoint, random: &mut Random) -> Vec3 {
    let frame = Frame::from_normal(point.geometric_normal);
    match random.below(8) {
        0 => point.geometric_normal,
        1 | 2 => {
            let angle = std::f32::consts::TAU * random.unit();
            let tilt = 10f32.powf(-8.0 * random.unit());
            let d = frame.to_world(Vec3::new(angle.cos(), angle.sin(), tilt)).normalize();
            if d.dot(point.geometric_normal) >= 0.0 { d } else { point.geometric_normal }
        }
        _ => frame.to_world(cosine_hemisphere(Vec2::new(random.unit(), random.unit()))),
    }
}

/// Of some rays above some triangle of the scene, those that are blocked: exactly 1 is asked for.
fn blocked(bvh: &Bvh, points: u32, least_cosine: f32, random: &mut Random) -> u32 {
    let mut blocked = 0;
    for _ in 0..points {
        let instance = random.below(bvh.geometry().instances().len()) as u32;
        let triangles = bvh.geometry().mesh_of(instance as usize).triangles().len();
        let point = point_on(bvh, instance, random.below(triangles) as u32, 0.0, random);
        assert!(point.is_valid(), "{point:?}");
        let origin = point.ray_origin();
        for _ in 0..8 {
            let direction = upward(&point, random);
            if direction.dot(point.geometric_normal) < least_cosine {
                continue;
            }
            let ray = Ray { origin, direction, t_max: f32::INFINITY };
            blocked += u32::from(bvh.transmittance(&ray) != 1.0);
        }
    }
    blocked
}

#[test]
fn single_triangles_of_every_size_and_place() {
    let mut random = Random(11);
    for i in 0..3000 {
        let scale = 10f32.powf(6.0 * random.signed());
        let offset = [Vec3::ZERO, FAR_AWAY, scale * random.cube(), 1e3 * scale * random.cube()][i % 4];
        let mut corner = || offset + scale * random.cube();
        let corners = vec![corner(), corner(), corner()];
        let bvh = Scene::default().with(mesh(corners.clone(), vec![[0, 1, 2]])).bvh();
        if bvh.stats().triangles == 1 {
            assert_eq!(blocked(&bvh, 4, 0.0, &mut random), 0, "{corners:?}");
        }
    }
}

#[test]
fn needles_and_slivers() {
    let mut random = Random(12);
    for _ in 0..2000 {
        let (a, b) = (random.cube(), random.cube());
        let thin = 10f32.powf(-5.0 * random.unit());
        let c = a + (b - a) * random.unit() + thin * random.cube();
        let bvh = Scene::default().with(mesh(vec![a, b, c], vec![[0, 1, 2]])).bvh();
        assert_eq!(blocked(&bvh, 4, 0.0, &mut random), 0, "{a} {b} {c}");
    }
}

#[test]
fn placed_triangles() {
    let mut random = Random(13);
    // Enough triangles not to be flattened; each is placed apart, so it is a scene of its own.
    let (positions, triangles) = cube();
    for i in 0..60 {
        let scale = 10f32.powf(4.0 * random.signed()) * (random.cube() + 1.5);
        let mirror = if i % 2 == 0 { Vec3::ONE } else { Vec3::new(1.0, -1.0, 1.0) };
        let turn = Quat::from_axis_angle(random.direction(), 3.0 * random.signed());
        let at = [Vec3::ZERO, 1e3 * scale.max_element() * random.cube()][i % 2];
        let place = |at: Vec3| Affine3A::from_scale_rotation_translation(scale * mirror, turn, at);
        // The cube's faces, repeated: hits on coincident copies count as self-hits, too.
        let copies = (0..50).flat_map(|_| triangles.clone()).collect();
        let apart = at + Vec3::splat(1e6 * scale.max_element());
        let bvh = Scene::default()
            .with_opacity(mesh(positions.clone(), copies), Opacity::Constant(1.0), &[place(at), place(apart)])
            .bvh();
        assert_eq!(bvh.stats().instances, 2);
        let (mut outside, mut inside) = (0, 0);
        for triangle in 0..60 {
            let point = point_on(&bvh, 0, triangle, 0.01, &mut random);
            let direction = upward(&point, &mut random);
            if direction.dot(point.geometric_normal) < 1e-3 {
                continue;
            }
            let ray = Ray { origin: point.ray_origin(), direction, t_max: 10.0 * scale.max_element() };
            let open = bvh.transmittance(&ray);
            if (point.position - at).dot(point.geometric_normal) > 0.0 {
                assert_eq!(open, 1.0, "{point:?} {direction} {scale}");
                outside += 1;
            } else {
                assert_eq!(open, 0.0, "{point:?} {direction} {scale}");
                inside += 1;
            }
        }
        assert!(outside > 5 && inside > 5);
    }
}

#[test]
fn convex_boxes_from_outside_and_inside() {
    let mut random = Random(14);
    for (centre, scale) in [(Vec3::ZERO, 1.0f32), (Vec3::ZERO, 1e-6), (Vec3::ZERO, 1e6), (FAR_AWAY, 1e4)] {
        let turn = Quat::from_axis_angle(random.direction(), 1.0);
        let (positions, triangles) = cube();
        let positions: Vec<Vec3> = positions.iter().map(|&p| centre + scale * (turn * p)).collect();
        let bvh = Scene::default().with(mesh(positions, triangles)).bvh();
        let (mut outside, mut inside) = (0, 0);
        for i in 0..4000 {
            // On an edge of the box a rounded point may be outside although its own face looks inward.
            let point = point_on(&bvh, 0, i % 12, 0.01, &mut random);
            let direction = upward(&point, &mut random);
            // Rounded corners make faces of two triangles convex or concave by some ulps; they may shade so far.
            if direction.dot(point.geometric_normal) < 1e-3 {
                continue;
            }
            let open =
                bvh.transmittance(&Ray { origin: point.ray_origin(), direction, t_max: f32::INFINITY });
            if (point.position - centre).dot(point.geometric_normal) > 0.0 {
                assert_eq!(open, 1.0, "{point:?} {direction}");
                outside += 1;
            } else {
                assert_eq!(open, 0.0, "{point:?} {direction}");
                inside += 1;
            }
        }
        assert!(outside > 1000 && inside > 1000);
    }
}

#[test]
fn without_the_offset_surfaces_do_hit_themselves() {
    // The negative control: points moved to the wrong side by as little as the bound are blocked.
    let mut random = Random(15);
    let mut blocked = 0;
    for _ in 0..500 {
        let corners = vec![random.cube(), random.cube(), random.cube()];
        let bvh = Scene::default().with(mesh(corners, vec![[0, 1, 2]])).bvh();
        let hit = Hit { t: 1.0, instance: 0, triangle: 0, u: 0.3, v: 0.3 };
        let viewer = Ray { origin: Vec3::ZERO, direction: random.direction(), t_max: 1.0 };
        let point = bvh.surface_point(&hit, &viewer);
        let origin = 2.0 * point.position - point.ray_origin();
        let ray = Ray { origin, direction: point.geometric_normal, t_max: f32::INFINITY };
        blocked += u32::from(bvh.transmittance(&ray) == 0.0);
    }
    assert_eq!(blocked, 500);
}

#[test]
fn a_wall_a_few_bounds_away_hides_all_behind_it() {
    let mut random = Random(16);
    for (at, scale) in [(Vec3::ZERO, 1.0f32), (Vec3::ZERO, 1e-5), (Vec3::ZERO, 1e5), (FAR_AWAY, 1e4)] {
        let turn = Quat::from_axis_angle(random.direction(), 2.0 * random.signed());
        let place = |p: Vec3| at + scale * (turn * p);
        let edge = |v: Vec3| scale * (turn * v);
        let floor = quad(place(Vec3::new(-1.0, -1.0, 0.0)), edge(2.0 * Vec3::X), edge(2.0 * Vec3::Y));
        // The wall runs through the floor at x = 0.
        let wall = quad(place(Vec3::new(0.0, -50.0, -50.0)), edge(100.0 * Vec3::Y), edge(100.0 * Vec3::Z));
        let bvh = Scene::default().with(floor).with(wall).bvh();
        let (x, up) = (turn * Vec3::X, turn * Vec3::Z);
        let mut seen = 0;
        for _ in 0..2000 {
            let bound = SurfacePoint::new(place(Vec3::X), up)
                .position_error
                .max(conray_bvh::position_error(&bvh.world_corners(0, 0), place(Vec3::X)));
            let gap = bound * (4.0 + 4.0 * random.unit());
            let foot = place(Vec3::Y * 0.9 * random.signed()) - gap * x;
            let mut point = SurfacePoint::new(foot, up);
            point.position_error = bound;
            let direction = upward(&point, &mut random);
            // Any ray towards the wall that rises less than 49 units until it gets there meets it.
            if direction.dot(x) > 1e-3 {
                let ray = Ray { origin: point.ray_origin(), direction, t_max: f32::INFINITY };
                assert_eq!(bvh.transmittance(&ray), 0.0, "{ray:?} {gap}");
                seen += 1;
            }
        }
        assert!(seen > 500);
    }
}
