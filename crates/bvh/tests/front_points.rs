//! Points at places of a triangle, on its front side.

mod common;

use common::shapes::{mesh, quad};
use common::{Random, Scene};
use conray_core::{Affine3A, Opacity, Ray, Vec3};

/// A triangle in the plane z = 0 with vertex normals.
fn triangle(normal: Vec3) -> conray_core::TriangleMesh {
    mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).with_normals(vec![normal; 3]).unwrap()
}

fn front(normal: Vec3, scale: Vec3) -> [Vec3; 2] {
    let bvh = Scene::default()
        .with_opacity(triangle(normal), Opacity::Constant(1.0), &[Affine3A::from_scale(scale)])
        .bvh();
    let point = bvh.front_point(0, 0, [0.25, 0.25]);
    assert!(point.is_valid());
    [point.geometric_normal, point.shading_normal]
}

#[test]
fn the_front_is_the_side_of_the_winding_mirrored_or_not() {
    let tilted = Vec3::new(0.6, 0.0, 0.8);
    assert_eq!(front(tilted, Vec3::ONE), [Vec3::Z, tilted]);
    // Mirrored in x: the corners go round the other way, and the front stays where it was.
    assert_eq!(front(tilted, Vec3::new(-1.0, 1.0, 1.0)), [Vec3::Z, Vec3::new(-0.6, 0.0, 0.8)]);
    assert_eq!(front(tilted, Vec3::new(1.0, 1.0, -1.0)), [Vec3::NEG_Z, Vec3::new(0.6, 0.0, -0.8)]);
    assert_eq!(front(tilted, -Vec3::ONE), [Vec3::NEG_Z, -tilted]);
}

#[test]
fn vertex_normals_against_the_winding_say_which_side_is_the_front() {
    let under = Vec3::new(0.6, 0.0, -0.8);
    assert_eq!(front(under, Vec3::ONE), [Vec3::NEG_Z, under]);
    assert_eq!(front(Vec3::NAN, Vec3::ONE), [Vec3::Z, Vec3::Z]);
    assert_eq!(front(Vec3::ZERO, Vec3::ONE), [Vec3::Z, Vec3::Z]);
}

#[test]
fn triangles_without_area_give_no_valid_point() {
    let flat = mesh(vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X], vec![[0, 1, 2]]);
    let bvh = Scene::default().with(flat).bvh();
    assert!(!bvh.front_point(0, 0, [0.25, 0.25]).is_valid());
}

#[test]
fn points_on_the_rim_stay_on_the_seen_side_of_what_meets_it() {
    let mut random = Random(7);
    let mut behind = 0;
    for at in [0.0f32, 0.37, 12.3, -417.9] {
        // A floor that ends at a wall, its corners on the wall's own plane.
        let floor = quad(Vec3::new(at, -3.1, 0.0), 4.0 * Vec3::X, 6.0 * Vec3::Y);
        let wall = quad(Vec3::new(at, -4.3, -1.0), 8.0 * Vec3::Y, 2.5 * Vec3::Z);
        let bvh = Scene::default().with(floor).with(wall).bvh();
        for triangle in 0..2 {
            for _ in 0..500 {
                let share = random.unit();
                let rims =
                    [[share, 0.0], [0.0, share], [share, 1.0 - share], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
                for weights in rims {
                    let point = bvh.front_point(0, triangle, weights);
                    assert!(point.is_valid() && point.geometric_normal == Vec3::Z);
                    let into = Vec3::new(-0.8, 0.0, 0.6);
                    let open = |origin| bvh.transmittance(&Ray { origin, direction: into, t_max: 0.5 });
                    let near = point.position.x - at < 1e-3;
                    assert!(!near || open(point.ray_origin()) == 0.0, "{point:?}");
                    let corners = bvh.world_corners(0, triangle);
                    let plain = conray_bvh::triangle_point(&corners, weights[0], weights[1]);
                    let plain = conray_core::SurfacePoint::new(plain, Vec3::Z);
                    behind += usize::from(near && open(plain.ray_origin()) > 0.0);
                }
            }
        }
    }
    assert!(behind > 0, "points as they are do see through: the test can fail");
}

#[test]
fn a_ray_from_below_the_front_meets_the_back() {
    let normals = [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.6, 0.0, -0.8), Vec3::NAN];
    let scales = [Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, -1.0), -Vec3::ONE];
    for (normal, scale) in normals.iter().flat_map(|n| scales.map(|scale| (*n, scale))) {
        let placement = Affine3A::from_scale(scale);
        let bvh = Scene::default().with_opacity(triangle(normal), Opacity::Constant(1.0), &[placement]).bvh();
        let point = bvh.front_point(0, 0, [0.25, 0.25]);
        for side in [1.0, -1.0] {
            let direction = -side * point.geometric_normal;
            let ray = Ray { origin: point.position - direction, direction, t_max: 2.0 };
            let hit = bvh.nearest(&ray).unwrap();
            assert_eq!(bvh.is_back(&hit, &ray), side < 0.0, "{normal} {scale}");
        }
    }
}
