//! Ray for ray against all triangles in double precision. The two may differ only where a ray passes an outline, the
//! origin's plane or its end within a stated distance; such rays are counted and must be few.

mod common;

use common::brute::{Truth, trace};
use common::shapes::soup;
use common::{Random, Scene};
use conray_bvh::Bvh;
use conray_core::{Affine3A, AlphaTexture, Mat3A, Opacity, Ray, TextureOpacity, Vec2, Vec3, Wrap};
use std::sync::Arc;

/// How near to an outline a ray may pass before the oracle abstains, as a share of the largest coordinate difference.
const TOLERANCE: f64 = 4e-6;

#[derive(Default)]
struct Tally {
    judged: u32,
    doubtful: u32,
    hits: u32,
}

/// Compares both queries for one ray; returns what differs.
fn compare(bvh: &Bvh, ray: &Ray, truth: &Truth, reach: f64, tally: &mut Tally) -> Result<(), String> {
    let geometry = bvh.geometry();
    let opacity = |h: &common::brute::TrueHit| {
        let mesh = geometry.instances()[h.instance as usize].mesh as usize;
        geometry.opacity_at(mesh, h.triangle as usize, h.u as f32, h.v as f32)
    };
    let first = truth.hits.iter().find(|h| opacity(h) >= 0.5);
    let doubt_before = |t: f64| truth.doubtful.iter().any(|&d| d < t + 1e-3 * reach);
    tally.judged += 1;
    if doubt_before(f64::INFINITY) {
        tally.doubtful += 1;
    } else {
        let expected: f32 = truth.hits.iter().map(|h| 1.0 - opacity(h)).product();
        let found = bvh.transmittance(ray);
        if (found - expected).abs() > 1e-4 {
            return Err(format!("transmittance {found} instead of {expected} for {ray:?}: {:?}", truth.hits));
        }
    }
    if doubt_before(first.map_or(f64::INFINITY, |h| h.t)) {
        return Ok(());
    }
    match (first, bvh.nearest(ray)) {
        (None, None) => Ok(()),
        (Some(t), Some(h)) => {
            tally.hits += 1;
            let slack = 1e-6 * t.t + 1e-9 * reach / t.cosine.max(1e-6);
            let same = (t.instance, t.triangle) == (h.instance, h.triangle)
                && (t.u - f64::from(h.u)).abs() < 1e-4
                && (t.v - f64::from(h.v)).abs() < 1e-4;
            let tied = truth.hits.iter().any(|o| {
                (o.instance, o.triangle) == (h.instance, h.triangle) && (o.t - t.t).abs() <= 2.0 * slack
            });
            if (t.t - f64::from(h.t)).abs() <= slack && (same || tied) {
                Ok(())
            } else {
                Err(format!("{h:?} instead of {t:?} for {ray:?}"))
            }
        }
        (t, h) => Err(format!("{h:?} instead of {t:?} for {ray:?}")),
    }
}

fn check(bvh: &Bvh, rays: u32, centre: Vec3, scale: f32, random: &mut Random) -> Tally {
    let reach = 4.0 * f64::from(scale) + 1e-7 * f64::from(centre.abs().max_element());
    let mut tally = Tally::default();
    for i in 0..rays {
        let origin = centre + 1.5 * scale * random.cube();
        let direction = match i % 8 {
            0 => [Vec3::X, Vec3::NEG_Y, Vec3::Z][random.below(3)],
            1 => Vec3::new(random.signed(), 0.0, random.signed()).normalize_or(Vec3::X),
            _ => random.direction(),
        };
        let t_max = if i % 3 == 0 { scale * random.unit() } else { f32::INFINITY };
        let ray = Ray { origin, direction, t_max };
        let truth = trace(bvh.geometry(), &ray, TOLERANCE * reach);
        compare(bvh, &ray, &truth, reach, &mut tally).unwrap();
    }
    tally
}

fn few_doubts(tally: &Tally) {
    assert!(tally.judged > 0 && tally.hits * 10 > tally.judged, "too few hits: {}", tally.hits);
    assert!(tally.doubtful * 20 < tally.judged, "{} of {} rays are doubtful", tally.doubtful, tally.judged);
}

#[test]
fn soups_of_every_scale_and_place() {
    let mut random = Random(1);
    for (centre, scale) in [
        (Vec3::ZERO, 1.0f32),
        (Vec3::ZERO, 1e-6),
        (Vec3::ZERO, 1e6),
        (Vec3::ZERO, 1e-18),
        (Vec3::ZERO, 1e18),
        (Vec3::new(148_376.0, 1234.0, -223_423.0), 1e3),
    ] {
        let bvh = Scene::default().with(soup(300, centre, scale, &mut random)).bvh();
        few_doubts(&check(&bvh, 1000, centre, scale, &mut random));
    }
}

/// Rotation, scales of both signs, shear and a shift.
fn placement(random: &mut Random) -> Affine3A {
    let mut column = || random.cube() * 0.6;
    let matrix = Mat3A::from_cols(column().into(), column().into(), column().into());
    Affine3A::from_mat3_translation(matrix.into(), 0.5 * random.cube())
}

fn leaves() -> Opacity {
    let texels = (0..64 * 64).map(|i| (127.5 + 127.5 * (i as f32 * 0.01).sin()) as u8).collect();
    Opacity::Texture(TextureOpacity {
        texture: Arc::new(AlphaTexture::new(64, 64, texels).unwrap()),
        uv_set: 0,
        texture_from_uv: conray_core::Affine2::IDENTITY,
        wrap: [Wrap::Mirror; 2],
        factor: 0.9,
        cutoff: None,
    })
}

#[test]
fn instances_with_all_kinds_of_opacity() {
    let mut random = Random(2);
    let (mut judged, mut instanced) = (0, 0);
    for _ in 0..4 {
        let small = |random: &mut Random| soup(300, Vec3::ZERO, 1.0, random);
        let uvs = (0..900).map(|_| Vec2::new(random.unit(), random.unit())).collect();
        let textured = small(&mut random).with_uv_set(uvs).unwrap();
        let mut places = |n: u32| (0..n).map(|_| placement(&mut random)).collect::<Vec<_>>();
        let (four, three, flat) = (places(4), places(4), places(1));
        let bvh = Scene::default()
            .with_opacity(small(&mut random), Opacity::Constant(1.0), &four)
            .with_opacity(small(&mut random), Opacity::Constant(0.4), &three)
            .with_opacity(textured, leaves(), &flat)
            .bvh();
        instanced += bvh.stats().instances;
        judged += check(&bvh, 300, Vec3::ZERO, 1.0, &mut random).judged;
    }
    assert_eq!((judged, instanced), (1200, 4 * 8));
}

#[test]
fn singular_instances_are_flat_sheets_or_nothing() {
    let mut random = Random(3);
    let flat = Affine3A::from_translation(Vec3::Z * 0.3) * Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
    let nearly = Affine3A::from_scale(Vec3::new(1.0, 1e-20, 1.0));
    let nothing = Affine3A::from_scale(Vec3::ZERO);
    let line = Affine3A::from_scale(Vec3::X);
    let places = [flat, nothing, Affine3A::IDENTITY, line, nearly];
    let mesh = soup(400, Vec3::ZERO, 1.0, &mut random);
    let bvh = Scene::default().with_opacity(mesh, Opacity::Constant(1.0), &places).bvh();
    assert!(bvh.stats().instances >= 1 && bvh.stats().placed_triangles > 1000);
    // Overlapping slivers in one plane make most rays doubtful: only that the others agree is asked.
    let tally = check(&bvh, 500, Vec3::ZERO, 1.0, &mut random);
    assert!(tally.hits > 100);
}

#[test]
fn the_comparison_can_fail() {
    let mut random = Random(4);
    let mesh = soup(300, Vec3::ZERO, 1.0, &mut random);
    let whole = Scene::default().with(mesh.clone()).bvh();
    // The same without its last third.
    let fewer = mesh.triangles()[..200].to_vec();
    let part = Scene::default().with(common::shapes::mesh(mesh.positions().to_vec(), fewer)).bvh();
    let mut failures = 0;
    for _ in 0..300 {
        let ray = Ray { origin: random.cube(), direction: random.direction(), t_max: f32::INFINITY };
        let truth = trace(whole.geometry(), &ray, TOLERANCE);
        failures += u32::from(compare(&part, &ray, &truth, 1.0, &mut Tally::default()).is_err());
    }
    assert!(failures > 20, "{failures}");
}
