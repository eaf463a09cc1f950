//! Refinements that go on, and sessions that share what is built.

use conray::{AoSettings, Budget, Control, Ended, Method, Session, SessionOptions, scene, target::Target};
use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU64, Ordering},
};

fn session(method: Method) -> Session {
    let geometry = scene::builtin("cornell").unwrap().geometry;
    let rays = method.has_budget().then_some(64);
    Session::build(geometry, &AoSettings { method, rays, voxels: 64, ..AoSettings::default() }).unwrap()
}

#[test]
fn a_refinement_in_steps_ends_where_a_run_does_and_an_interrupted_pass_leaves_no_trace() {
    let view = scene::builtin("cornell").unwrap().default_view();
    for method in [Method::Rays, Method::Cones, Method::Paper] {
        let session = session(method);
        let camera = session.camera(&view, 40, 30).unwrap();
        let whole = session.run_target(&camera, Control::none()).unwrap().estimates;
        let mut work = session.refinement(&camera);
        assert!(work.estimates().iter().all(|e| e.is_pending()) && work.expected_rmse().is_infinite());
        let mut ended = Ended::Cancelled;
        for rays in [16, 64] {
            ended = session.go_on(&mut work, camera.points(), Budget::rays(rays), Control::none()).unwrap();
            let before = work.estimates();
            let stopped = AtomicBool::new(true);
            let control = Control { cancelled: &stopped, progress: &|_| {} };
            let cancelled = session.go_on(&mut work, camera.points(), Budget::rays(4096), control).unwrap();
            assert_eq!((cancelled, work.estimates()), (Ended::Cancelled, before), "{method}");
        }
        assert_eq!(ended, if method.has_budget() { Ended::Rays } else { Ended::Done });
        assert_eq!(work.estimates(), whole, "{method}: the same passes, the same bits");
        assert_eq!(work.rays(), whole.iter().map(|e| u64::from(e.rays)).sum::<u64>());
    }
}

#[test]
fn a_refinement_of_hybrid_gets_better_with_every_step() {
    let session = session(Method::Hybrid);
    let camera = session.camera(&scene::builtin("cornell").unwrap().default_view(), 64, 48).unwrap();
    let mut work = session.refinement(&camera);
    let mut errors = Vec::new();
    for rays in [2, 8, 32] {
        session.go_on(&mut work, camera.points(), Budget::rays(rays), Control::none()).unwrap();
        errors.push(work.expected_rmse());
    }
    assert!(errors.windows(2).all(|w| w[1] < w[0]), "{errors:?}");
}

#[test]
fn an_interrupted_round_of_hybrid_is_shown_when_work_goes_on_and_ends_in_the_bits_of_unbroken_work() {
    let session = session(Method::Hybrid);
    let camera = session.camera(&scene::builtin("cornell").unwrap().default_view(), 96, 64).unwrap();
    let whole = |steps: &[u32]| {
        let mut work = session.refinement(&camera);
        for &rays in steps {
            session.go_on(&mut work, camera.points(), Budget::rays(rays), Control::none()).unwrap();
        }
        work
    };
    // In the lattice, and in a round that was chosen.
    for (first, then) in [(None, 4), (Some(4), 32)] {
        let mut work = session.refinement(&camera);
        if let Some(rays) = first {
            session.go_on(&mut work, camera.points(), Budget::rays(rays), Control::none()).unwrap();
        }
        let (before, rays_before) = (work.estimates(), work.rays());
        let (stopped, calls) = (AtomicBool::new(false), AtomicU64::new(0));
        let progress = |_| {
            if calls.fetch_add(1, Ordering::Relaxed) == 1 {
                stopped.store(true, Ordering::Relaxed);
            }
        };
        let control = Control { cancelled: &stopped, progress: &progress };
        let ended = session.go_on(&mut work, camera.points(), Budget::rays(then), control).unwrap();
        assert_eq!(ended, Ended::Cancelled);
        assert!(work.rays() > rays_before, "something was found");
        let after = work.estimates();
        for (before, after) in before.iter().zip(&after) {
            // Bits: what is pending is no number.
            let shown = |e: &conray::Estimate| [e.visibility, e.error].map(f32::to_bits);
            assert_eq!(shown(before), shown(after));
        }
        session.go_on(&mut work, camera.points(), Budget::rays(then), Control::none()).unwrap();
        let steps: Vec<u32> = first.into_iter().chain([then]).collect();
        assert_eq!(work.estimates(), whole(&steps).estimates());
    }
}

#[test]
fn sessions_of_one_scene_share_what_is_built_and_build_what_is_missing() {
    let rays = session(Method::Rays);
    let options = SessionOptions::default();
    let settings = |method, voxels| AoSettings { method, voxels, ..AoSettings::default() };
    let cones = rays.with(&settings(Method::Cones, 64), &options, &|_| {}).unwrap();
    assert!(rays.octree().is_none() && cones.octree().is_some());
    assert!(Arc::ptr_eq(rays.bvh(), cones.bvh()));
    let paper = cones.with(&settings(Method::Paper, 64), &options, &|_| {}).unwrap();
    assert!(Arc::ptr_eq(paper.octree().unwrap(), cones.octree().unwrap()));
    let finer = cones.with(&settings(Method::Cones, 128), &options, &|_| {}).unwrap();
    assert_eq!(finer.octree().unwrap().resolution(), 128);
    assert!(rays.with(&settings(Method::Rays, 128), &options, &|_| {}).unwrap().octree().is_none());
    assert!(rays.with_octree(&settings(Method::Rays, 128), &options, &|_| {}).unwrap().octree().is_some());
    let bad = AoSettings { cones: 7, ..AoSettings::default() };
    assert!(rays.with(&bad, &options, &|_| {}).is_err());
    let poor = AoSettings { method: Method::Rays, max_memory: Some(1), ..AoSettings::default() };
    assert!(rays.with(&poor, &options, &|_| {}).is_err());
}

#[test]
fn a_point_looked_at_has_the_rays_of_method_rays() {
    let session = session(Method::Rays);
    let camera = session.camera(&scene::builtin("cornell").unwrap().default_view(), 16, 12).unwrap();
    let estimates = session.run_target(&camera, Control::none()).unwrap().estimates;
    for (point, estimate) in camera.points().iter().zip(&estimates) {
        let rays = session.rays_at(point, 64);
        let open = rays.iter().filter(|ray| ray.hit.is_none()).count() as f32 / 64.0;
        assert!((open - estimate.visibility).abs() < 1e-5, "{open} {}", estimate.visibility);
    }
}
