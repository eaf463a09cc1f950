use super::*;
use crate::{Slots, VertexSettings, VertexTarget};
use conray::{AoSettings, Distance, Session, SessionOptions};
use conray_core::{Affine3A, Geometry, SurfacePoint, TriangleMesh, Vec3, hash_u32};
use conray_target::Target;
use proptest::prelude::*;

/// Squares on each side of the sheet.
const SIDE: u32 = 12;

/// A unit square in the plane z = 0, cut unevenly.
fn sheet() -> TriangleMesh {
    let noise = |key: u32| (hash_u32(key) % 1000) as f32 / 1000.0 - 0.5;
    let corner = |at: u32| {
        let place = [at % (SIDE + 1), at / (SIDE + 1)];
        let is_inside = |k: usize| (1..SIDE).contains(&place[k]);
        let moved = [0, 1].map(|k| if is_inside(k) { 0.5 * noise(2 * at + k as u32) } else { 0.0 });
        Vec3::new(place[0] as f32 + moved[0], place[1] as f32 + moved[1], 0.0) / SIDE as f32
    };
    let square = |at: u32| {
        let a = at / SIDE * (SIDE + 1) + at % SIDE;
        [[a, a + 1, a + SIDE + 2], [a, a + SIDE + 2, a + SIDE + 1]]
    };
    let triangles = (0..SIDE * SIDE).flat_map(square).collect();
    TriangleMesh::new((0..(SIDE + 1).pow(2)).map(corner).collect(), triangles).unwrap()
}

fn target(mesh: TriangleMesh, fitting: &VertexSettings, threads: usize) -> (Session, VertexTarget) {
    let mut geometry = Geometry::default();
    let mesh = geometry.add_mesh(mesh).unwrap();
    geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    let settings = AoSettings { distance: Distance::Infinite, ..AoSettings::default() };
    let options = SessionOptions { threads, ..SessionOptions::default() };
    let session = Session::build_observed(geometry, &settings, &options, &|_| {}).unwrap();
    let target =
        VertexTarget::new(&session, Slots::of(&session, &[0], &[0]), fitting, &crate::Facing::default())
            .unwrap();
    (session, target)
}

fn estimates(points: &[SurfacePoint], of: impl Fn(Vec3) -> f32) -> Vec<Estimate> {
    let estimate =
        |point: &SurfacePoint| Estimate { visibility: of(point.position), error: 0.01, ..Estimate::PENDING };
    points.iter().map(estimate).collect()
}

/// Root mean square difference, over the surface, of what is drawn between values and the truth: at the middles of 64 parts of each triangle.
fn rmse(session: &Session, slots: &Slots, values: &[f32], truth: impl Fn(Vec3) -> f32) -> f64 {
    let part = |i: u32, j: u32, third: f32| [i, j].map(|k| (k as f32 + third) / 8.0);
    let upright = (0..8).flat_map(|i| (0..8 - i).map(move |j| part(i, j, 1.0 / 3.0)));
    let turned = (0..7).flat_map(|i| (0..7 - i).map(move |j| part(i, j, 2.0 / 3.0)));
    let places: Vec<[f32; 2]> = upright.chain(turned).collect();
    let (mut sum, mut area) = (0.0, 0.0);
    for surface in slots.surfaces() {
        for triangle in 0..surface.triangles.len() {
            let [a, b, c] = session.bvh().world_corners(surface.instance, triangle as u32);
            let own = f64::from((b - a).cross(c - a).length());
            let shown = surface.corners(triangle).map(|slot| values[slot as usize]);
            for &[u, v] in &places {
                let drawn = shown[0] * (1.0 - u - v) + shown[1] * u + shown[2] * v;
                let place = a + (b - a) * u + (c - a) * v;
                sum += own * f64::from(drawn - truth(place)).powi(2);
                area += own;
            }
        }
    }
    (sum / area).sqrt()
}

/// Values of the function at the vertices themselves.
fn sampled(session: &Session, slots: &Slots, of: impl Fn(Vec3) -> f32) -> Vec<f32> {
    let mut values = vec![0.0; slots.count()];
    for surface in slots.surfaces() {
        let mesh = session.geometry().mesh_of(surface.instance as usize);
        for (&vertex, &slot) in surface.vertices.iter().zip(&surface.slots) {
            values[slot as usize] = of(mesh.positions()[vertex as usize]);
        }
    }
    values
}

fn step(place: Vec3) -> f32 {
    if place.x + 0.3 * place.y < 0.6 { 0.9 } else { 0.2 }
}

/// A floor that goes on under a wall at x = 0, whose foot is dark for a fifth of a square.
fn corner(place: Vec3) -> f32 {
    1.0 - 0.9 * (-place.x * SIDE as f32 / 0.2).exp()
}

fn waves(place: Vec3) -> f32 {
    0.5 + 0.4 * (9.0 * place.x).sin() * (7.0 * place.y).cos()
}

/// Values that fit a function, and how far off what is drawn between them is; the same of its values at the vertices.
fn errors(of: impl Fn(Vec3) -> f32, settings: &VertexSettings) -> (VertexValues, f64, f64) {
    let (session, target) = target(sheet(), settings, 0);
    let values = target.resolve(&estimates(target.points(), &of)).unwrap();
    let off = |values: &[f32]| rmse(&session, target.slots(), values, &of);
    let fitted = off(&values.visibility);
    let sampled = off(&sampled(&session, target.slots(), &of));
    (values, fitted, sampled)
}

fn settings(smoothness: f32) -> VertexSettings {
    VertexSettings { smoothness, ..VertexSettings::default() }
}

#[test]
fn linear_functions_are_reproduced_whatever_the_smoothness() {
    let linear = |place: Vec3| 0.2 + 0.5 * place.x - 0.1 * place.y;
    for smoothness in [0.0, 0.1, 100.0, 1000.0] {
        let (session, target) = target(sheet(), &settings(smoothness), 0);
        let values = target.resolve(&estimates(target.points(), linear)).unwrap();
        let wanted = sampled(&session, target.slots(), linear);
        let most = values.visibility.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most < 1e-4, "{most} at smoothness {smoothness}");
        assert!(values.misfit < 1e-4);
        assert!(values.error.iter().all(|error| (error - 0.01).abs() < 1e-6));
    }
    // The comparison can fail: values of a function with a bend.
    let (values, ..) = errors(|place| linear(place) + 0.1 * place.x * place.x, &settings(100.0));
    assert!(values.misfit > 1e-3);
}

#[test]
fn constants_stay_whatever_is_known() {
    let (_, target) = target(sheet(), &settings(0.1), 0);
    let mut estimates = estimates(target.points(), |_| 0.75);
    for estimate in estimates.iter_mut().skip(100).step_by(2) {
        *estimate = Estimate::PENDING;
    }
    let values = target.resolve(&estimates).unwrap();
    assert!(values.visibility.iter().all(|value| (value - 0.75).abs() < 1e-6));
    assert_eq!(values.filled, 0);
    assert!(target.resolve(&estimates[1..]).is_err());
}

#[test]
fn a_fit_draws_steps_and_dark_corners_better_than_values_at_vertices_do() {
    // Fitted, sampled: 0.073, 0.086 for the step; 0.040, 0.095 for the corner; 0.0107, 0.0209 for the waves.
    let functions: [fn(Vec3) -> f32; 3] = [step, corner, waves];
    for (of, most) in functions.into_iter().zip([0.87, 0.45, 0.53]) {
        let (values, fitted, sampled) = errors(of, &VertexSettings::default());
        assert!(fitted < most * sampled, "{fitted} fitted, {sampled} sampled");
        assert!((values.misfit / fitted - 1.0).abs() < 0.1, "{} of {fitted}", values.misfit);
    }
    // Negative control: values that are too smooth lose against those at vertices.
    let (_, fitted, sampled) = errors(waves, &settings(10.0));
    assert!(fitted > 2.0 * sampled);
}

/// Mean over the surface of what is drawn between values.
fn mean(session: &Session, slots: &Slots, values: &[f32]) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (triangle, surface) in
        slots.surfaces().iter().flat_map(|s| (0..s.triangles.len()).map(move |t| (t, s)))
    {
        let [a, b, c] = session.bvh().world_corners(surface.instance, triangle as u32);
        let own = f64::from((b - a).cross(c - a).length());
        let shown: f32 = surface.corners(triangle).iter().map(|&slot| values[slot as usize]).sum();
        (sum, area) = (sum + own * f64::from(shown / 3.0), area + own);
    }
    sum / area
}

#[test]
fn a_dark_spot_at_a_vertex_darkens_its_triangles_by_as_much_as_it_covers() {
    // As a pole stands on a floor, with a radius of a quarter of a square.
    let at = sheet().positions()[(SIDE + 1) as usize * 6 + 6];
    let spot = |place: Vec3| if place.distance(at) < 0.25 / SIDE as f32 { 0.0 } else { 0.8 };
    let many = VertexSettings { samples_per_triangle: 256.0, ..VertexSettings::default() };
    let (session, target) = target(sheet(), &many, 0);
    let values = target.resolve(&estimates(target.points(), spot)).unwrap();
    let missing = |values: &[f32]| 1.0 - mean(&session, target.slots(), values) / 0.8;
    let covered = std::f64::consts::PI * 0.25 * 0.25 / f64::from(SIDE * SIDE);
    let found = missing(&values.visibility) / covered;
    assert!((found - 1.0).abs() < 0.1, "{found}");
    assert!(missing(&sampled(&session, target.slots(), spot)) > 4.0 * covered);
}

#[test]
fn noise_evens_out() {
    let noise = |place: Vec3| (hash_u32(place.x.to_bits() ^ place.y.to_bits()) % 1001) as f32 / 1000.0 - 0.5;
    let (session, target) = target(sheet(), &VertexSettings::default(), 0);
    let values = target.resolve(&estimates(target.points(), |place| 0.5 + 0.3 * noise(place))).unwrap();
    let off = rmse(&session, target.slots(), &values.visibility, |_| 0.5);
    // Its deviation is 0.3 / sqrt 12 = 0.087; a vertex has some 48 points about it.
    assert!(off < 0.025, "{off}");
    assert!((values.misfit - 0.087).abs() < 0.01, "{}", values.misfit);
}

#[test]
fn threads_change_no_bit() {
    let of_threads = |threads: usize| {
        let (session, target) = target(sheet(), &VertexSettings::default(), threads);
        let values = session.install(|| target.resolve(&estimates(target.points(), step)));
        (target.points().to_vec(), values.unwrap())
    };
    let one = of_threads(1);
    assert!(one.1.steps > 3);
    for threads in [2, 5] {
        assert!(of_threads(threads) == one, "{threads} threads");
    }
}

#[test]
fn what_no_estimate_tells_of_takes_what_is_about_it() {
    // A strip with a triangle of no area at its end, and a vertex that no triangle uses.
    let positions = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (2.0, 0.0), (3.0, 0.0), (9.0, 9.0)];
    let positions = positions.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
    let triangles = vec![[0, 1, 2], [1, 3, 2], [1, 4, 3], [1, 4, 5]];
    let mesh = TriangleMesh::new(positions, triangles).unwrap();
    let (_, target) = target(mesh, &settings(0.1), 0);
    assert_eq!((target.slots().count(), target.unusable()), (7, 0));
    // Nothing is known of the triangle with vertex 4.
    let known = |place: Vec3| if place.x > 1.0 { f32::NAN } else { 0.2 + 0.4 * place.x };
    let values = target.resolve(&estimates(target.points(), known)).unwrap();
    let expected = [0.2, 0.6, 0.2, 0.6, 0.6, 0.6, 1.0];
    let most = values.visibility.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(most < 1e-4, "{:?}", values.visibility);
    assert_eq!((values.filled, values.error[6]), (3, f32::INFINITY));
    assert!((values.error[5] - 0.01).abs() < 1e-6);
    let nothing = target.resolve(&vec![Estimate::PENDING; target.points().len()]).unwrap();
    assert_eq!((nothing.filled, nothing.visibility), (7, vec![1.0; 7]));
}

#[test]
fn hard_edges_keep_what_is_on_their_sides() {
    // Two squares at a right angle, one dark.
    let positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]];
    let positions = positions.map(|p| Vec3::from_array(p.map(|x| x as f32))).to_vec();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]];
    let (_, target) = target(TriangleMesh::new(positions, triangles).unwrap(), &settings(1.0), 0);
    let of = |place: Vec3| if place.z > 0.0 { 0.1 } else { 0.9 };
    let values = target.resolve(&estimates(target.points(), of)).unwrap();
    assert_eq!(values.visibility.len(), 8);
    let close = |value: &&f32, to: f32| (**value - to).abs() < 1e-4;
    let [dark, light] = [0.1, 0.9].map(|to| values.visibility.iter().filter(|v| close(v, to)).count());
    assert_eq!((dark, light), (4, 4), "{:?}", values.visibility);
}

proptest! {
    #[test]
    fn no_estimates_make_values_that_are_none(
        places in prop::collection::vec([-3i8..4, -3i8..4, 0i8..2], 3..10), scale in -4i32..5,
        triangles in prop::collection::vec([0u32..10, 0u32..10, 0u32..10], 1..12),
        shown in prop::collection::vec(prop_oneof![Just(f32::NAN), 0.0f32..=1.0], 16), smoothness in 0.0f32..10.0,
    ) {
        let count = places.len() as u32;
        let at = |place: &[i8; 3]| Vec3::from_array(place.map(f32::from)) * 10f32.powi(scale);
        let triangles = triangles.iter().map(|triangle| triangle.map(|vertex| vertex % count)).collect();
        let mesh = TriangleMesh::new(places.iter().map(at).collect(), triangles).unwrap();
        let (_, target) = target(mesh, &settings(smoothness), 0);
        let estimate = |(k, _)| Estimate { visibility: shown[k % 16], error: 0.1, ..Estimate::PENDING };
        let values = target.resolve(&target.points().iter().enumerate().map(estimate).collect::<Vec<_>>()).unwrap();
        prop_assert!(values.visibility.iter().all(|value| (0.0..=1.0).contains(value)), "{values:?}");
        prop_assert!(values.error.iter().all(|error| *error >= 0.0) && values.misfit.is_finite());
    }
}
