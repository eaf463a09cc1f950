//! Method `hybrid` over whole images: closed forms, convergence, errors that can be believed, and what changes no bit.

use conray::{
    Affine3A, AoPlan, AoSettings, Budget, Control, Estimate, Geometry, Hybrid, Level, Method, Moments,
    Session, SessionOptions, SurfacePoint, TriangleMesh, Vec3, View, scene, target::CameraTarget,
    target::Target,
};
use conray_core::simd_levels;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

fn settings() -> AoSettings {
    AoSettings { method: Method::Hybrid, ..AoSettings::default() }
}

fn built_in(name: &str, size: u32) -> (Session, CameraTarget) {
    let scene = scene::builtin(name).unwrap();
    let view = scene.default_view();
    let session = Session::build(scene.geometry, &settings()).unwrap();
    let camera = session.camera(&view, size, size).unwrap();
    (session, camera)
}

fn hybrid(session: &Session, camera: &CameraTarget, rays: u32) -> Vec<Estimate> {
    let mut hybrid = session.hybrid(session.plan(), camera).unwrap();
    session.refine(&mut hybrid, session.plan(), camera.points(), Budget::rays(rays), Control::none());
    hybrid.estimates()
}

fn rays(session: &Session, camera: &CameraTarget, rays: u32, seed: u32) -> Vec<Estimate> {
    let plan = session
        .plan_for(&AoSettings { method: Method::Rays, rays: Some(rays), seed, ..AoSettings::default() })
        .unwrap();
    session.estimate_plan(&plan, 0..rays, camera.points(), Control::none()).unwrap()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), v| (sum + v * v, count + 1));
    assert!(count > 0);
    (sum / f64::from(count)).sqrt()
}

fn difference(a: &[Estimate], b: &[Estimate]) -> f64 {
    assert_eq!(a.len(), b.len());
    rms(a.iter().zip(b).map(|(a, b)| f64::from(a.visibility - b.visibility)))
}

fn bits(estimates: &[Estimate]) -> Vec<[u32; 6]> {
    let of =
        |e: &Estimate| [e.visibility, e.error, e.rays as f32, e.bent.x, e.bent.y, e.bent.z].map(f32::to_bits);
    estimates.iter().map(of).collect()
}

/// Squares of side 20 through the origin: the floor, and walls along the y and x axes.
fn walls(count: usize) -> Geometry {
    let all = [
        [(-10.0, -10.0, 0.0), (10.0, -10.0, 0.0), (10.0, 10.0, 0.0), (-10.0, 10.0, 0.0)],
        [(0.0, -10.0, -10.0), (0.0, 10.0, -10.0), (0.0, 10.0, 10.0), (0.0, -10.0, 10.0)],
        [(-10.0, 0.0, -10.0), (10.0, 0.0, -10.0), (10.0, 0.0, 10.0), (-10.0, 0.0, 10.0)],
    ];
    let mut geometry = Geometry::default();
    for corners in &all[..count] {
        let corners = corners.map(|(x, y, z)| Vec3::new(x, y, z));
        let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    geometry
}

/// The floor within the first quadrant, away from the walls by `near` at least, seen from above.
fn floor(geometry: Geometry, distance: f32, near: f32) -> (Session, CameraTarget) {
    let session = Session::build(geometry, &AoSettings { distance: distance.into(), ..settings() }).unwrap();
    let at = Vec3::new(near + 0.5, near + 0.5, 0.0);
    let view = View {
        name: "above".into(),
        eye: at + 2.0 * Vec3::Z,
        look_at: at,
        up: Vec3::Y,
        vertical_fov_deg: 28.0,
    };
    let camera = session.camera(&view, 64, 64).unwrap();
    (session, camera)
}

#[test]
fn what_is_open_is_open_and_costs_no_noise() {
    let (session, camera) = floor(walls(1), 1.0, 0.0);
    for estimate in hybrid(&session, &camera, 16) {
        assert!(estimate.visibility > 1.0 - 1e-5);
        assert!(estimate.error < 0.004, "{}", estimate.error);
        assert!(
            (estimate.bent - Vec3::Z * 2.0 / 3.0).length() < 0.1,
            "the mean open direction: {}",
            estimate.bent
        );
    }
}

/// A wall at distance d, seen as far as D, hides of a point's hemisphere the share with x > d / D on the sphere's projection:
/// the segment (a - sin a cos a) / pi with cos a = d / D, of directions inside the sphere of radius D.
#[test]
fn walls_near_the_floor_follow_their_closed_form_point_by_point() {
    let distance = 1.5;
    let (session, camera) = floor(walls(2), distance, 0.02);
    for (rays, most) in [(16, 0.025), (256, 0.004)] {
        let estimates = hybrid(&session, &camera, rays);
        let truth = |p: &SurfacePoint| {
            // A ray meets the wall x = 0 within D where its x component exceeds d / D: a segment of the unit disc.
            let cos = f64::from((p.position.x / distance).clamp(0.0, 1.0));
            let angle = cos.acos();
            1.0 - (angle - angle.sin() * cos) / std::f64::consts::PI
        };
        let off =
            rms(camera.points().iter().zip(&estimates).map(|(p, e)| f64::from(e.visibility) - truth(p)));
        assert!(off < most, "{rays} rays: {off}");
        if rays < 256 {
            continue;
        }
        // Negative control: the truth of another distance is told apart.
        let wrong = rms(camera.points().iter().zip(&estimates).map(|(p, e)| {
            let cos = f64::from((p.position.x / (1.1 * distance)).clamp(0.0, 1.0));
            let angle = cos.acos();
            f64::from(e.visibility) - 1.0 + (angle - angle.sin() * cos) / std::f64::consts::PI
        }));
        assert!(wrong > 3.0 * most, "{wrong}");
    }
}

#[test]
fn it_converges_and_its_errors_can_be_believed() {
    for name in ["cornell", "atrium"] {
        let (session, camera) = built_in(name, 128);
        let truth = rays(&session, &camera, 8192, 99);
        let mut before = f64::INFINITY;
        for budget in [16, 64, 256, 1024] {
            let estimates = hybrid(&session, &camera, budget);
            let error = difference(&estimates, &truth);
            let expected = rms(estimates.iter().map(|e| f64::from(e.error)));
            let plain = difference(&rays(&session, &camera, budget, 0), &truth);
            assert!(
                error < before && error <= plain,
                "{name}, {budget} rays: {error} of {plain}, {before} before"
            );
            assert!(
                (0.6..1.6).contains(&(expected / error)),
                "{name}, {budget} rays: {expected} for {error}"
            );
            before = error;
        }
    }
}

#[test]
fn the_mean_is_not_biased_at_many_rays() {
    let (session, camera) = built_in("atrium", 96);
    let truth = rays(&session, &camera, 16384, 99);
    let estimates = hybrid(&session, &camera, 1024);
    let differences: Moments = estimates
        .iter()
        .zip(&truth)
        .map(|(e, t)| f64::from(e.visibility) - f64::from(t.visibility))
        .collect();
    assert!(differences.mean.abs() < 4.0 * differences.standard_error(), "{differences:?}");
}

#[test]
fn threads_and_levels_of_simd_change_no_bit() {
    let scene = scene::builtin("cornell").unwrap();
    let view = scene.default_view();
    let run = |threads: usize, level: Option<Level>| {
        let options = SessionOptions { threads, ..SessionOptions::default() };
        let session =
            Session::build_observed(scene.geometry.clone(), &settings(), &options, &|_| {}).unwrap();
        let camera = session.camera(&view, 70, 45).unwrap();
        let bvh = conray::Bvh::clone(session.bvh()).at_level(level.unwrap_or(session.bvh().level()));
        let mut hybrid = session.hybrid(session.plan(), &camera).unwrap();
        session.install(|| {
            hybrid.refine(session.plan(), &bvh, camera.points(), Budget::rays(80), Control::none())
        });
        bits(&hybrid.estimates())
    };
    let expected = run(1, None);
    for threads in [2, 3] {
        assert!(run(threads, None) == expected, "{threads} threads");
    }
    let levels = simd_levels();
    assert!(levels.len() > 1);
    for level in levels {
        assert!(run(2, Some(level)) == expected, "{level:?}");
    }
}

#[test]
fn more_work_on_the_same_result_lowers_its_error() {
    let (session, camera) = built_in("cornell", 96);
    let truth = rays(&session, &camera, 4096, 99);
    let mut work = session.hybrid(session.plan(), &camera).unwrap();
    assert_eq!((work.rays(), work.expected_rmse()), (0, f64::INFINITY));
    assert!(work.estimates().iter().all(Estimate::is_pending));
    let (mut error, mut expected, mut spent) = (f64::INFINITY, f64::INFINITY, 0);
    for budget in [8, 32, 128, 512] {
        session.refine(&mut work, session.plan(), camera.points(), Budget::rays(budget), Control::none());
        let now = difference(&work.estimates(), &truth);
        assert!(now < error && work.expected_rmse() < expected && work.rays() > spent, "{budget}: {now}");
        assert!(work.rays() as f64 <= 1.05 * f64::from(budget) * camera.points().len() as f64);
        (error, expected, spent) = (now, work.expected_rmse(), work.rays());
    }
    let before = bits(&work.estimates());
    session.refine(&mut work, session.plan(), camera.points(), Budget::rays(256), Control::none());
    assert!(bits(&work.estimates()) == before, "less than there is already changes nothing");
}

#[test]
fn it_can_be_stopped_and_tells_how_far_it_is() {
    let (mut session, camera) = built_in("cornell", 64);
    session.set_plan(&AoSettings { rays: Some(64), ..settings() }).unwrap();
    let at_once = AtomicBool::new(true);
    let stopped = session.run_target(&camera, Control { cancelled: &at_once, progress: &|_| {} }).unwrap();
    assert_eq!(stopped.work.rays, 0);
    assert!(stopped.estimates.iter().all(Estimate::is_pending), "nothing is made up");
    let (cancelled, done) = (AtomicBool::new(false), AtomicU64::new(0));
    let progress = |units: usize| {
        if done.fetch_add(units as u64, Ordering::Relaxed) > 100 {
            cancelled.store(true, Ordering::Relaxed);
        }
    };
    let outcome =
        session.run_target(&camera, Control { cancelled: &cancelled, progress: &progress }).unwrap();
    assert!(
        !outcome.work.completed && outcome.work.rays > 20_000 && outcome.work.rays < 64 * 4096,
        "{} {}",
        outcome.work.completed,
        outcome.work.rays
    );
    assert_eq!(outcome.estimates.len(), camera.points().len());
    assert!(outcome.estimates.iter().all(|e| (0.0..=1.0).contains(&e.visibility)), "what is there is usable");
}

fn odd(points: &[SurfacePoint], width: u32, height: u32, plan: &AoPlan, session: &Session) -> Vec<Estimate> {
    let mut hybrid = Hybrid::of_image(plan, points, 0, [width, height]);
    session.refine(&mut hybrid, plan, points, Budget::rays(64), Control::none());
    hybrid.estimates()
}

#[test]
fn odd_images_are_no_trouble() {
    let session = Session::build(walls(2), &AoSettings { distance: 1.0.into(), ..settings() }).unwrap();
    let plan = session.plan();
    assert!(odd(&[], 0, 0, plan, &session).is_empty());
    let lost = SurfacePoint::new(Vec3::new(5.0, 0.0, 0.0), Vec3::Z);
    assert_eq!(odd(&[lost], 0, 0, plan, &session)[0].error, f32::INFINITY, "an image without pixels");
    let point = SurfacePoint::new(Vec3::new(5.0, 0.0, 0.0), Vec3::Z);
    let one = odd(&[point], 1, 1, plan, &session);
    // A guess of one half counts a little where no neighbour tells.
    let open = |e: &Estimate| e.visibility > 1.0 - 1e-4 && e.error.is_finite();
    assert!(open(&one[0]) && one[0].rays == 64, "{one:?}");
    // A size of pixels that is not known, points that are not valid, and pixels that are not in the image.
    let bad = SurfacePoint::new(Vec3::NAN, Vec3::Z).with_id(1);
    let outside = point.with_id(1000);
    let mixed = odd(&[point, bad, outside, point.with_id(5)], 3, 2, plan, &session);
    assert!(open(&mixed[0]) && open(&mixed[3]), "{mixed:?}");
    for estimate in &mixed[1..3] {
        assert_eq!((estimate.visibility, estimate.error, estimate.rays), (0.0, f32::INFINITY, 0));
    }
    // All pixels at one place.
    let same: Vec<_> = (0..64).map(|id| point.with_id(id)).collect();
    assert!(odd(&same, 8, 8, plan, &session).iter().all(open));
}
