//! Rays that pass surfaces from behind, by every query and at every level.

mod common;

use common::Random;
use common::shapes::quad;
use conray_bvh::{Bvh, Directions};
use conray_core::{Backs, Falloff, Geometry, Material, Ray, Vec3, simd_levels};
use std::sync::Arc;

/// A front at z = 1 and one at z = 2 that face down, and one at z = 3 that faces up and is seen from both sides if so wanted.
fn geometry(both: bool) -> Geometry {
    let mut geometry = Geometry::default();
    geometry.add_material(Material::default());
    geometry.add_material(Material { double_sided: both, ..Material::default() });
    for (z, down, material) in [(1.0, false, 0), (2.0, true, 0), (3.0, false, 1)] {
        let (u, v) = if down { (Vec3::Y, Vec3::X) } else { (Vec3::X, Vec3::Y) };
        let mesh = quad(Vec3::new(-5.0, -5.0, z), 10.0 * u, 10.0 * v).with_material(material);
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, conray_core::Affine3A::IDENTITY).unwrap();
    }
    geometry
}

/// What rays straight up pass: by one query after the other, and the height of the nearest hit.
fn through(bvh: &Bvh, at: Vec3) -> ([f32; 3], Option<f32>) {
    let ray = Ray { origin: at, direction: Vec3::Z, t_max: 10.0 };
    let mut directions = Directions::new();
    (0..40).for_each(|_| directions.push(Vec3::Z));
    let mut out = [f32::NAN; 40];
    bvh.transmittances(at, Vec3::Z, &directions, 10.0, &mut out);
    assert!(out.iter().all(|value| *value == out[0]));
    let faded = bvh.visibility(&ray, Falloff::Linear, 10.0);
    ([bvh.transmittance(&ray), out[0], faded], bvh.nearest(&ray).map(|hit| ray.origin.z + hit.t))
}

#[test]
fn backs_are_passed_by_every_query_at_every_level() {
    let mut random = Random(3);
    for level in simd_levels() {
        let bvh = |both, pass: bool| {
            let mut geometry = geometry(both);
            if pass {
                geometry.set_backs(Backs::PassOneSided);
            }
            Bvh::build(Arc::new(geometry)).unwrap().at_level(level)
        };
        let [all, passed, both] = [bvh(true, false), bvh(false, true), bvh(true, true)];
        for _ in 0..50 {
            let [low, high] =
                [0.0, 2.5].map(|z| Vec3::new(9.0 * random.unit() - 4.5, 9.0 * random.unit() - 4.5, z));
            // From below the front at 1 shows its back, that at 2 its front.
            assert_eq!(through(&all, low).1, Some(1.0));
            let (passing, height) = through(&passed, low);
            assert_eq!((passing[0], passing[1], height), (0.0, 0.0, Some(2.0)));
            assert!((passing[2] - 0.2).abs() < 1e-5, "closed at a distance of 2 of 10: {}", passing[2]);
            assert_eq!(through(&passed, high), ([1.0; 3], None));
            assert_eq!(through(&both, high).1, Some(3.0), "seen from both sides");
        }
    }
}
