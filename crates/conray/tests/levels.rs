//! Every method gives the same bits at every level of SIMD.

use conray::{
    AoSettings, Backend, Control, CpuBackend, Estimate, Falloff, Level, Method, Sampling, Session,
    SurfacePoint, scene, target::Target,
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
    let octree = session.octree().cloned().map(Arc::new);
    let backend = CpuBackend::new(Arc::new(session.bvh().clone()), octree).at_level(level);
    let mut estimates = vec![Estimate::PENDING; points.len()];
    let samples = 0..session.plan().samples();
    backend.estimate(session.plan(), samples, points, &mut estimates, Control::none()).unwrap();
    estimates
}

#[test]
fn methods_agree_at_every_level() {
    for method in Method::ALL {
        for (falloff, sampling, rays) in [
            (Falloff::None, Sampling::Sobol, 150),
            (Falloff::Linear, Sampling::Sobol, 40),
            (Falloff::None, Sampling::Random, 70),
        ] {
            let settings =
                AoSettings { method, rays, voxels: 64, falloff, sampling, ..AoSettings::default() };
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
