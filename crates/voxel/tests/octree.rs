//! The octree against closed forms, exact clipping and itself.

mod common;

use common::{Soup, built, random, turn};
use conray_core::{
    Affine2, Affine3A, AlphaTexture, Geometry, Material, Opacity, TextureOpacity, Vec2, Vec3, Wrap,
};
use conray_voxel::{Octree, OctreeOptions, VoxelError};
use glam::{DVec3, IVec3};
use proptest::prelude::*;
use std::sync::Arc;

fn cells(level: u32, octree: &Octree) -> impl Iterator<Item = IVec3> + use<> {
    let side = (octree.resolution() >> level) as i32;
    (0..side.pow(3)).map(move |i| IVec3::new(i % side, i / side % side, i / side / side))
}

/// Sum over leaves of opacity times the area of a leaf's face.
fn total_area(octree: &Octree) -> f64 {
    let face = f64::from(octree.voxel_size()).powi(2);
    cells(0, octree).map(|c| f64::from(octree.mean_sd(0, c).0)).sum::<f64>() * face
}

/// The same across each axis.
fn axis_areas(octree: &Octree) -> DVec3 {
    let face = f64::from(octree.voxel_size()).powi(2);
    cells(0, octree).map(|c| octree.axis_opacities(0, c).unwrap().as_dvec3()).sum::<DVec3>() * face
}

fn directional(geometry: &Geometry, resolution: u32) -> Octree {
    let octree =
        Octree::build(geometry, &OctreeOptions { resolution, directional: true, ..Default::default() })
            .unwrap();
    octree.validate().unwrap();
    octree
}

#[test]
fn leaves_hold_the_area_of_axis_aligned_walls() {
    for normal in [Vec3::X, Vec3::NEG_Y, Vec3::Z] {
        let octree = Soup::default().square(Vec3::new(3.0, -7.0, 1.0), normal, 2.0).octree(64);
        let area = total_area(&octree);
        assert!((area - 16.0).abs() < 0.01, "{normal}: {area}");
        let finest = cells(0, &octree).filter(|&c| octree.mean_sd(0, c).0 > 0.99).count();
        assert!(finest > 58 * 58, "a wall is opaque: {finest}");
    }
}

#[test]
fn oblique_walls_cover_each_axis_by_their_projection() {
    for k in 0..4 {
        let normal = turn(k) * Vec3::Z;
        let areas = axis_areas(&directional(&Soup::default().square(Vec3::ZERO, normal, 1.0).geometry(), 64));
        let truth = 4.0 * normal.abs().as_dvec3();
        // Opacities are rounded to 255ths; about 5000 leaves are touched.
        assert!((areas - truth).abs().max_element() < 0.02, "{areas} {truth}");
        assert!((areas - truth.yzx()).abs().max_element() > 0.02, "the oracle must tell axes apart");
    }
}

trait Rotate {
    fn yzx(self) -> Self;
}

impl Rotate for DVec3 {
    fn yzx(self) -> Self {
        Self::new(self.y, self.z, self.x)
    }
}

#[test]
fn a_ball_covers_each_axis_twice_by_its_disc() {
    let areas = axis_areas(&directional(&Soup::default().ball(Vec3::ONE, 1.0, 64).geometry(), 128));
    // Two hemispheres; at the rim, where a leaf holds more than its face, opacity is held at 1.
    let truth = 2.0 * std::f64::consts::PI;
    assert!((areas / truth - 1.0).abs().max_element() < 0.03, "{areas} {truth}");
}

#[test]
fn tessellation_changes_nothing() {
    let coarse = Soup::default().square(Vec3::ZERO, turn(5) * Vec3::Z, 1.0);
    let mut fine = coarse.clone();
    for _ in 0..6 {
        fine.0 = fine
            .0
            .iter()
            .flat_map(|&[a, b, c]| {
                // Uneven cuts, so that edges fall anywhere.
                let (d, e) = (a.lerp(b, 0.4), b.lerp(c, 0.5));
                [[a, d, c], [d, b, e], [d, e, c]]
            })
            .collect();
    }
    let (coarse, fine) = (coarse.octree(64), fine.octree(64));
    for c in cells(0, &coarse) {
        let (a, b) = (coarse.mean_sd(0, c).0, fine.mean_sd(0, c).0);
        assert!((a - b).abs() < 1.5 / 255.0 + 1e-3, "{c}: {a} {b}");
    }
}

/// Whether a triangle comes within `grow` of a box, by clipping.
fn reaches(corners: [DVec3; 3], low: DVec3, high: DVec3, grow: f64) -> bool {
    let mut polygon = corners.to_vec();
    for axis in 0..3 {
        for (bound, sign) in [(low[axis] - grow, 1.0), (high[axis] + grow, -1.0)] {
            let inside = |p: DVec3| sign * (p[axis] - bound);
            let mut kept = Vec::new();
            for (k, &p) in polygon.iter().enumerate() {
                let q = polygon[(k + 1) % polygon.len()];
                if inside(p) >= 0.0 {
                    kept.push(p);
                }
                if inside(p) * inside(q) < 0.0 {
                    kept.push(p + (q - p) * (inside(p) / (inside(p) - inside(q))));
                }
            }
            polygon = kept;
        }
    }
    !polygon.is_empty()
}

fn check_emptiness(soup: &Soup) {
    let octree = soup.octree(16);
    let size = f64::from(octree.voxel_size());
    for c in cells(0, &octree) {
        let low = octree.origin().as_dvec3() + c.as_dvec3() * size;
        let near =
            |grow: f64| soup.0.iter().any(|t| reaches(t.map(Vec3::as_dvec3), low, low + size, grow * size));
        let empty = octree.is_empty(0, c);
        assert!(!(empty && near(0.0)), "{c} is touched and called empty");
        assert!(empty || near(0.01), "{c} is called occupied and nothing is near");
    }
}

fn corner() -> impl Strategy<Value = Vec3> {
    let number = || prop_oneof![-1.0f32..1.0, (-2i32..=2).prop_map(|i| i as f32 * 0.5)];
    (number(), number(), number()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]
    #[test]
    fn emptiness_equals_exact_clipping(
        any in prop::collection::vec((corner(), corner(), corner()), 1..6),
        sliver in (corner(), corner(), 0.0f32..1e-4),
        huge in corner(),
    ) {
        let mut soup = Soup(any.into_iter().map(|(a, b, c)| [a, b, c]).collect());
        soup.0.push([sliver.0, sliver.1, sliver.1 + sliver.2]);
        soup.0.push([huge * 20.0, Vec3::new(-3.0, 30.0, 1.0), Vec3::new(5.0, 1.0, -40.0)]);
        check_emptiness(&soup);
    }

    #[test]
    fn boxes_are_empty_only_where_their_leaves_are(a in corner(), b in corner()) {
        let soup = Soup::default().ball(Vec3::ZERO, 0.7, 6);
        let octree = soup.octree(32);
        let (low, high) = (1.3 * a.min(b), 1.3 * a.max(b));
        let size = f64::from(octree.voxel_size());
        let reached = |grow: f64| soup.0.iter().any(|t| {
            reaches(t.map(Vec3::as_dvec3), low.as_dvec3(), high.as_dvec3(), grow)
        });
        let empty = octree.box_is_empty(low, high);
        prop_assert!(!(empty && reached(0.0)), "touched and called empty");
        prop_assert!(empty || reached(2.0 * size), "nothing within two leaves");
    }
}

#[test]
fn half_filled_nodes_have_an_sd_of_half_their_range() {
    // A wall in one layer of leaves: its parents have half their leaves opaque, theirs a quarter, and so on.
    let octree = Soup::default().square(Vec3::ZERO, Vec3::X, 1.0).octree(128);
    let x = (0..128).find(|&x| octree.mean_sd(0, IVec3::new(x, 64, 64)).0 > 0.9).unwrap();
    for level in 1..=5 {
        let (mean, sd) = octree.mean_sd(level, IVec3::new(x, 64, 64) >> level as i32);
        let share = 0.5f32.powi(level as i32);
        assert!((mean - share).abs() < 1e-4, "level {level}: {mean} {share}");
        assert!((sd - (share * (1.0 - share)).sqrt()).abs() < 1e-4, "level {level}: {sd}");
    }
}

#[test]
fn threads_change_no_bit() {
    let mut soup = Soup::default().square(Vec3::ZERO, Vec3::Y, 1.0);
    for k in 0..40 {
        let centre = Vec3::new(random(9 * k), random(9 * k + 1), random(9 * k + 2)) - 0.5;
        soup = soup.cuboid(centre, Vec3::splat(0.02 + 0.1 * random(9 * k + 3)), turn(k));
    }
    let geometry = soup.geometry();
    let facts = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let octree = pool.install(|| directional(&geometry, 64));
        let nodes: Vec<_> = (0..octree.levels())
            .flat_map(|l| cells(l, &octree).map(move |c| (l, c)))
            .map(|(l, c)| (octree.mean_sd(l, c), octree.is_empty(l, c), octree.axis_opacities(l, c)))
            .collect();
        (octree.stats(), nodes)
    };
    let one = facts(1);
    for threads in [2, 5] {
        assert!(facts(threads) == one, "{threads} threads");
    }
}

#[test]
fn moving_a_scene_by_whole_voxels_moves_the_octree() {
    let soup = Soup::default().ball(Vec3::ZERO, 1.0, 8);
    // Coordinates in 256ths move by powers of two without rounding.
    let snapped = Soup(soup.0.iter().map(|t| t.map(|c| (c * 256.0).round() / 256.0)).collect());
    let shift = Vec3::new(64.0, -32.0, 16.0);
    let moved = Soup(snapped.0.iter().map(|t| t.map(|c| c + shift)).collect());
    let (a, b) = (snapped.octree(64), moved.octree(64));
    assert_eq!(a.voxel_size(), b.voxel_size());
    let mut most = 0.0f32;
    for l in 0..a.levels() {
        for c in cells(l, &a) {
            most = most.max((a.mean_sd(l, c).0 - b.mean_sd(l, c).0).abs());
        }
    }
    // The corner of the cube is rounded to single precision, some 1e-5 of a voxel.
    assert!(most < 0.01, "{most}");
}

fn masked_sheet(cutoff: Option<f32>, uv_scale: f32) -> Geometry {
    // A texture of which every fourth texel is opaque, in blocks.
    let texels = (0..64 * 64).map(|i| if (i / 4) % 2 == 0 && (i / 256) % 2 == 0 { 255 } else { 0 }).collect();
    let texture = Arc::new(AlphaTexture::new(64, 64, texels).unwrap());
    let mut geometry = Geometry::default();
    let material = geometry.add_material(Material {
        opacity: Opacity::Texture(TextureOpacity {
            texture,
            uv_set: 0,
            texture_from_uv: Affine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            factor: 1.0,
            cutoff,
        }),
        ..Default::default()
    });
    let soup = Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0);
    let uvs = soup.0.iter().flatten().map(|p| Vec2::new(p.x, p.y) * uv_scale).collect();
    let mesh = soup.mesh().with_uv_set(uvs).unwrap().with_material(material);
    let mesh = geometry.add_mesh(mesh).unwrap();
    geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    geometry
}

#[test]
fn masked_sheets_hold_the_mean_of_their_mask() {
    for cutoff in [None, Some(0.5)] {
        for uv_scale in [0.5, 7.3] {
            for resolution in [16, 64, 128] {
                let area = total_area(&built(&masked_sheet(cutoff, uv_scale), resolution));
                assert!((area - 1.0).abs() < 0.06, "cutoff {cutoff:?}, uv {uv_scale}, {resolution}: {area}");
            }
        }
    }
}

#[test]
fn constant_opacity_is_kept_and_glass_is_left_out() {
    let sheet = |opacity: f32| {
        let mut geometry = Geometry::default();
        let opacity = Opacity::Constant(opacity);
        let material = geometry.add_material(Material { opacity, ..Default::default() });
        let mesh = Soup::default().square(Vec3::ZERO, Vec3::Y, 1.0).mesh().with_material(material);
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        geometry
    };
    assert!((total_area(&built(&sheet(0.3), 32)) - 1.2).abs() < 0.02);
    assert_eq!(Octree::build(&sheet(0.0), &OctreeOptions::default()).unwrap_err(), VoxelError::NoExtent);
}

#[test]
fn instances_are_where_their_transforms_put_them() {
    let mut geometry = Geometry::default();
    let mesh = geometry.add_mesh(Soup::default().square(Vec3::ZERO, Vec3::Z, 1.0).mesh()).unwrap();
    for k in 0..5 {
        let place = Affine3A::from_translation(Vec3::new(0.0, 0.0, 0.5 * k as f32));
        geometry.add_instance(mesh, place).unwrap();
    }
    let octree = built(&geometry, 64);
    assert!((total_area(&octree) - 20.0).abs() < 0.05);
    let between = octree.box_is_empty(Vec3::new(-0.9, -0.9, 0.2), Vec3::new(0.9, 0.9, 0.3));
    assert!(between && !octree.box_is_empty(Vec3::new(-0.9, -0.9, 0.2), Vec3::new(0.9, 0.9, 0.5)));
}

#[test]
fn singular_transforms_do_no_harm() {
    let mut geometry = Soup::default().cuboid(Vec3::ZERO, Vec3::ONE, turn(1)).geometry();
    for scale in [Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 2.0, 0.0), Vec3::ZERO, Vec3::new(-1.0, 1e-20, 1.0)]
    {
        geometry.add_instance(0, Affine3A::from_scale(scale)).unwrap();
    }
    built(&geometry, 32);
}

#[test]
fn scale_and_place_do_not_matter() {
    let reference = Soup::default().ball(Vec3::ZERO, 1.0, 8).octree(32);
    for (scale, offset) in [(1e-3, 0.0), (1e6, 0.0), (1.0, 1e4), (1e-30, 0.0), (1e30, 0.0)] {
        let mut soup = Soup::default().ball(Vec3::ZERO, 1.0, 8);
        soup.0.iter_mut().flatten().for_each(|c| *c = *c * scale + offset);
        let octree = soup.octree(32);
        let mut errors = Vec::new();
        for c in cells(0, &octree) {
            errors.push(octree.mean_sd(0, c).0 - reference.mean_sd(0, c).0);
        }
        let rmse = common::root_mean_square(errors);
        assert!(rmse < 0.01, "scale {scale}, offset {offset}: {rmse}");
    }
    // Where single precision has no room for the shape, there is still an octree.
    let mut far = Soup::default().ball(Vec3::ZERO, 1e-3, 8);
    far.0.iter_mut().flatten().for_each(|c| *c += Vec3::new(148_376.0, 1234.0, -223_423.0));
    match Octree::build(&far.geometry(), &OctreeOptions { resolution: 64, ..Default::default() }) {
        Ok(octree) => octree.validate().unwrap(),
        Err(error) => assert_eq!(error, VoxelError::NoExtent),
    }
}

#[test]
fn what_cannot_be_built_is_refused_by_name() {
    let build = |g: &Geometry, options: OctreeOptions| Octree::build(g, &options).unwrap_err();
    assert_eq!(build(&Geometry::default(), OctreeOptions::default()), VoxelError::NoExtent);
    let point = Soup(vec![[Vec3::ONE; 3]]).geometry();
    assert_eq!(build(&point, OctreeOptions::default()), VoxelError::NoExtent);
    let ball = Soup::default().ball(Vec3::ZERO, 1.0, 4).geometry();
    for resolution in [0, 8, 100, 4096, u32::MAX] {
        let options = OctreeOptions { resolution, ..Default::default() };
        assert_eq!(build(&ball, options), VoxelError::Resolution(resolution));
        assert_eq!(Octree::estimate_memory(&ball, resolution), 0);
    }
    let huge = Soup::default().ball(Vec3::ZERO, 3e38, 4).geometry();
    assert!(matches!(build(&huge, OctreeOptions::default()), VoxelError::TooLarge(_)));
}

#[test]
fn a_line_has_an_octree_without_opacity() {
    let line = Soup(vec![[Vec3::ZERO, Vec3::ONE, Vec3::splat(0.3)]]);
    let octree = line.octree(32);
    assert_eq!(total_area(&octree), 0.0);
    assert!(octree.stats().occupied[0] >= 28, "{:?}", octree.stats());
}

#[test]
fn a_limit_of_memory_steps_the_resolution_down() {
    let geometry = Soup::default().ball(Vec3::ZERO, 1.0, 16).geometry();
    let needs = [16, 32, 64, 128, 256].map(|n| (n, Octree::estimate_memory(&geometry, n)));
    assert!(needs.is_sorted_by(|a, b| a.1 < b.1), "{needs:?}");
    for (resolution, limit) in needs {
        let options = OctreeOptions { resolution: 256, max_memory_bytes: Some(limit), ..Default::default() };
        let octree = Octree::build(&geometry, &options).unwrap();
        assert_eq!((octree.resolution(), octree.stats().peak_bytes), (resolution, limit));
        assert!(octree.memory_bytes() <= limit);
    }
    let limit = needs[0].1 - 1;
    let options = OctreeOptions { max_memory_bytes: Some(limit), ..Default::default() };
    let error = Octree::build(&geometry, &options).unwrap_err();
    assert_eq!(error, VoxelError::MemoryLimit { resolution: 16, needed: limit + 1, limit });
}

#[test]
fn what_is_outside_is_empty() {
    let octree = Soup::default().ball(Vec3::ZERO, 1.0, 6).octree(16);
    for c in [IVec3::splat(-1), IVec3::splat(16), IVec3::new(3, 3, i32::MAX), IVec3::MIN] {
        assert!(octree.is_empty(0, c) && octree.mean_sd(0, c) == (0.0, 0.0), "{c}");
    }
    assert!(octree.is_empty(99, IVec3::ZERO));
    for p in [Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e30), Vec3::new(-5.0, 0.0, 0.0)] {
        assert_eq!(octree.sample(0.5, p), Default::default(), "{p}");
    }
    assert!(octree.box_is_empty(Vec3::splat(2.0), Vec3::splat(1e30)));
    assert!(!octree.box_is_empty(Vec3::NEG_INFINITY, Vec3::INFINITY));
    assert!(!octree.box_is_empty(Vec3::NAN, Vec3::ONE));
}

#[test]
fn samples_interpolate_between_centres_and_levels() {
    let octree = Soup::default().ball(Vec3::ZERO, 1.0, 12).octree(64);
    let centre = |level: u32, c: IVec3| {
        octree.origin() + (c.as_vec3() + 0.5) * (octree.voxel_size() * (1 << level) as f32)
    };
    let mut compared = 0;
    for level in 0..4 {
        for c in cells(level, &octree).filter(|&c| !octree.is_empty(level, c)).step_by(7) {
            let (at, next) = (octree.mean_sd(level, c), octree.mean_sd(level, c + IVec3::Y));
            let sample = octree.sample(level as f32, centre(level, c));
            assert!((sample.mean - at.0).abs() < 1e-3 && (sample.sd - at.1).abs() < 1e-3, "{level} {c}");
            let between = centre(level, c).lerp(centre(level, c + IVec3::Y), 0.25);
            let sample = octree.sample(level as f32, between);
            assert!((sample.mean - (0.75 * at.0 + 0.25 * next.0)).abs() < 1e-3, "{level} {c}");
            let (low, high) =
                (octree.sample(level as f32, between), octree.sample(level as f32 + 1.0, between));
            let mixed = octree.sample(level as f32 + 0.3, between).mean;
            assert!((mixed - (0.7 * low.mean + 0.3 * high.mean)).abs() < 1e-3, "{level} {c}");
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
}
