//! Narrow cones of rays, and occluders that fade near the horizon, against closed forms.

use conray::{AoSettings, Control, Distance, Geometry, Method, Session, SurfacePoint, TriangleMesh, Vec3};
use std::f32::consts::TAU;

/// Sides of what stands for a circle: its area is 0.04 % less.
const SIDES: u32 = 128;

fn circle(k: u32, height: f32) -> Vec3 {
    let angle = TAU * (k % SIDES) as f32 / SIDES as f32;
    Vec3::new(angle.cos(), height, angle.sin())
}

/// Mean visibility of the origin, looking up, and the expected error of that mean.
fn seen(mesh: TriangleMesh, settings: AoSettings) -> f32 {
    let mut geometry = Geometry::default();
    let mesh = geometry.add_mesh(mesh).unwrap();
    geometry.add_instance(mesh, conray::Affine3A::IDENTITY).unwrap();
    let settings = AoSettings { rays: Some(256), distance: Distance::Infinite, ..settings };
    let session = Session::build(geometry, &settings).unwrap();
    // As many points as make method hybrid pool them, all at one place.
    let points: Vec<SurfacePoint> =
        (0..400).map(|id| SurfacePoint::new(Vec3::ZERO, Vec3::Y).with_id(id)).collect();
    let outcome = session.run_target(&points, Control::none()).unwrap();
    outcome.estimates.iter().map(|e| e.visibility).sum::<f32>() / points.len() as f32
}

/// A disc of radius 1 at height 1: seen within 45 degrees of the normal.
fn disc() -> TriangleMesh {
    let mut positions: Vec<Vec3> = (0..SIDES).map(|k| circle(k, 1.0)).collect();
    positions.push(Vec3::Y);
    TriangleMesh::new(positions, (0..SIDES).map(|k| [k, (k + 1) % SIDES, SIDES]).collect()).unwrap()
}

/// A wall all round at distance 1, of height 1: what is below 45 degrees.
fn wall() -> TriangleMesh {
    let positions =
        [-0.5, 1.0].iter().flat_map(|&height| (0..SIDES).map(move |k| circle(k, height))).collect();
    let quad =
        |k: u32| [[k, (k + 1) % SIDES, SIDES + k], [SIDES + (k + 1) % SIDES, SIDES + k, (k + 1) % SIDES]];
    TriangleMesh::new(positions, (0..SIDES).flat_map(quad).collect()).unwrap()
}

#[test]
fn within_a_cone_the_cosine_weighs_as_over_the_hemisphere() {
    for method in [Method::Rays, Method::Hybrid] {
        for spread in [180.0f32, 150.0, 120.0, 91.0, 80.0, 20.0] {
            let found = seen(disc(), AoSettings { method, spread, ..AoSettings::default() });
            // Shares of a cosine-weighted cone go by the squared sines.
            let expected = 1.0 - (0.5 / (0.5 * spread).to_radians().sin().powi(2)).min(1.0);
            assert!((found - expected).abs() < 0.002, "{method} {spread}: {found} for {expected}");
        }
    }
}

#[test]
fn below_the_bias_angle_occluders_count_by_their_height() {
    for method in [Method::Rays, Method::Hybrid] {
        for bias_angle in [0.0f32, 10.0, 30.0, 45.0, 60.0] {
            let found = seen(wall(), AoSettings { method, bias_angle, ..AoSettings::default() });
            // Heights h, sines over the horizon, have density 2 h; those up to sqrt(1/2) are closed, weighed by h / b below b.
            let (top, b) = (0.5f32.sqrt(), bias_angle.to_radians().sin());
            let low = top.min(b);
            let faded = if b > 0.0 { 2.0 / 3.0 * low.powi(3) / b } else { 0.0 };
            let expected = 1.0 - (faded + top * top - low * low);
            assert!((found - expected).abs() < 0.002, "{method} {bias_angle}: {found} for {expected}");
        }
    }
}
