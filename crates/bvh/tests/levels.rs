//! Single rays: the same bits at every level of SIMD.

mod common;

use common::shapes::{mesh, soup, sphere};
use common::{Random, Scene};
use conray_bvh::Bvh;
use conray_core::{Affine3A, Falloff, Opacity, Quat, Ray, Vec3, simd_levels};

/// All that single rays can be asked, as bits.
fn answers(bvh: &Bvh, ray: &Ray) -> [u32; 8] {
    let hit = bvh.nearest(ray);
    let of_hit = |f: fn(&conray_bvh::Hit) -> u32| hit.as_ref().map_or(u32::MAX, f);
    [
        bvh.transmittance(ray).to_bits(),
        bvh.visibility(ray, Falloff::Linear, 1.5).to_bits(),
        bvh.visibility(ray, Falloff::Smooth, f32::INFINITY).to_bits(),
        of_hit(|h| h.t.to_bits()),
        of_hit(|h| h.u.to_bits()),
        of_hit(|h| h.v.to_bits()),
        of_hit(|h| h.instance),
        of_hit(|h| h.triangle),
    ]
}

fn mixed(random: &mut Random, scale: f32, centre: Vec3) -> Bvh {
    let place = |turn: f32| {
        Affine3A::from_scale_rotation_translation(
            Vec3::new(0.5, 1.0, -1.0),
            Quat::from_rotation_y(turn),
            centre + scale * Vec3::new(0.3, 0.1, -0.4),
        )
    };
    let ball = sphere(3, Vec3::ZERO, 0.4 * scale);
    Scene::default()
        .with(soup(500, centre, scale, random))
        .with_opacity(soup(200, centre, scale, random), Opacity::Constant(0.3), &[Affine3A::IDENTITY])
        .with_opacity(ball, Opacity::Constant(1.0), &[place(0.7), place(2.0)])
        .bvh()
}

#[test]
fn random_rays_everywhere() {
    let mut random = Random(21);
    for (scale, centre) in [
        (1.0, Vec3::ZERO),
        (1e-3, Vec3::ZERO),
        (1e6, Vec3::ZERO),
        (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
        (1e-12, Vec3::ZERO),
        (1e12, Vec3::ZERO),
    ] {
        let bvh = mixed(&mut random, scale, centre);
        let rays: Vec<Ray> = (0..300)
            .map(|i| Ray {
                origin: centre + 1.2 * scale * random.cube(),
                direction: if i % 9 == 0 { [Vec3::X, Vec3::NEG_Y][i % 2] } else { random.direction() },
                t_max: if i % 4 == 0 { f32::INFINITY } else { 2.0 * scale * random.unit() },
            })
            .collect();
        let expected: Vec<_> = rays.iter().map(|ray| answers(&bvh, ray)).collect();
        let hits = expected.iter().filter(|a| a[7] != u32::MAX).count();
        assert!(hits > 40, "{scale}: {hits} hits test little");
        for level in simd_levels() {
            let bvh = bvh.clone().at_level(level);
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(answers(&bvh, ray), *expected, "{level:?} {ray:?}");
            }
        }
    }
}

#[test]
fn nonsense_is_nonsense_at_every_level() {
    let mut random = Random(22);
    let bvh = mixed(&mut random, 1.0, Vec3::ZERO);
    let flat = Scene::default().with(mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]])).bvh();
    let odd = [Vec3::NAN, Vec3::INFINITY, Vec3::ZERO, Vec3::new(f32::NAN, 1.0, 0.0), Vec3::splat(f32::MAX)];
    for bvh in [&bvh, &flat, &Scene::default().bvh()] {
        for level in simd_levels() {
            let here = bvh.clone().at_level(level);
            for (i, &a) in odd.iter().enumerate() {
                for t_max in [1.0, 0.0, -1.0, f32::NAN, f32::INFINITY] {
                    for ray in [
                        Ray { origin: a, direction: Vec3::Z, t_max },
                        Ray { origin: Vec3::ZERO, direction: a, t_max },
                        Ray { origin: a, direction: odd[(i + 1) % odd.len()], t_max },
                        // In the plane of the triangle, along an edge and through a corner.
                        Ray { origin: Vec3::NEG_X, direction: Vec3::X, t_max },
                    ] {
                        assert_eq!(answers(&here, &ray), answers(bvh, &ray), "{level:?} {ray:?}");
                    }
                }
            }
        }
    }
}
