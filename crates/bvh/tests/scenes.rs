//! Real scenes, where their files are at hand: `cargo test -p conray-bvh --release -- --include-ignored`.

mod common;

use common::{Random, Scene, brute::trace, obj};
use conray_bvh::{Bvh, Hit};
use conray_core::{Ray, Vec3};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes");

fn load(file: &str) -> Option<Bvh> {
    match std::fs::read_to_string(format!("{SCENES}/{file}")) {
        Ok(text) => Some(Scene::default().with(obj::read(&text)).bvh()),
        Err(_) => {
            eprintln!("not run: {file} is absent");
            None
        }
    }
}

#[test]
#[ignore = "needs the scenes in ../shared/scenes"]
fn whole_scenes_validate_and_agree_with_brute_force() {
    for file in ["crytek-sponza/sponza.obj", "conference/conference.obj", "stanford-bunny/bunny.obj"] {
        let Some(bvh) = load(file) else { continue };
        println!("{file}: {:?}", bvh.stats());
        let (centre, size) = (bvh.bounds().centre(), bvh.bounds().diagonal());
        let mut random = Random(30);
        let (mut judged, mut hits) = (0, 0);
        for _ in 0..40 {
            let origin = centre + 0.2 * size * random.cube();
            let ray = Ray { origin, direction: random.direction(), t_max: f32::INFINITY };
            let truth = trace(bvh.geometry(), &ray, 4e-6 * f64::from(size));
            let first = truth.hits.first();
            if truth.doubtful.iter().any(|&t| t < first.map_or(f64::INFINITY, |h| h.t + 1e-3)) {
                continue;
            }
            judged += 1;
            let found = bvh.nearest(&ray);
            assert_eq!(found.is_some(), first.is_some(), "{file} {ray:?}");
            assert_eq!(bvh.transmittance(&ray) == 0.0, first.is_some());
            if let (Some(hit), Some(truth)) = (found, first) {
                assert!((f64::from(hit.t) - truth.t).abs() <= 1e-5 * truth.t, "{file} {hit:?} {truth:?}");
                hits += 1;
            }
        }
        assert!(judged > 20 && hits > 5, "{file}: {judged} judged, {hits} hits");
    }
}

#[test]
#[ignore = "needs the scenes in ../shared/scenes"]
fn nothing_leaves_the_closed_bunny() {
    let Some(bvh) = load("stanford-bunny/bunny.obj") else { return };
    let mut random = Random(31);
    let triangles = bvh.stats().triangles as usize;
    let (mut inside, mut open) = (0, 0);
    for _ in 0..50_000 {
        let (u, v) = random.barycentric();
        // Inward: along the direction that the back of a triangle is seen from.
        let triangle = random.below(triangles) as u32;
        let [a, b, c] = bvh.world_corners(0, triangle);
        let outward = (b - a).cross(c - a);
        let hit = Hit { t: 1.0, instance: 0, triangle, u: u.clamp(0.1, 0.4), v: v.clamp(0.1, 0.4) };
        let viewer = Ray { origin: Vec3::ZERO, direction: outward, t_max: f32::INFINITY };
        let point = bvh.surface_point(&hit, &viewer);
        let direction = random.direction();
        if direction.dot(point.geometric_normal) < 0.05 {
            continue;
        }
        let ray = Ray { origin: point.ray_origin(), direction, t_max: f32::INFINITY };
        inside += 1;
        open += u32::from(bvh.transmittance(&ray) != 0.0);
    }
    assert!(inside > 10_000);
    assert_eq!(open, 0, "of {inside}");
}
