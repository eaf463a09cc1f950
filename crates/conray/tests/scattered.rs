//! Method `hybrid` over points that lie in no image.

use conray::{
    AoSettings, Control, Estimate, Method, Session, SessionOptions, SurfacePoint, Vec3, scene, target::Target,
};
use conray_core::hash_u32;

/// In no order, numbered anew.
fn shuffled(mut points: Vec<SurfacePoint>) -> Vec<SurfacePoint> {
    points.sort_by_key(|point| hash_u32(point.id));
    (0..).zip(points).map(|(id, point)| point.with_id(id)).collect()
}

fn session(name: &str, threads: usize) -> Session {
    let (scene, options) =
        (scene::builtin(name).unwrap(), SessionOptions { threads, ..SessionOptions::default() });
    Session::build_observed(scene.geometry, &AoSettings::default(), &options, &|_| {}).unwrap()
}

/// What the first camera sees.
fn seen(name: &str, session: &Session, size: u32) -> Vec<SurfacePoint> {
    let view = scene::builtin(name).unwrap().default_view();
    shuffled(session.camera(&view, size, size).unwrap().points().to_vec())
}

/// Middles of some triangles: of large and tiny ones, and of such as lie inside other parts, where neighbours say nothing.
fn middles(session: &Session, every: usize) -> Vec<SurfacePoint> {
    let mut points = Vec::new();
    for (index, instance) in session.geometry().instances().iter().enumerate() {
        let mesh = session.geometry().mesh_of(index);
        for triangle in (0..mesh.triangles().len()).step_by(every) {
            let [a, b, c] = mesh.corners(triangle).map(|p| instance.world_from_mesh.transform_point3(p));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            if normal != Vec3::ZERO {
                points.push(SurfacePoint::new((a + b + c) / 3.0, normal).with_id(points.len() as u32));
            }
        }
    }
    shuffled(points)
}

fn run(
    session: &mut Session,
    points: &Vec<SurfacePoint>,
    method: Method,
    rays: u32,
    seed: u32,
) -> Vec<Estimate> {
    session.set_plan(&AoSettings { method, rays: Some(rays), seed, ..AoSettings::default() }).unwrap();
    session.run_target(points, Control::none()).unwrap().estimates
}

fn rms(values: impl Iterator<Item = f32>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), v| (sum + f64::from(v).powi(2), count + 1));
    assert!(count > 0);
    (sum / f64::from(count)).sqrt()
}

/// True error, expected error, error of as many rays.
fn errors(session: &mut Session, points: &Vec<SurfacePoint>, rays: u32) -> [f64; 3] {
    let truth = run(session, points, Method::Rays, 4096, 99);
    let off = |found: &[Estimate]| rms(found.iter().zip(&truth).map(|(f, t)| f.visibility - t.visibility));
    let found = run(session, points, Method::Hybrid, rays, 0);
    let plain = run(session, points, Method::Rays, rays, 0);
    [off(&found), rms(found.iter().map(|e| e.error)), off(&plain)]
}

#[test]
fn neighbours_of_one_surface_help() {
    for (name, most) in [("cornell", 0.8), ("atrium", 0.95)] {
        let mut session = session(name, 0);
        let points = seen(name, &session, 96);
        let [error, expected, plain] = errors(&mut session, &points, 64);
        assert!(error < most * plain, "{name}: {error} against {plain}");
        assert!((0.67..1.5).contains(&(expected / error)), "{name}: {expected} for {error}");
    }
}

#[test]
fn neighbours_that_say_nothing_do_no_harm() {
    let mut session = session("atrium", 0);
    let points = middles(&session, 40);
    let [error, expected, plain] = errors(&mut session, &points, 64);
    assert!(error < 1.05 * plain, "{error} against {plain}");
    assert!((0.75..1.5).contains(&(expected / error)), "{expected} for {error}");
}

#[test]
fn few_points_and_few_rays_are_for_rays_alone() {
    let mut session = session("cornell", 0);
    let points = seen("cornell", &session, 20);
    let few = points[..255].to_vec();
    for (points, rays) in [(&points, 15), (&few, 64)] {
        assert!(session.hybrid(&plan(&session, rays), points).is_none());
        let found = run(&mut session, points, Method::Hybrid, rays, 0);
        assert_eq!(found, run(&mut session, points, Method::Rays, rays, 0));
    }
    assert!(session.hybrid(&plan(&session, 16), &points).is_some());
}

fn plan(session: &Session, rays: u32) -> conray::AoPlan {
    session.plan_for(&AoSettings { rays: Some(rays), ..AoSettings::default() }).unwrap()
}

#[test]
fn threads_change_no_bit() {
    let [one, three] = [1, 3].map(|threads| {
        let mut session = session("cornell", threads);
        // More than are laid out by one thread.
        let points = seen("cornell", &session, 192);
        run(&mut session, &points, Method::Hybrid, 32, 0)
    });
    assert_eq!(one, three);
}

#[test]
fn plain_points_are_a_target_and_count_their_estimates() {
    let mut session = session("cornell", 0);
    let points = seen("cornell", &session, 20);
    let found = run(&mut session, &points, Method::Hybrid, 16, 0);
    assert_eq!(points.resolve(&found).unwrap(), found);
    assert!(points.resolve(&found[1..]).is_err());
}
