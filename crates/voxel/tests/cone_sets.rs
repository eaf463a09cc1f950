//! Sets of cones answer as single cones do, bit for bit, at every level of SIMD.

mod common;

use common::{Soup, random, still_life, turn};
use conray_core::{ConeSet, Falloff, Frame, HemisphereCones, Vec3, simd_levels};
use conray_voxel::{ConePoint, ConeQuery, ConeResult, Density, MarchOptions, Octree, OctreeOptions};

fn standing(apex: Vec3, normal: Vec3) -> ConePoint {
    ConePoint::about(normal, apex, normal)
}

#[derive(Clone, Copy, Debug)]
struct Settings {
    set: ConeSet,
    distance: f32,
    falloff: Falloff,
    options: MarchOptions,
}

impl Settings {
    fn new(set: ConeSet, distance: f32) -> Self {
        Self { set, distance, falloff: Falloff::None, options: MarchOptions::default() }
    }
}

fn singles(octree: &Octree, s: &Settings, cones: &HemisphereCones, point: &ConePoint) -> Vec<ConeResult> {
    let one = |cone: &conray_core::Cone| {
        let query = ConeQuery {
            apex: point.apex,
            axis: point.frame.to_world(cone.axis),
            half_angle_rad: cones.half_angle_rad(),
            normal: point.normal,
            distance: s.distance,
            falloff: s.falloff,
        };
        octree.march_with(&query, &s.options)
    };
    cones.cones().iter().map(one).collect()
}

fn bits(result: &ConeResult) -> (u32, u32) {
    (result.visibility.to_bits(), result.error.to_bits())
}

/// Compares all levels; returns how many cones met something and how many nothing.
fn check(octree: &Octree, settings: &Settings, points: &[ConePoint]) -> (usize, usize) {
    let cones = HemisphereCones::new(settings.set);
    let marches: Vec<_> = simd_levels()
        .into_iter()
        .map(|level| {
            let march = octree.cone_march(&cones, settings.distance, settings.falloff, &settings.options);
            (level, march.at_level(level))
        })
        .collect();
    let (mut met, mut open) = (0, 0);
    // One by one, some at a time and all together.
    for together in [1, 3, 8, points.len()] {
        for points in points.chunks(together).take(20) {
            let expected: Vec<_> = points.iter().flat_map(|p| singles(octree, settings, &cones, p)).collect();
            for (level, march) in &marches {
                let mut found = vec![ConeResult { visibility: f32::NAN, error: f32::NAN }; expected.len()];
                march.march(points, &mut found);
                for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let (point, cone) = (points[k / cones.cones().len()], k % cones.cones().len());
                    assert_eq!(
                        bits(found),
                        bits(expected),
                        "{level:?} {settings:?} cone {cone} of {point:?}, {together} together"
                    );
                }
            }
        }
    }
    for point in points {
        let expected = singles(octree, settings, &cones, point);
        let is_open = |r: &&ConeResult| **r == ConeResult { visibility: 1.0, error: 0.0 };
        let count = expected.iter().filter(is_open).count();
        (met, open) = (met + expected.len() - count, open + count);
    }
    (met, open)
}

/// Boxes and a ball on a floor; points on the floor, in the air and outside.
fn scene() -> (Soup, Vec<ConePoint>) {
    let soup = still_life();
    let point = |i: u32| {
        let place = Vec3::new(random(5 * i + 900), random(5 * i + 901), random(5 * i + 902));
        match i % 4 {
            0 => standing(place * Vec3::new(1.6, 1.6, 0.0) - Vec3::new(0.8, 0.8, 0.0), Vec3::Z),
            1 => standing(place * 2.4 - 1.2, turn(i) * Vec3::Z),
            2 => standing(place - 0.5, if i % 8 == 2 { Vec3::NEG_Z } else { Vec3::X }),
            _ => ConePoint {
                frame: Frame::from_normal((Vec3::Z + 0.3 * place).normalize()),
                ..standing(Vec3::new(place.x - 0.5, place.y - 0.5, 0.0), Vec3::Z)
            },
        }
    };
    (soup, (0..200).map(point).collect())
}

#[test]
fn all_sets_distances_and_falloffs() {
    let (soup, points) = scene();
    for (resolution, set) in
        [(32, ConeSet::Six), (64, ConeSet::Nine), (128, ConeSet::Sixteen), (64, ConeSet::TwentyFive)]
    {
        let octree = soup.octree(resolution);
        for distance in [0.1, 0.5, f32::INFINITY] {
            for falloff in [Falloff::None, Falloff::Linear, Falloff::Smooth] {
                let settings = Settings { falloff, ..Settings::new(set, distance) };
                let (met, open) = check(&octree, &settings, &points);
                assert!(met > 100 && open > 100, "{settings:?}: {met} met something, {open} nothing");
            }
        }
    }
}

/// Levels of every kind of storage: bits in blocks or plain, nodes in bricks or plain, reaching across bricks or not.
#[test]
fn fine_octrees_and_their_edges() {
    let (soup, mut points) = scene();
    let octree = soup.octree(512);
    let bounds = octree.bounds();
    for i in 0..100 {
        // On the cube's faces, where filters reach out of it.
        let mut place = Vec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2));
        place[i as usize % 3] = if i % 2 == 0 { 0.0 } else { 1.0 };
        points.push(standing(bounds.min + place * (bounds.max - bounds.min), turn(i) * Vec3::Z));
    }
    for distance in [0.02, 0.2, f32::INFINITY] {
        let (met, open) = check(&octree, &Settings::new(ConeSet::Sixteen, distance), &points);
        assert!(met > 100 && open > 100, "{distance}: {met} met something, {open} nothing");
    }
}

#[test]
fn other_steps_widths_and_lifts_and_opacities_by_axis() {
    let (soup, points) = scene();
    let directional = OctreeOptions { resolution: 64, directional: true, ..Default::default() };
    let octree = Octree::build(&soup.geometry(), &directional).unwrap();
    let usual = MarchOptions::default();
    for options in [
        MarchOptions { width: 1.0, ..usual },
        MarchOptions { width: 0.0, step: 4.0, ..usual },
        MarchOptions { lift: 0.0, step: 0.3, ..usual },
        MarchOptions { lift: -1.0, ..usual },
        MarchOptions { width: f32::NAN, ..usual },
        MarchOptions { density: Density::Axes, ..usual },
    ] {
        let (met, open) = check(&octree, &Settings { options, ..Settings::new(ConeSet::Nine, 0.5) }, &points);
        assert!(met > 100 && open > 50, "{options:?}: {met} met something, {open} nothing");
    }
}

#[test]
fn tiny_huge_and_far_scenes() {
    let (soup, points) = scene();
    let far = Vec3::new(148_376.0, 1234.0, -223_423.0);
    for (scale, offset) in [(1e-3f32, Vec3::ZERO), (1e6, Vec3::ZERO), (1.0, far), (1e-3, far), (1e6, far)] {
        let mut moved = soup.clone();
        moved.0.iter_mut().flatten().for_each(|c| *c = *c * scale + offset);
        let Ok(octree) =
            Octree::build(&moved.geometry(), &OctreeOptions { resolution: 64, ..Default::default() })
        else {
            // A millimetre so far away vanishes in single precision.
            assert!(scale < 1.0 && offset != Vec3::ZERO, "{scale} {offset}");
            continue;
        };
        let points: Vec<ConePoint> =
            points.iter().map(|p| ConePoint { apex: p.apex * scale + offset, ..*p }).collect();
        for distance in [0.5 * scale, f32::INFINITY] {
            let (met, open) = check(&octree, &Settings::new(ConeSet::Sixteen, distance), &points);
            assert!(met + open == 3200 && (met > 100 || scale < 1.0), "{scale} {offset}: {met}, {open}");
        }
    }
}

#[test]
fn bad_questions_are_told_and_do_no_harm() {
    let (soup, _) = scene();
    let octree = soup.octree(64);
    let bounds = octree.bounds();
    let middle = 0.5 * (bounds.min + bounds.max);
    let good = standing(Vec3::new(0.1, 0.2, 0.0), Vec3::Z);
    let mut points = vec![good];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, 1e30, 1e-30] {
        let bad = Vec3::splat(bad);
        points.push(ConePoint { apex: bad, ..good });
        points.push(ConePoint { normal: bad, ..good });
        points.push(ConePoint { frame: Frame { x: bad, y: bad, z: bad }, ..good });
        points.push(ConePoint { frame: Frame::from_normal(bad), ..good });
    }
    // On the faces, edges and corners of the cube, and beyond them.
    for i in 0..27 {
        let side = Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32) - 1.0;
        for reach in [1.0, 1.0 + 1e-6, 1.1, 3.0] {
            let apex = middle + (bounds.max - middle) * side * reach;
            points.extend([Vec3::Z, Vec3::NEG_Z, -side.normalize_or(Vec3::X)].map(|n| standing(apex, n)));
        }
    }
    for distance in [0.3, 0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, f32::MAX] {
        let (met, open) = check(&octree, &Settings::new(ConeSet::Sixteen, distance), &points);
        assert!(met + open == 16 * points.len());
        assert!(open > 0 || distance.is_nan(), "{distance}: everything met something");
    }
    let unknown = ConeResult { visibility: 0.0, error: f32::INFINITY };
    let told = singles(
        &octree,
        &Settings::new(ConeSet::Nine, 0.3),
        &HemisphereCones::new(ConeSet::Nine),
        &ConePoint { apex: Vec3::NAN, ..good },
    );
    assert!(told.iter().all(|r| *r == unknown));
}

#[test]
fn the_comparison_sees_a_single_bit() {
    let one = ConeResult { visibility: 0.5, error: 0.0 };
    let other = ConeResult { visibility: f32::from_bits(0.5f32.to_bits() + 1), ..one };
    assert_ne!(bits(&one), bits(&other));
    assert_ne!(bits(&one), bits(&ConeResult { error: -0.0, ..one }));
}

#[test]
#[should_panic(expected = "results for 9 cones")]
fn results_of_another_length_are_refused() {
    let octree = scene().0.octree(16);
    let cones = HemisphereCones::new(ConeSet::Nine);
    let march = octree.cone_march(&cones, 1.0, Falloff::None, &MarchOptions::default());
    march.march(&[standing(Vec3::ZERO, Vec3::Z)], &mut [ConeResult { visibility: 0.0, error: 0.0 }; 8]);
}
