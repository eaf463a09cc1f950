//! The declarations against the library itself.

use super::{Device, Embree, Packet, Ray1, SceneFlags};
use conray_core::{Affine3A, Geometry, Ray, TriangleMesh, Vec3};

/// The unit right triangle in the plane z = 1, placed at x = 10.
fn scene(flags: SceneFlags) -> Embree {
    let mut geometry = Geometry::default();
    let triangle = TriangleMesh::new(vec![Vec3::Z, Vec3::X + Vec3::Z, Vec3::Y + Vec3::Z], vec![[0, 1, 2]]);
    let mesh = geometry.add_mesh(triangle.unwrap()).unwrap();
    geometry.add_instance(mesh, Affine3A::from_translation(10.0 * Vec3::X)).unwrap();
    Embree::build(&Device::new("").unwrap(), &geometry, flags).unwrap()
}

#[test]
#[ignore = "needs Embree: bench/fetch-rivals embree"]
fn every_query_tells_open_from_blocked() {
    for flags in [SceneFlags::default(), SceneFlags { robust: true, compact: true }] {
        let embree = scene(flags);
        let ray = |x: f32, t_max: f32| Ray { origin: Vec3::new(x, 0.2, 0.0), direction: Vec3::Z, t_max };
        let mut rays = [(10.2, 2.0), (10.2, 0.9), (9.9, 2.0), (10.2, f32::INFINITY)]
            .map(|(x, t_max)| Ray1::new(&ray(x, t_max)));
        embree.occluded1(&mut rays);
        assert_eq!(rays.map(|r| r.is_open()), [false, true, true, false]);

        packets::<4>(&embree);
        packets::<8>(&embree);
        packets::<16>(&embree);

        let nearest = embree.nearest(&ray(10.2, 2.0)).unwrap();
        // Embree divides by an estimate of the reciprocal, which processors round differently.
        assert!((nearest.t - 1.0).abs() <= f32::EPSILON, "{}", nearest.t);
        assert_eq!((nearest.instance, nearest.triangle), (0, 0));
        let [u, v] = nearest.barycentric;
        assert!((u - 0.2).abs() < 1e-5 && (v - 0.2).abs() < 1e-5, "{u} {v}");
        assert_eq!(embree.nearest(&ray(9.9, 2.0)), None);
    }
}

/// Rays of a packet that go up meet the triangle, those that go down do not.
fn packets<const N: usize>(embree: &Embree) {
    let up: [bool; N] = std::array::from_fn(|i| i % 3 == 0);
    let directions = up.map(|up| if up { Vec3::Z } else { -Vec3::Z });
    for coherent in [false, true] {
        let mut packets = [Packet::<N>::new([Vec3::new(10.2, 0.2, 0.0); N], directions, 2.0); 2];
        embree.occluded(&mut packets, coherent);
        for packet in packets {
            assert_eq!(packet.open(), up.map(|up| !up), "{N} rays");
        }
    }
}

#[test]
#[ignore = "needs Embree: bench/fetch-rivals embree"]
fn the_version_is_the_one_that_is_fetched() {
    assert_eq!(Device::new("").unwrap().version(), 40400);
}
