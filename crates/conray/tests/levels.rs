//! Every method gives the same bits at every level of SIMD.

use conray::{
    AoSettings, Backend, Control, CpuBackend, Estimate, Falloff, Level, Method, Sampling, Session,
    SurfacePoint, merge, scene, target::Target,
};
use conray_core::simd_levels;
use std::sync::Arc;

fn bits(estimates: &[Estimate]) -> Vec<[u32; 6]> {
    let of = |e: &Estimate| {
        let [x, y, z] = e.bent.to_array().map(f32::to_bits);
        [e.visibility.to_bits(), e.error.to_bits(), e.rays, x, y, z]
    };
    estimates.iter().map(of).collect()
}

fn estimates(session: &Session, points: &[SurfacePoint], level: Level) -> Vec<Estimate> {
    let octree = session.octree().cloned();
    let backend = CpuBackend::new(Arc::clone(session.bvh()), octree).at_level(level);
    let mut estimates = vec![Estimate::PENDING; points.len()];
    let samples = 0..session.plan().samples();
    backend.estimate(session.plan(), samples, points, &mut estimates, Control::none()).unwrap();
    estimates
}

/// However many rays are taken at once, they are the same rays.
#[test]
fn rays_by_quarters_are_those_as_drawn() {
    for sampling in Sampling::ALL {
        let settings =
            AoSettings { method: Method::Rays, rays: Some(300), sampling, ..AoSettings::default() };
        let scene = scene::builtin("cornell").unwrap();
        let view = scene.default_view();
        let session = Session::build(scene.geometry, &settings).unwrap();
        let points = session.camera(&view, 16, 12).unwrap().points().to_vec();
        let backend = CpuBackend::new(Arc::clone(session.bvh()), None);
        let over = |samples: std::ops::Range<u32>| {
            let mut estimates = vec![Estimate::PENDING; points.len()];
            backend.estimate(session.plan(), samples, &points, &mut estimates, Control::none()).unwrap();
            estimates
        };
        let (whole, first, rest) = (over(0..300), over(0..130), over(130..300));
        for (whole, (first, rest)) in whole.iter().zip(first.iter().zip(&rest)) {
            let merged = merge(first, 130, rest, 170);
            assert_eq!(whole.rays, merged.rays);
            assert!(
                (whole.visibility - merged.visibility).abs() < 1e-5,
                "{sampling:?}: {whole:?} {merged:?}"
            );
            assert!((whole.bent - merged.bent).length() < 1e-5, "{sampling:?}: {whole:?} {merged:?}");
        }
        assert!(whole.iter().filter(|e| (0.05..0.95).contains(&e.visibility)).count() > 10);
    }
}

#[test]
fn methods_agree_at_every_level() {
    for method in Method::ALL {
        for (falloff, sampling, rays) in [
            // Bundles as drawn, and by quarters of the hemisphere.
            (Falloff::None, Sampling::Sobol, 150),
            (Falloff::None, Sampling::Sobol, 300),
            (Falloff::Linear, Sampling::Sobol, 40),
            (Falloff::None, Sampling::Random, 70),
        ] {
            let settings = AoSettings {
                method,
                rays: Some(rays),
                voxels: 64,
                falloff,
                sampling,
                ..AoSettings::default()
            };
            let scene = scene::builtin("cornell").unwrap();
            let view = scene.default_view();
            let session = Session::build(scene.geometry, &settings).unwrap();
            let points = session.camera(&view, 16, 12).unwrap().points().to_vec();
            let expected = bits(&estimates(&session, &points, Level::baseline()));
            let some = |e: &[u32; 6]| (0.05..0.95).contains(&f32::from_bits(e[0]));
            assert!(expected.iter().filter(|e| some(e)).count() > 10, "{method}: all alike tests little");
            for level in simd_levels() {
                let found = bits(&estimates(&session, &points, level));
                assert!(found == expected, "{method}, {falloff:?}, {sampling:?} at {level:?}");
            }
        }
    }
}
