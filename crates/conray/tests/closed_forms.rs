//! Every method against closed forms: a scene, a derivation and a number.
//!
//! The cosine-weighted measure of a hemisphere is uniform on the unit disc below it (Malley's method), so what a flat
//! occluder closes is an area of that disc.

use conray::{
    Affine3A, AoSettings, Distance, Falloff, Geometry, Material, Method, Moments, Opacity, Sampling, Session,
    SurfacePoint, TriangleMesh, Vec3,
};
use std::f64::consts::PI;

/// A scene about a point at the origin whose normal is +z.
struct Case {
    name: &'static str,
    quads: Vec<[Vec3; 4]>,
    opacity: f32,
    distance: Distance,
    falloff: Falloff,
    /// Visibility at the origin.
    truth: f64,
    /// A wall stands nearer than two voxels: cones see it late.
    contact: bool,
}

/// Half the side of floors, ceilings and walls; the AO distance is 1, so their edges are out of reach.
const FAR: f32 = 1.5;

fn quad(centre: Vec3, a: Vec3, b: Vec3) -> [Vec3; 4] {
    [centre - a - b, centre + a - b, centre + a + b, centre - a + b]
}

fn floor() -> [Vec3; 4] {
    quad(Vec3::ZERO, FAR * Vec3::X, FAR * Vec3::Y)
}

fn ceiling(height: f32) -> [Vec3; 4] {
    quad(height * Vec3::Z, FAR * Vec3::X, FAR * Vec3::Y)
}

/// A wall that faces the point across the plane x = `at`.
fn wall(at: f32) -> [Vec3; 4] {
    quad(at * Vec3::X, FAR * Vec3::Y, FAR * Vec3::Z)
}

/// Share of the unit disc beyond x = c: a circular segment.
fn segment(c: f64) -> f64 {
    (c.acos() - c * (1.0 - c * c).sqrt()) / PI
}

fn cases() -> Vec<Case> {
    let plain = |name, mut quads: Vec<[Vec3; 4]>, truth| {
        quads.push(floor());
        let (distance, falloff) = (Distance::World(1.0), Falloff::None);
        Case { name, quads, opacity: 1.0, distance, falloff, truth, contact: false }
    };
    // A ceiling at h is within the distance D where the cosine is above k = h / D: all of the disc within sqrt(1 - k^2).
    let k: f64 = 0.5;
    let h = k as f32;
    let y_wall = quad(-0.01 * Vec3::Y, FAR * Vec3::X, FAR * Vec3::Z);
    vec![
        plain("open", vec![], 1.0),
        plain("ceiling", vec![ceiling(h)], k * k),
        // Directions with x above d / D meet a wall at d in time.
        Case { contact: true, ..plain("wall near", vec![wall(0.01)], 1.0 - segment(0.01)) },
        plain("wall", vec![wall(0.5)], 1.0 - segment(0.5)),
        // Two walls at right angles leave a quarter, up to the two strips of width 0.01 beside them.
        Case { contact: true, ..plain("corner", vec![wall(0.01), y_wall], 0.25 + 0.02 / PI) },
        // The share that meets the ceiling lets half through.
        Case { opacity: 0.5, ..plain("half-open ceiling", vec![ceiling(h)], 1.0 - 0.5 * (1.0 - k * k)) },
        // A hit at cosine c is at h / c: the weights integrate to (1 - k)^2.
        Case {
            falloff: Falloff::Linear,
            ..plain("ceiling, linear", vec![ceiling(h)], 1.0 - (1.0 - k).powi(2))
        },
        Case {
            falloff: Falloff::Smooth,
            ..plain(
                "ceiling, smooth",
                vec![ceiling(h)],
                1.0 - (1.0 - 4.0 * k.powi(3) + 3.0 * k * k + 6.0 * k * k * k.ln()),
            )
        },
    ]
}

/// Rotations and moves under which nothing may change.
fn placements() -> Vec<Affine3A> {
    let tilted = glam_rotation(Vec3::new(0.3, -0.5, 0.8).normalize(), 1.1);
    vec![
        Affine3A::IDENTITY,
        Affine3A::from_translation(Vec3::new(3.21, -0.77, 12.3)) * tilted,
        Affine3A::from_scale(Vec3::splat(250.0)) * glam_rotation(Vec3::X, 2.0),
    ]
}

fn glam_rotation(axis: Vec3, angle_rad: f32) -> Affine3A {
    Affine3A::from_axis_angle(axis, angle_rad)
}

fn session(case: &Case, placement: &Affine3A, settings: &AoSettings) -> (Session, f32) {
    let mut geometry = Geometry::default();
    geometry.add_material(Material { opacity: Opacity::Constant(case.opacity), ..Material::default() });
    geometry.add_material(Material::default());
    for (i, quad) in case.quads.iter().enumerate() {
        // The floor comes last and is opaque.
        let material = u32::from(i + 1 == case.quads.len());
        let mesh =
            TriangleMesh::new(quad.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap().with_material(material);
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, *placement).unwrap();
    }
    let scale = placement.transform_vector3(Vec3::X).length();
    let distance = Distance::World(case.distance.in_world(0.0) * scale);
    let settings = AoSettings { distance, falloff: case.falloff, ..settings.clone() };
    (Session::build(geometry, &settings).unwrap(), scale)
}

/// Mean and standard error over points with different random numbers.
fn measure(case: &Case, placement: &Affine3A, settings: &AoSettings, points: u32) -> Moments {
    let (session, _) = session(case, placement, settings);
    let position = placement.transform_point3(Vec3::ZERO);
    let normal = placement.transform_vector3(Vec3::Z);
    let points: Vec<SurfacePoint> =
        (0..points).map(|id| SurfacePoint::new(position, normal).with_id(id)).collect();
    session.estimate(&points).unwrap().iter().map(|e| f64::from(e.visibility)).collect()
}

/// Every sampling, with how many points tell a truth from one 3 % off: independent rays spread more than others.
const SAMPLINGS: [(Sampling, u32); 3] =
    [(Sampling::Sobol, 400), (Sampling::Stratified, 2000), (Sampling::Random, 8000)];

fn rays_by(sampling: Sampling) -> AoSettings {
    AoSettings { method: Method::Rays, rays: Some(61), sampling, ..AoSettings::default() }
}

#[test]
fn rays_agree_within_four_standard_errors() {
    for (sampling, points) in SAMPLINGS {
        for case in cases() {
            for placement in placements() {
                let m = measure(&case, &placement, &rays_by(sampling), points);
                // Where all rays agree the standard error is 0; single precision leaves 1e-6.
                let allowed = 4.0 * m.standard_error() + 1e-6;
                let (name, truth) = (case.name, case.truth);
                assert!((m.mean - truth).abs() < allowed, "{sampling}, {name}: {m:?}, truth {truth}");
            }
        }
    }
}

#[test]
fn a_wrong_truth_is_caught() {
    for (sampling, points) in SAMPLINGS {
        for case in cases() {
            let m = measure(&case, &Affine3A::IDENTITY, &rays_by(sampling), points);
            let wrong = case.truth * 0.97;
            let caught = (m.mean - wrong).abs() > 4.0 * m.standard_error() + 1e-6;
            assert!(caught, "{sampling}, {} could not fail", case.name);
        }
    }
}

#[test]
fn samplings_are_as_noisy_as_theory_says() {
    let variance = |case: &Case, sampling| {
        let settings = AoSettings { rays: Some(64), ..rays_by(sampling) };
        measure(case, &Affine3A::IDENTITY, &settings, 4000).sample_variance()
    };
    // Where a ray is open or closed, independent rays are binomial: p (1 - p) / n. The variance of 4000 variances of
    // nearly normal numbers is 2 / 4000 of its square: 4 standard errors are 9 %.
    for case in cases().iter().filter(|c| c.falloff == Falloff::None && c.opacity == 1.0 && c.truth < 1.0) {
        let binomial = case.truth * (1.0 - case.truth) / 64.0;
        let random = variance(case, Sampling::Random);
        assert!((random / binomial - 1.0).abs() < 0.09, "{}: {random}, binomial {binomial}", case.name);
        let stratified = variance(case, Sampling::Stratified);
        let sobol = variance(case, Sampling::Sobol);
        assert!(stratified < 0.7 * random && sobol < 0.7 * random, "{}: {stratified} {sobol}", case.name);
    }
}

#[test]
fn cones_come_close() {
    let mut failures = Vec::new();
    for cones in [9, 16, 25] {
        let settings = AoSettings { method: Method::Cones, cones, voxels: 512, ..AoSettings::default() };
        for case in cases() {
            for placement in placements() {
                let m = measure(&case, &placement, &settings, 1);
                let error = m.mean - case.truth;
                let row =
                    format!("{cones} cones, {}: {:.3} for {:.3}, {error:+.3}", case.name, m.mean, case.truth);
                println!("{row}");
                if error.abs() > if case.contact { CONTACT_TOLERANCE } else { CONE_TOLERANCE } {
                    failures.push(row);
                }
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// What a few wide cones through 512 voxels may err by at one point: a cone across the edge of what closes it is taken
/// as all open or all closed, and a cone is 1/9 to 1/25 of the whole.
const CONE_TOLERANCE: f64 = 0.16;

/// The same where a wall is nearer than the cones' first sample.
const CONTACT_TOLERANCE: f64 = 0.25;

#[test]
fn cones_tell_the_cases_apart() {
    // The negative control of the tolerances: no case passes for the one that is farthest from it.
    let settings = AoSettings { method: Method::Cones, ..AoSettings::default() };
    for case in cases() {
        let far = cases()
            .iter()
            .map(|c| c.truth)
            .max_by(|a, b| (a - case.truth).abs().total_cmp(&(b - case.truth).abs()));
        let m = measure(&case, &Affine3A::IDENTITY, &settings, 1);
        assert!((m.mean - far.unwrap()).abs() > CONTACT_TOLERANCE, "{} could not fail", case.name);
    }
}

/// Root mean square error over the cases without contact, in a tilted placement.
fn rms_error(settings: &AoSettings, points: u32) -> f64 {
    let squares: Moments = cases()
        .iter()
        .filter(|case| !case.contact)
        .map(|case| (measure(case, &placements()[1], settings, points).mean - case.truth).powi(2))
        .collect();
    squares.mean.sqrt()
}

#[test]
fn the_papers_blend_errs_less_than_cones_and_less_without_trust_in_them() {
    let base = AoSettings { method: Method::Paper, max_rays: 16, ..AoSettings::default() };
    let cones = rms_error(&AoSettings { method: Method::Cones, ..base.clone() }, 1);
    let paper = rms_error(&base, 200);
    let distrusting = rms_error(&AoSettings { gamma: 0.0, beta: 1e6, ..base }, 200);
    println!(
        "RMS error: cones {cones:.4}, paper {paper:.4}, with rays wherever epsilon is above 0 {distrusting:.4}"
    );
    assert!(paper < 0.8 * cones, "{paper} {cones}");
    assert!(distrusting < paper, "{distrusting} {paper}");
}
