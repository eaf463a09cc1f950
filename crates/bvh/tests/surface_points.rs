//! Surface points: position, normals and sides, under all kinds of placements.

mod common;

use common::shapes::{mesh, quad};
use common::{Random, Scene};
use conray_core::{Affine3A, Mat3A, Opacity, Quat, Ray, SurfacePoint, Vec3};
use proptest::prelude::*;

/// A triangle in the plane z = 0, its vertex normals tilted towards x.
fn tilted() -> conray_core::TriangleMesh {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    mesh(corners, vec![[0, 1, 2]]).with_normals(vec![Vec3::new(0.6, 0.0, 0.8); 3]).unwrap()
}

fn down(x: f32, y: f32) -> Ray {
    Ray { origin: Vec3::new(x, y, 1.0), direction: Vec3::NEG_Z, t_max: f32::INFINITY }
}

#[test]
fn both_sides_of_a_triangle() {
    let bvh = Scene::default().with(tilted()).bvh();
    let above = down(0.25, 0.5);
    let below = Ray { origin: Vec3::new(0.25, 0.5, -2.0), direction: Vec3::Z, t_max: 9.0 };
    let top = bvh.nearest(&above).unwrap();
    assert_eq!((top.t, top.instance, top.triangle, top.u, top.v), (1.0, 0, 0, 0.25, 0.5));
    let p = bvh.surface_point(&top, &above);
    let aside = p.position - Vec3::new(0.25, 0.5, 0.0);
    assert!(aside.abs().max_element() <= p.position_error && p.position_error < 1e-5, "{p:?}");
    assert!(aside.z > 0.0, "drawn back towards the ray's origin");
    assert_eq!((p.geometric_normal, p.shading_normal), (Vec3::Z, Vec3::new(0.6, 0.0, 0.8)));
    assert_eq!((p.footprint, p.id), (0.0, 0));
    let bottom = bvh.nearest(&below).unwrap();
    let p = bvh.surface_point(&bottom, &below);
    assert_eq!(bottom.t, 2.0);
    assert_eq!((p.geometric_normal, p.shading_normal), (Vec3::NEG_Z, Vec3::new(-0.6, 0.0, -0.8)));
}

#[test]
fn careless_normals() {
    let shaded = |normals: [Vec3; 3]| {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mesh = mesh(corners, vec![[0, 1, 2]]).with_normals(normals.to_vec()).unwrap();
        let bvh = Scene::default().with(mesh).bvh();
        bvh.surface_point(&bvh.nearest(&down(0.25, 0.25)).unwrap(), &down(0.25, 0.25)).shading_normal
    };
    // Against the winding: the side of the ray counts. In the surface, cancelling, NaN: the surface's own.
    assert_eq!(shaded([Vec3::new(0.6, 0.0, -0.8); 3]), Vec3::new(-0.6, 0.0, 0.8));
    assert_eq!(shaded([Vec3::X; 3]), Vec3::Z);
    assert_eq!(shaded([Vec3::ZERO; 3]), Vec3::Z);
    assert_eq!(shaded([Vec3::NAN; 3]), Vec3::Z);
}

#[test]
fn normals_of_scaled_and_mirrored_placements() {
    // A plane that rises by 1 over 1, squeezed to half its width: it rises by 2 over 1.
    let slope = vec![Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::Y];
    let n = Vec3::new(-1.0, 0.0, 1.0).normalize();
    let mesh = mesh(slope, vec![[0, 1, 2]]).with_normals(vec![n; 3]).unwrap();
    for (scale, expected) in [
        (Vec3::new(0.5, 1.0, 1.0), Vec3::new(-2.0, 0.0, 1.0)),
        (Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, 0.0, 1.0)),
        (Vec3::new(1.0, 1.0, -1.0), Vec3::new(1.0, 0.0, 1.0)),
    ] {
        let place = Affine3A::from_scale(scale);
        let bvh = Scene::default().with_opacity(mesh.clone(), Opacity::Constant(1.0), &[place]).bvh();
        let inside = place.transform_point3(Vec3::new(0.25, 0.25, 0.25));
        let ray = Ray { origin: inside + 2.0 * Vec3::Z, direction: Vec3::NEG_Z, t_max: 9.0 };
        let p = bvh.surface_point(&bvh.nearest(&ray).unwrap(), &ray);
        assert!((p.geometric_normal - expected.normalize()).length() < 1e-6, "{scale} {p:?}");
        assert!((p.shading_normal - expected.normalize()).length() < 1e-6, "{scale} {p:?}");
    }
}

proptest! {
    #[test]
    fn points_lie_within_their_bound_and_normals_face_the_ray(seed in any::<u32>(), scale in -4f32..4.0) {
        let mut random = Random(seed);
        let scale = 10f32.powf(scale);
        let matrix = Mat3A::from_quat(Quat::from_axis_angle(random.direction(), 1.0))
            * Mat3A::from_diagonal(scale * (random.cube() + 1.5));
        let place = Affine3A::from_mat3_translation(matrix.into(), 10.0 * scale * random.cube());
        let corners = vec![random.cube(), random.cube(), random.cube()];
        let normals = (0..3).map(|_| random.direction()).collect();
        let mesh = mesh(corners, vec![[0, 1, 2]]).with_normals(normals).unwrap();
        let bvh = Scene::default().with_opacity(mesh, Opacity::Constant(1.0), &[place]).bvh();
        let corners = bvh.world_corners(0, 0);
        let target = (corners[0] + corners[1] + corners[2]) / 3.0;
        let origin = target + scale * random.cube();
        let ray = Ray { origin, direction: (target - origin).normalize(), t_max: f32::INFINITY };
        let Some(hit) = bvh.nearest(&ray) else { return Ok(()) };
        let p = bvh.surface_point(&hit, &ray);
        prop_assert!(p.is_valid());
        prop_assert!(p.geometric_normal.dot(ray.direction) <= 0.0);
        prop_assert!(p.geometric_normal.dot(p.shading_normal) >= -1e-6);
        // The plane of the corners passes within the error on every axis.
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let n = (b - a).cross(c - a).normalize();
        let height = (p.position.as_dvec3() - a).dot(n).abs();
        let reach = f64::from(p.position_error) * n.abs().element_sum();
        prop_assert!(height <= reach, "{height} {reach}");
        // And where the ray says it is, as far as the ray's own rounding lets it.
        let along = (ray.origin + hit.t * ray.direction - p.position).length();
        prop_assert!(along <= 1e-5 * (scale + target.length() + origin.length()), "{along}");
    }
}

/// A floor, and a wall that stands on it in the plane x = `at` without going below it.
fn wall_on_floor(at: f32) -> conray_bvh::Bvh {
    let floor = quad(Vec3::new(at - 2.0, -3.1, 0.0), 4.0 * Vec3::X, 6.0 * Vec3::Y);
    let wall = quad(Vec3::new(at, -2.3, 0.0), 5.0 * Vec3::Y, 1.5 * Vec3::Z);
    Scene::default().with(floor).with(wall).bvh()
}

#[test]
fn points_where_a_wall_meets_the_floor_stay_on_the_seen_side() {
    let (mut random, mut met, mut behind) = (Random(5), 0, 0);
    for at in [0.0f32, 0.37, 12.3, -417.9] {
        let bvh = wall_on_floor(at);
        for _ in 0..2000 {
            // Rays from in front of the wall, aimed at the edge itself.
            let foot = Vec3::new(at, 2.0 * random.signed(), 0.0);
            let eye = foot + Vec3::new(0.5 + random.unit(), random.signed(), 0.3 + random.unit());
            let ray = Ray { origin: eye, direction: (foot - eye).normalize(), t_max: f32::INFINITY };
            let Some(hit) = bvh.nearest(&ray) else { continue };
            let point = bvh.surface_point(&hit, &ray);
            if point.geometric_normal.z < 0.9 {
                continue;
            }
            met += 1;
            // From the floor, a ray into the wall is closed, unless it starts behind the wall.
            let into = Vec3::new(-0.8, 0.0, 0.6);
            let open = |origin| bvh.transmittance(&Ray { origin, direction: into, t_max: 1.0 });
            assert_eq!(open(point.ray_origin()), 0.0, "{point:?}");
            let corners = bvh.world_corners(hit.instance, hit.triangle);
            let plain = SurfacePoint::new(conray_bvh::triangle_point(&corners, hit.u, hit.v), Vec3::Z);
            behind += usize::from(open(plain.ray_origin()) > 0.0);
        }
    }
    assert!(met > 1000, "{met} hits of the floor");
    assert!(behind > 0, "points that are not drawn back must fail here now and then");
}
