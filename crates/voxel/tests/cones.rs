//! Cones against closed forms and against rays.

mod common;

use common::{Ask, Soup, built, by_cones, random, root_mean_square, turn};
use conray_core::{ConeSet, Falloff, HemisphereCones, Vec3};
use conray_voxel::{ConeQuery, ConeResult, MarchOptions, Octree};
use proptest::prelude::*;

/// Points on a plane of half-size 1 under a rotation, away from its rim.
fn plane_errors(options: &MarchOptions, set: ConeSet) -> Vec<f32> {
    let mut errors = Vec::new();
    for k in 0..6 {
        let normal = if k == 0 { Vec3::Y } else { turn(k) * Vec3::Z };
        let octree = Soup::default().square(Vec3::ZERO, normal, 1.0).octree(128);
        let tangent = normal.any_orthonormal_vector();
        for i in 0..20 {
            let along = |n: u32| random(50 * k + 2 * i + n) - 0.5;
            let position = tangent * along(0) + normal.cross(tangent) * along(1);
            let ask = Ask { position, normal, distance: 0.5, seed: 0 };
            errors.push(1.0 - by_cones(&octree, &ask, set, options));
        }
    }
    errors
}

#[test]
fn a_plane_does_not_darken_itself() {
    for set in ConeSet::ALL {
        let errors = plane_errors(&MarchOptions::default(), set);
        let worst = errors.iter().fold(0.0f32, |a, &b| a.max(b));
        println!("plane, {set} cones: worst {worst:.4}");
        assert!(worst < 0.015, "{set}: {worst}");
    }
    let careless = MarchOptions { lift: 0.5, ..Default::default() };
    assert!(
        root_mean_square(plane_errors(&careless, ConeSet::Sixteen)) > 0.1,
        "the oracle must be able to fail"
    );
}

/// Cones against rays in a scene: RMSE over points.
fn rmse(soup: &Soup, octree: &Octree, asks: &[Ask], set: ConeSet) -> f32 {
    let cones = HemisphereCones::new(ConeSet::TwentyFive);
    let error =
        |ask: &Ask| by_cones(octree, ask, set, &MarchOptions::default()) - soup.visibility(ask, &cones, 24);
    root_mean_square(asks.iter().map(error))
}

#[test]
fn a_wall_darkens_with_its_distance_as_rays_say() {
    for k in 0..3 {
        let q = if k == 0 { conray_core::Quat::IDENTITY } else { turn(k) };
        let floor = Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0);
        let scene = floor.clone().square(Vec3::new(-0.5, 0.0, 0.5), Vec3::X, 1.0).turned(q);
        let octree = scene.octree(256);
        let asks: Vec<Ask> = (1..30)
            .map(|i| Ask {
                position: q * Vec3::new(-0.5 + 0.012 * i as f32, 0.1, 0.0),
                normal: q * Vec3::Z,
                distance: 0.3,
                seed: i,
            })
            .collect();
        let found = rmse(&scene, &octree, &asks, ConeSet::Sixteen);
        println!("wall, turn {k}: RMSE {found:.3}");
        assert!(found < 0.06, "turn {k}: {found}");
        // Without the wall in the octree the same comparison must fail.
        assert!(rmse(&scene, &floor.turned(q).octree(256), &asks, ConeSet::Sixteen) > 0.15);
    }
}

#[test]
fn infinite_walls_close_a_half_and_their_corner_three_quarters() {
    // Walls tall against the height of the point; 1/2 and 1/4 are the closed forms next to infinite walls.
    let floor = Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0);
    let wall = floor.clone().square(Vec3::new(-0.5, 0.0, 1.0), Vec3::X, 1.0);
    let corner = wall.clone().square(Vec3::new(0.0, -0.5, 1.0), Vec3::Y, 1.0);
    let at = |soup: &Soup, x: f32, y: f32| {
        let ask = Ask { position: Vec3::new(x, y, 0.0), normal: Vec3::Z, distance: f32::INFINITY, seed: 0 };
        by_cones(&soup.octree(256), &ask, ConeSet::Sixteen, &MarchOptions::default())
    };
    let (open, half, quarter) = (at(&floor, -0.45, 0.0), at(&wall, -0.45, 0.0), at(&corner, -0.45, -0.45));
    println!("open {open:.3}, wall {half:.3}, corner {quarter:.3}");
    assert!((open - 1.0).abs() < 0.01);
    assert!((half - 0.5).abs() < 0.12, "{half}");
    assert!((quarter - 0.25).abs() < 0.15, "{quarter}");
}

#[test]
fn discs_and_balls_overhead() {
    let floor = Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0);
    let ask = Ask { position: Vec3::ZERO, normal: Vec3::Z, distance: f32::INFINITY, seed: 0 };
    let by = |soup: Soup| by_cones(&soup.octree(256), &ask, ConeSet::TwentyFive, &MarchOptions::default());
    let mut errors = Vec::new();
    for (radius, height) in [(0.1f32, 0.3f32), (0.2, 0.3), (0.3, 0.3), (0.5, 0.4), (0.8, 0.3)] {
        let truth = 1.0 - radius.powi(2) / (radius.powi(2) + height.powi(2));
        let found = by(floor.clone().disc(Vec3::new(0.0, 0.0, height), radius));
        println!("disc {radius} at {height}: {found:.3}, truth {truth:.3}");
        errors.push(found - truth);
    }
    for (radius, centre) in [(0.1f32, Vec3::new(0.0, 0.0, 0.3)), (0.2, Vec3::new(0.2, 0.1, 0.35))] {
        let d = centre.length();
        let truth = 1.0 - (radius / d).powi(2) * centre.z / d;
        let found = by(floor.clone().ball(centre, radius, 24));
        println!("ball {radius} at {centre}: {found:.3}, truth {truth:.3}");
        errors.push(found - truth);
    }
    // Cells that the disc's rim divides count as wholly open or closed.
    let found = root_mean_square(errors);
    println!("discs and balls: RMSE {found:.3}");
    assert!(found < 0.15, "{found}");
    assert!((by(floor) - 1.0).abs() < 0.01);
}

#[test]
fn ceilings_count_within_the_distance_only_and_by_their_opacity() {
    let scene = |opacity: f32| {
        let mut geometry = conray_core::Geometry::default();
        for (opacity, height) in [(1.0, 0.0), (opacity, 0.2)] {
            let opacity = conray_core::Opacity::Constant(opacity);
            let material = geometry.add_material(conray_core::Material { opacity, ..Default::default() });
            let sheet = Soup::default().square(Vec3::new(0.0, 0.0, height), Vec3::Z, 1.0);
            let mesh = geometry.add_mesh(sheet.mesh().with_material(material)).unwrap();
            geometry.add_instance(mesh, conray_core::Affine3A::IDENTITY).unwrap();
        }
        built(&geometry, 256)
    };
    let at = |octree: &Octree, distance: f32| {
        let ask = Ask { position: Vec3::ZERO, normal: Vec3::Z, distance, seed: 0 };
        by_cones(octree, &ask, ConeSet::TwentyFive, &MarchOptions::default())
    };
    let opaque = scene(1.0);
    // Below the ceiling, well clear of the filter.
    assert!(at(&opaque, 0.12) > 0.97, "{}", at(&opaque, 0.12));
    for distance in [0.25f32, 0.3, 0.4] {
        let (found, truth) = (at(&opaque, distance), (0.2 / distance).powi(2));
        println!("ceiling within {distance}: {found:.3}, truth {truth:.3}");
        assert!((found - truth).abs() < 0.2, "{distance}: {found} {truth}");
    }
    // Seen through a ceiling of opacity a: 1 - a, but for what passes the ceiling's rim or the distance.
    let seen = [0.0f32, 0.25, 0.5, 0.75, 1.0].map(|a| (1.0 - a, at(&scene(a), 1.5)));
    println!("ceilings by opacity: {seen:.3?}");
    assert!(seen.iter().all(|(truth, found)| (truth - found).abs() < 0.1), "{seen:?}");
    assert!(seen.is_sorted_by(|a, b| a.1 > b.1));
}

/// Boxes and balls on a floor, and points on the floor.
fn still_life() -> (Soup, Vec<Ask>) {
    let soup = common::still_life();
    let ask = |i: u32| Ask {
        position: Vec3::new(random(2 * i + 900) - 0.5, random(2 * i + 901) - 0.5, 0.0),
        normal: Vec3::Z,
        distance: 0.35,
        seed: i,
    };
    (soup, (0..60).map(ask).collect())
}

#[test]
fn cones_approach_rays_as_voxels_and_apertures_shrink() {
    let (soup, asks) = still_life();
    let curve =
        [(32, ConeSet::Nine), (64, ConeSet::Nine), (128, ConeSet::Sixteen), (256, ConeSet::TwentyFive)]
            .map(|(resolution, set)| rmse(&soup, &soup.octree(resolution), &asks, set));
    println!("RMSE at 32, 64, 128, 256 voxels: {curve:.3?}");
    assert!(curve[0] > 1.5 * curve[3], "{curve:?}");
    assert!(curve[1] > curve[3] && curve[3] < 0.08, "{curve:?}");
}

#[test]
fn the_ring_under_a_ball() {
    let soup = Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0).ball(Vec3::new(0.0, 0.0, 0.3), 0.3, 16);
    // From two voxels of clearance: nearer the contact, the lift takes samples through the ball's shell.
    let asks: Vec<Ask> = (5..40)
        .map(|i| Ask {
            position: Vec3::new(0.02 * i as f32, 0.0, 0.0),
            normal: Vec3::Z,
            distance: 0.4,
            seed: i,
        })
        .collect();
    let found = rmse(&soup, &soup.octree(256), &asks, ConeSet::Sixteen);
    println!("ball on a plane: RMSE {found:.3}");
    assert!(found < 0.1, "{found}");
}

fn query() -> impl Strategy<Value = ConeQuery> {
    let number =
        || prop_oneof![8 => -1.5f32..1.5, 1 => Just(f32::NAN), 1 => -1e30f32..1e30, 1 => Just(0.0f32)];
    let vector = move || (number(), number(), number()).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let angle = prop_oneof![0.0f32..1.5, Just(0.0f32), Just(f32::NAN), Just(1e9f32)];
    let distance = prop_oneof![0.0f32..2.0, Just(f32::INFINITY), Just(f32::NAN), Just(-1.0f32)];
    let falloff = prop_oneof![Just(Falloff::None), Just(Falloff::Linear), Just(Falloff::Smooth)];
    (vector(), vector(), vector(), angle, distance, falloff).prop_map(
        |(apex, axis, normal, half_angle_rad, distance, falloff)| ConeQuery {
            apex,
            axis: axis.try_normalize().unwrap_or(axis),
            half_angle_rad,
            normal: normal.try_normalize().unwrap_or(normal),
            distance,
            falloff,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]
    #[test]
    fn any_question_has_an_answer(query in query()) {
        thread_local!(static OCTREE: Octree = still_life().0.octree(64));
        let r = OCTREE.with(|octree| octree.march(&query));
        prop_assert!((0.0..=1.0).contains(&r.visibility) && r.error >= 0.0, "{r:?}");
    }

    #[test]
    fn a_longer_distance_never_opens_a_cone(query in query(), share in 0.0f32..1.0) {
        thread_local!(static OCTREE: Octree = still_life().0.octree(64));
        prop_assume!(query.distance > 0.0);
        let far = ConeQuery { falloff: Falloff::None, distance: query.distance.min(10.0), ..query };
        let near = ConeQuery { distance: far.distance * share, ..far };
        let (near, far) = OCTREE.with(|octree| (octree.march(&near), octree.march(&far)));
        prop_assert!(near.visibility >= far.visibility - 1e-6, "{near:?} {far:?}");
    }
}

#[test]
fn falloffs_count_far_occluders_less() {
    let octree = Soup::default()
        .square(Vec3::ZERO, Vec3::Z, 1.0)
        .square(Vec3::new(0.0, 0.0, 0.3), Vec3::Z, 1.0)
        .octree(128);
    let by = |falloff: Falloff| {
        let query = ConeQuery {
            apex: Vec3::ZERO,
            axis: Vec3::Z,
            half_angle_rad: 0.3,
            normal: Vec3::Z,
            distance: 0.6,
            falloff,
        };
        octree.march(&query).visibility
    };
    let (none, linear, smooth) = (by(Falloff::None), by(Falloff::Linear), by(Falloff::Smooth));
    // All that blocks is at half the distance, where both fall-offs weigh 1/2.
    assert!((linear - (1.0 - 0.5 * (1.0 - none))).abs() < 0.05, "{none} {linear}");
    assert!((smooth - linear).abs() < 0.05, "{linear} {smooth}");
}

#[test]
fn empty_paths_are_exactly_open_and_bad_questions_are_told() {
    let octree = Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0).octree(64);
    let query = ConeQuery {
        apex: Vec3::ZERO,
        axis: Vec3::Z,
        half_angle_rad: 0.3,
        normal: Vec3::Z,
        distance: f32::INFINITY,
        falloff: Falloff::None,
    };
    assert_eq!(octree.march(&query), ConeResult { visibility: 1.0, error: 0.0 });
    let bad = octree.march(&ConeQuery { axis: Vec3::NAN, ..query });
    assert_eq!(bad, ConeResult { visibility: 0.0, error: f32::INFINITY });
    // From outside, into the surface: a needle meets the sheet once.
    let into = ConeQuery { apex: Vec3::new(0.1, 0.1, 5.0), axis: Vec3::NEG_Z, half_angle_rad: 0.0, ..query };
    let needle = octree.march(&ConeQuery { normal: Vec3::NEG_Z, ..into });
    assert!(needle.visibility < 0.1, "{needle:?}");
}

#[test]
fn axis_opacities_close_rooms_as_means_do() {
    let soup =
        Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0).square(Vec3::new(0.0, 0.0, 0.4), Vec3::Z, 1.0);
    let options = conray_voxel::OctreeOptions { resolution: 128, directional: true, ..Default::default() };
    let octree = Octree::build(&soup.geometry(), &options).unwrap();
    let ask = Ask { position: Vec3::ZERO, normal: Vec3::Z, distance: f32::INFINITY, seed: 0 };
    let found = by_cones(&octree, &ask, ConeSet::Sixteen, &MarchOptions::axes());
    let plain = by_cones(&octree, &ask, ConeSet::Sixteen, &MarchOptions::default());
    println!("under a ceiling: {found:.3} by axes, {plain:.3} by means");
    assert!(found < 0.1 && plain < 0.1);
}
