//! What may never change a result, and what may change it in one direction only.

use conray::{
    AoSettings, Control, Distance, Error, Estimate, Geometry, Method, Session, SessionOptions, SurfacePoint,
    TriangleMesh, Vec3, scene, target::Target,
};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

fn settings(method: Method) -> AoSettings {
    AoSettings { method, rays: Some(8), voxels: 64, max_rays: 4, ..AoSettings::default() }
}

fn cornell(method: Method, threads: usize) -> Session {
    let scene = scene::builtin("cornell").unwrap();
    let options = SessionOptions { threads, ..SessionOptions::default() };
    Session::build_observed(scene.geometry, &settings(method), &options, &|_| {}).unwrap()
}

fn cornell_points(session: &Session) -> Vec<SurfacePoint> {
    let view = scene::builtin("cornell").unwrap().default_view();
    session.camera(&view, 40, 30).unwrap().points().to_vec()
}

fn bits(estimates: &[Estimate]) -> Vec<(u32, u32, u32)> {
    estimates.iter().map(|e| (e.visibility.to_bits(), e.error.to_bits(), e.rays)).collect()
}

#[test]
fn threads_order_and_tiling_change_no_bit() {
    for method in Method::ALL {
        let one = cornell(method, 1);
        let points = cornell_points(&one);
        assert!(points.len() > 500);
        let expected = bits(&one.estimate(&points).unwrap());
        for threads in [2, 5] {
            let other = cornell(method, threads);
            assert_eq!(cornell_points(&other), points, "{method}, {threads} threads");
            assert!(bits(&other.estimate(&points).unwrap()) == expected, "{method}, {threads} threads");
        }
        let reversed: Vec<SurfacePoint> = points.iter().rev().copied().collect();
        let mut estimates = bits(&one.estimate(&reversed).unwrap());
        estimates.reverse();
        assert!(estimates == expected, "{method}: order");
        let tiles: Vec<Estimate> = points.chunks(77).flat_map(|tile| one.estimate(tile).unwrap()).collect();
        assert!(bits(&tiles) == expected, "{method}: tiling");
    }
}

#[test]
fn points_that_are_not_valid_are_told_and_change_no_other() {
    for method in Method::ALL {
        let session = cornell(method, 2);
        let points = cornell_points(&session);
        let expected = bits(&session.estimate(&points).unwrap());
        let bad = [
            SurfacePoint::new(Vec3::NAN, Vec3::Z),
            SurfacePoint::new(Vec3::ZERO, Vec3::ZERO),
            SurfacePoint::new(Vec3::ONE, Vec3::splat(f32::INFINITY)),
        ];
        // After every fifth point one, and a chunk of nothing else at the end.
        let mixed: Vec<_> = points
            .iter()
            .enumerate()
            .flat_map(|(i, &point)| [Some(point), (i % 5 == 0).then(|| bad[i % 3])])
            .flatten()
            .chain(std::iter::repeat_n(bad[1], 150))
            .collect();
        let estimates = session.estimate(&mixed).unwrap();
        let told = |e: &Estimate| (e.visibility, e.error, e.rays) == (0.0, f32::INFINITY, 0);
        let (good, rest): (Vec<_>, Vec<_>) = mixed.iter().zip(estimates).partition(|(p, _)| p.is_valid());
        assert!(rest.len() > 200 && rest.iter().all(|(_, estimate)| told(estimate)), "{method}");
        let good: Vec<_> = good.into_iter().map(|(_, estimate)| estimate).collect();
        assert!(bits(&good) == expected, "{method}");
    }
}

#[test]
fn another_seed_is_another_draw_for_methods_with_rays() {
    for method in Method::ALL {
        let mut session = cornell(method, 0);
        let points = cornell_points(&session);
        let first = bits(&session.estimate(&points).unwrap());
        session.set_plan(&AoSettings { seed: 1, ..settings(method) }).unwrap();
        let second = bits(&session.estimate(&points).unwrap());
        assert_eq!(first == second, method == Method::Cones, "{method}");
    }
}

#[test]
fn more_distance_never_opens() {
    for method in [Method::Rays, Method::Cones] {
        let mut session = cornell(method, 0);
        let points = cornell_points(&session);
        let mut last = vec![1.0f32; points.len()];
        for share in [0.05, 0.1, 0.2, 0.5] {
            let distance = Distance::World(share * session.bounds().diagonal());
            session.set_plan(&AoSettings { distance, ..settings(method) }).unwrap();
            let now: Vec<f32> = session.estimate(&points).unwrap().iter().map(|e| e.visibility).collect();
            // The same rays reach further; cones take other steps, so they may differ by their own error.
            let slack = if method == Method::Rays { 1e-6 } else { 0.03 };
            assert!(now.iter().zip(&last).all(|(now, last)| *now <= last + slack), "{method} at {share}");
            last = now;
        }
    }
}

#[test]
fn every_estimate_is_in_range() {
    for method in Method::ALL {
        let session = cornell(method, 0);
        for e in session.estimate(&cornell_points(&session)).unwrap() {
            assert!(
                (0.0..=1.0).contains(&e.visibility) && e.error >= 0.0 && e.error.is_finite(),
                "{method}: {e:?}"
            );
            assert!(e.bent.length() <= 1.0 + 1e-5);
            assert_eq!(e.cone.is_some(), method.needs_octree());
            assert!(e.rays > 0 || method.needs_octree());
            assert!(e.rays == 0 || method.traces_rays());
        }
    }
}

#[test]
fn points_that_cannot_be_asked_about_are_answered_all_the_same() {
    let nonsense = [
        SurfacePoint::new(Vec3::ZERO, Vec3::ZERO),
        SurfacePoint::new(Vec3::NAN, Vec3::Z),
        SurfacePoint::new(Vec3::INFINITY, Vec3::Z),
        SurfacePoint::new(Vec3::splat(f32::MAX), Vec3::Z),
    ];
    for method in Method::ALL {
        for e in cornell(method, 0).estimate(&nonsense).unwrap() {
            assert!((0.0..=1.0).contains(&e.visibility), "{method}: {e:?}");
        }
    }
}

#[test]
fn stopping_keeps_what_was_done_and_progress_adds_up() {
    let session = cornell(Method::Rays, 2);
    let points = cornell_points(&session);
    let done = AtomicU64::new(0);
    let progress = |n: usize| {
        done.fetch_add(n as u64, Ordering::Relaxed);
    };
    let never = AtomicBool::new(false);
    let outcome = session.run(&points, Control { cancelled: &never, progress: &progress }).unwrap();
    assert!(outcome.work.completed);
    assert_eq!(done.load(Ordering::Relaxed), conray::PROGRESS_UNITS);
    assert_eq!(outcome.work.rays, 8 * points.len() as u64);

    let stop = AtomicBool::new(false);
    let after = |_| stop.store(true, Ordering::Relaxed);
    let outcome = session.run(&points, Control { cancelled: &stop, progress: &after }).unwrap();
    assert!(!outcome.work.completed);
    let reached = outcome.estimates.iter().filter(|e| !e.is_pending()).count();
    assert!(reached > 0 && reached < points.len(), "{reached} of {}", points.len());
}

#[test]
fn memory_limits_step_the_octree_down_or_say_what_is_needed() {
    let geometry = || scene::builtin("cornell").unwrap().geometry;
    let base = AoSettings { voxels: 512, ..settings(Method::Cones) };
    let free = Session::build(geometry(), &base).unwrap();
    let limit = free.report().bvh_bytes + free.report().octree_bytes / 2;
    let mut warned = std::sync::Mutex::new(0);
    let observer = |event| {
        if matches!(event, conray::Event::Warning { .. }) {
            *warned.lock().unwrap() += 1;
        }
    };
    let limited = AoSettings { max_memory: Some(limit), ..base.clone() };
    let stepped =
        Session::build_observed(geometry(), &limited, &SessionOptions::default(), &observer).unwrap();
    assert!(stepped.report().voxels < 512);
    assert_eq!(*warned.get_mut().unwrap(), 1);
    for method in Method::ALL {
        let impossible = AoSettings { max_memory: Some(1000), method, ..base.clone() };
        match Session::build(geometry(), &impossible) {
            Err(Error::Settings(e)) => assert_eq!(e.option, "max-memory"),
            other => panic!("{method}: 1000 bytes cannot do: {:?}", other.err()),
        }
    }
    // Room for the scene and its BVH, but for no octree at all.
    let tight = AoSettings { max_memory: Some(free.report().bvh_bytes + 2_000_000), ..base };
    if let Err(error) = Session::build(geometry(), &tight) {
        assert!(matches!(error, Error::Voxel(_)), "{error}");
    }
}

#[test]
fn added_triangles_never_open_for_rays() {
    let build = |extra: bool| {
        let mut geometry = scene::builtin("cornell").unwrap().geometry;
        if extra {
            let at = geometry.bounds().centre();
            let size = 0.1 * geometry.bounds().diagonal();
            let corners = vec![at, at + size * Vec3::X, at + size * Vec3::Y];
            let mesh = geometry.add_mesh(TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap()).unwrap();
            geometry.add_instance(mesh, conray::Affine3A::IDENTITY).unwrap();
        }
        let distance = Distance::Infinite;
        Session::build(geometry, &AoSettings { distance, ..settings(Method::Rays) }).unwrap()
    };
    let (without, with) = (build(false), build(true));
    let points = cornell_points(&without);
    let (a, b) = (without.estimate(&points).unwrap(), with.estimate(&points).unwrap());
    assert!(a.iter().zip(&b).all(|(a, b)| b.visibility <= a.visibility));
    assert!(a != b, "the triangle must be seen by someone");
}

#[test]
fn an_empty_scene_is_open_to_rays_and_nothing_to_voxelise() {
    for method in Method::ALL {
        let settings = AoSettings { distance: Distance::World(1.0), ..settings(method) };
        match Session::build(Geometry::default(), &settings) {
            Ok(session) => {
                let estimates = session.estimate(&[SurfacePoint::new(Vec3::ZERO, Vec3::Z)]).unwrap();
                assert_eq!((method.needs_octree(), estimates[0].visibility), (false, 1.0), "{method}");
            }
            Err(error) => {
                assert!(method.needs_octree() && matches!(error, Error::Voxel(_)), "{method}: {error}")
            }
        }
    }
}

#[test]
fn sessions_can_be_shared_between_threads() {
    fn shared<T: Send + Sync>() {}
    shared::<Session>();
    shared::<Geometry>();
    shared::<Error>();
}
