//! The engine without a window: what comes back, in which order, and what does not stop it.

mod support;

use conray::{Method, Sampling};
use conray_viewer::engine::{Fault, NamedBytes, Order, Question, Report, Source, Wish};
use std::time::{Duration, Instant};
use support::{Runner, orbit, wish};

#[test]
fn a_coarse_picture_comes_first_and_better_ones_follow_until_the_error_is_reached() {
    for method in Method::ALL {
        let mut runner = Runner::open("cornell");
        let scene = runner.scene.clone();
        runner.order(Order::Wish(Box::new(wish(&scene, [120, 90], &[method]))));
        let pictures = runner.until_rest();
        assert!(pictures.len() >= 2, "{method}: {}", pictures.len());
        assert!(pictures[0].is_preview() && pictures[0].size[0] < 120, "{method}");
        let last = pictures.last().unwrap();
        assert_eq!(last.size, [120, 90]);
        let side = &last.sides[0];
        assert!(side.ended.is_some() && side.method == method);
        let known = side.visibility.iter().filter(|v| v.is_finite()).count();
        assert!(known > 120 * 90 / 2, "{method}: {known} pixels");
        assert_eq!(side.cones.is_some(), method.needs_octree());
        if method.has_budget() {
            assert!(side.expected_rmse <= 0.02, "{method}: {}", side.expected_rmse);
            let errors: Vec<f64> = pictures[1..].iter().map(|p| p.sides[0].expected_rmse).collect();
            assert!(errors.windows(2).all(|w| w[1] <= 1.1 * w[0]), "{method}: {errors:?}");
        }
    }
}

#[test]
fn a_picture_is_what_the_session_gives() {
    // The same settings through the library's own way: the mean must agree within the errors of both.
    let mut runner = Runner::open("atrium");
    let scene = runner.scene.clone();
    let wish = wish(&scene, [96, 64], &[Method::Hybrid]);
    runner.order(Order::Wish(Box::new(wish.clone())));
    let pictures = runner.until_rest();
    let shown = &pictures.last().unwrap().sides[0];
    let geometry = conray::scene::builtin("atrium").unwrap().geometry;
    let session = conray::Session::build(geometry, &wish.sides[0]).unwrap();
    let target = session.camera(&wish.look.view("view"), 96, 64).unwrap();
    let outcome = session.run_target(&target, conray::Control::none()).unwrap();
    let layers = conray::target::Target::resolve(&target, &outcome.estimates).unwrap();
    let mask: Vec<bool> = layers.coverage().iter().map(|a| *a > 0.0).collect();
    let found = conray::target::compare(&shown.visibility, layers.visibility(), &mask).unwrap();
    assert_eq!(found.not_finite, 0);
    assert!(found.rmse < 0.05 && found.bias.abs() < 0.005, "{found:?}");
    // The oracle can fail: another view is another picture.
    let other = session.camera(&orbit(&wish, 0.3).look.view("view"), 96, 64).unwrap();
    let outcome = session.run_target(&other, conray::Control::none()).unwrap();
    let layers = conray::target::Target::resolve(&other, &outcome.estimates).unwrap();
    let found = conray::target::compare(&shown.visibility, layers.visibility(), &mask).unwrap();
    assert!(found.rmse > 0.05, "{found:?}");
}

#[test]
fn a_move_of_the_camera_begins_anew_and_interrupts_at_once() {
    let mut runner = Runner::open("atrium");
    let scene = runner.scene.clone();
    let mut endless = wish(&scene, [320, 240], &[Method::Rays]);
    endless.sides[0].error = Some(1e-5);
    runner.order(Order::Wish(Box::new(endless.clone())));
    runner.until(|report| matches!(report, Report::Picture(p) if p.sides[0].rays_per_pixel >= 16.0));
    // Long work goes on now. What is newer must be shown soon, though the old is far from done.
    let moved = orbit(&endless, 0.2);
    let start = Instant::now();
    runner.order(Order::Wish(Box::new(moved.clone())));
    let picture = runner.until_picture(|p| p.look == moved.look);
    let waited = start.elapsed();
    assert!(picture.is_preview());
    assert!(waited < Duration::from_secs(2), "{waited:?}");
    let whole = runner.until_picture(|p| !p.is_preview());
    assert_eq!(whole.look, moved.look, "nothing of the old view is shown any more");
}

#[test]
fn two_sides_share_what_they_see_and_both_are_refined() {
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    runner.order(Order::Wish(Box::new(wish(&scene, [80, 60], &[Method::Hybrid, Method::Paper]))));
    let pictures = runner.until_rest();
    let last = pictures.last().unwrap();
    let methods: Vec<Method> = last.sides.iter().map(|side| side.method).collect();
    assert_eq!(methods, [Method::Hybrid, Method::Paper]);
    assert!(last.sides.iter().all(|side| side.ended.is_some()));
    assert!(last.sides[0].cones.is_none() && last.sides[1].cones.is_some());
    for (a, b) in last.sides[0].visibility.iter().zip(last.sides[1].visibility.iter()) {
        assert_eq!(a.is_nan(), b.is_nan(), "they are pixels of one view");
    }
}

#[test]
fn a_camera_move_builds_nothing_and_a_change_of_voxels_does() {
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    let first = wish(&scene, [64, 48], &[Method::Cones]);
    let builds = |reports: &[Report]| {
        reports.iter().filter(|r| matches!(r, Report::Busy(what, _) if what.starts_with("building"))).count()
    };
    runner.order(Order::Wish(Box::new(first.clone())));
    assert_eq!(builds(&runner.all_until_rest()), 2, "BVH and octree");
    runner.order(Order::Wish(Box::new(orbit(&first, 0.1))));
    assert_eq!(builds(&runner.all_until_rest()), 0);
    let mut finer = first.clone();
    finer.sides[0].voxels = 64;
    runner.order(Order::Wish(Box::new(finer.clone())));
    assert_eq!(builds(&runner.all_until_rest()), 1, "the octree alone");
    let mut other = finer.clone();
    other.sides[0].gamma = 0.1;
    runner.order(Order::Wish(Box::new(other)));
    assert_eq!(builds(&runner.all_until_rest()), 0);
}

#[test]
fn what_cannot_be_read_is_told_and_the_last_scene_goes_on() {
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    let first = wish(&scene, [64, 48], &[Method::Hybrid]);
    runner.order(Order::Wish(Box::new(first.clone())));
    runner.until_rest();
    let bad = |name: &str, bytes: &[u8]| {
        Source::Bytes(NamedBytes { name: name.into(), bytes: bytes.into() }, Vec::new())
    };
    let huge = b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n\
        property float y\nproperty float z\nend_header\n";
    for (number, (source, said)) in [
        (Source::File("gone.obj".into()), "gone.obj"),
        (bad("short.glb", b"glTF\x02\0\0\0\xff\0\0\0"), "short.glb"),
        (bad("empty.obj", b""), "no triangles"),
        (bad("huge.ply", huge), "4000000000"),
        (bad("lonely.gltf", br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"gone.bin"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#),
            "dropped together"),
        (Source::Builtin("castle".into()), "no built-in scene"),
    ]
    .into_iter()
    .enumerate()
    {
        let number = 100 + number as u64;
        runner.order(Order::Open(number, source));
        let trouble = runner.until_trouble();
        assert_eq!((trouble.fault, trouble.scene), (Fault::Input, Some(number)), "{trouble:?}");
        assert!(trouble.message.contains(said), "{trouble:?} lacks {said}");
        // The scene before answers on.
        let moved = orbit(&first, 0.01 * number as f32);
        runner.order(Order::Wish(Box::new(moved.clone())));
        assert_eq!(runner.until_rest().last().unwrap().look, moved.look);
    }
}

#[test]
fn settings_that_do_not_go_together_are_told_and_mended_by_the_next_wish() {
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    let good = wish(&scene, [64, 48], &[Method::Rays]);
    let changes: [fn(&mut Wish); 6] = [
        |w| w.sides[0].distance = conray::Distance::World(-1.0),
        |w| {
            w.sides[0].falloff = conray::Falloff::Linear;
            w.sides[0].distance = conray::Distance::Infinite;
        },
        |w| w.sides[0].sampling = Sampling::Stratified,
        |w| w.sides[0].max_memory = Some(1),
        |w| w.look.eye = w.look.look_at,
        |w| w.look.vertical_fov_deg = 0.0,
    ];
    for change in changes {
        let mut bad = good.clone();
        change(&mut bad);
        runner.order(Order::Wish(Box::new(bad)));
        let trouble = runner.until_trouble();
        assert_eq!(trouble.fault, Fault::Request, "{trouble:?}");
        runner.order(Order::Wish(Box::new(good.clone())));
        assert!(runner.until_rest().last().unwrap().sides[0].ended.is_some());
    }
}

#[test]
fn a_size_of_zero_does_nothing() {
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    for size in [[0, 48], [64, 0], [0, 0]] {
        runner.order(Order::Wish(Box::new(wish(&scene, size, &[Method::Hybrid]))));
        assert!(runner.until_rest().is_empty());
    }
    runner.order(Order::Wish(Box::new(wish(&scene, [1, 1], &[Method::Hybrid]))));
    assert_eq!(runner.until_rest().last().unwrap().size, [1, 1]);
}

#[test]
fn a_probe_tells_cones_and_rays_and_agrees_with_the_method() {
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    let mut wished = wish(&scene, [64, 48], &[Method::Paper]);
    runner.order(Order::Wish(Box::new(wished.clone())));
    let pictures = runner.until_rest();
    let cones = pictures.last().unwrap().sides[0].cones.clone().unwrap();
    let pixel = [20, 40];
    runner.order(Order::Ask(Question::Probe { pixel, side: 0 }));
    let probe = runner.until_probe().expect("a wall is there");
    assert_eq!((probe.pixel, probe.cones.len(), probe.rays.len()), (pixel, 16, 64));
    let sum = |f: fn(&conray_viewer::engine::ProbedCone) -> f32| {
        probe.cones.iter().map(|cone| cone.weight * f(cone)).sum::<f32>()
    };
    let at = (pixel[1] * 64 + pixel[0]) as usize;
    assert!((sum(|c| c.visibility) - cones.visibility[at]).abs() < 1e-4, "cones add up to the layer");
    assert!((sum(|c| c.error) - cones.error[at]).abs() < 1e-4, "and so do their errors");
    // The rays are those of method rays: 64 of them have its visibility.
    wished.sides[0] =
        conray::AoSettings { method: Method::Rays, rays: Some(64), error: None, ..Default::default() };
    runner.order(Order::Wish(Box::new(wished)));
    let pictures = runner.until_rest();
    let visibility = pictures.last().unwrap().sides[0].visibility[at];
    let open = probe.rays.iter().filter(|(_, hit)| hit.is_none()).count() as f32 / 64.0;
    assert!((open - visibility).abs() < 1e-5, "{open} of the rays, {visibility} of the method");
    // Beside the room there is nothing.
    let mut away = wish(&scene, [64, 48], &[Method::Rays]);
    away.look.look_at = [0.0, 1.0, 100.0];
    away.look.eye = [0.0, 1.0, 50.0];
    runner.order(Order::Wish(Box::new(away)));
    runner.until_rest();
    runner.order(Order::Ask(Question::Probe { pixel, side: 0 }));
    assert!(runner.until_probe().is_none());
}

#[test]
fn boxes_hold_the_seen_surfaces_and_are_limited() {
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    runner.order(Order::Wish(Box::new(wish(&scene, [200, 150], &[Method::Hybrid]))));
    runner.until_rest();
    // Without an octree so far, it is built when asked for.
    for level in [0, 4, 40] {
        runner.order(Order::Ask(Question::Boxes { level }));
        let boxes = runner.until_boxes();
        assert_eq!(boxes.level, level.min(9), "512 leaves a side are ten levels");
        assert!(!boxes.nodes.is_empty() && boxes.nodes.len() <= boxes.found);
        assert!(boxes.nodes.iter().all(|(_, opacity)| (0.0..=1.0).contains(opacity)));
        match level {
            0 => assert!(boxes.nodes.len() < boxes.found, "leaves are more than are drawn"),
            40 => assert_eq!(boxes.found, 1, "the cube itself"),
            _ => assert!(boxes.nodes.iter().all(|(_, opacity)| *opacity > 0.0), "surfaces lie in full nodes"),
        }
    }
}

#[test]
fn a_truth_is_found_read_back_and_belongs_to_its_view() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("truth.exr");
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    let wished = wish(&scene, [64, 48], &[Method::Hybrid]);
    runner.order(Order::Wish(Box::new(wished)));
    let shown = runner.until_rest().pop().unwrap();
    runner.order(Order::Ask(Question::Truth { key: "here".into(), rays: 256 }));
    let truth = runner.until_truth(|truth| truth.done >= 1.0);
    assert_eq!((truth.size, &truth.key[..]), ([64, 48], "here"));
    let mask = vec![true; 64 * 48];
    let found = conray::target::compare(&shown.sides[0].visibility, &truth.visibility, &mask).unwrap();
    assert!(found.rmse > 0.0 && found.rmse < 0.06, "{found:?}");
    runner.order(Order::Ask(Question::Exr { side: 0, path: Some(path.clone()) }));
    runner.answer(|report| matches!(report, Report::Written(_)));
    let image = conray::target::read_exr_channels(&path).unwrap();
    assert!(image.channel("rays").is_some() && image.channel("position.X").is_some());
    assert!(image.attributes.iter().any(|(key, value)| key.contains("scene") && value == "cornell"));
    runner.order(Order::Ask(Question::ReadExr { key: "read".into(), source: Source::File(path) }));
    let read = runner.until_truth(|truth| truth.key == "read");
    let same = read.visibility.iter().zip(shown.sides[0].visibility.iter());
    assert!(same.into_iter().all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())));
    runner
        .order(Order::Ask(Question::ReadExr { key: "gone".into(), source: Source::File("gone.exr".into()) }));
    assert!(runner.until_trouble().message.contains("gone.exr"));
}

#[test]
fn messages_survive_as_bytes() {
    use conray_viewer::engine::wire::{pack, unpack};
    let mut runner = Runner::open("cornell");
    let scene = runner.scene.clone();
    let wished = wish(&scene, [40, 30], &[Method::Paper, Method::Rays]);
    let order: Order = unpack(&pack(&Order::Wish(Box::new(wished.clone()))).unwrap()).unwrap();
    let Order::Wish(again) = order else { panic!("a wish was sent") };
    assert_eq!(*again, wished);
    runner.order(Order::Wish(Box::new(wished)));
    let picture = runner.until_rest().pop().unwrap();
    let report: Report = unpack(&pack(&Report::Picture(Box::new(picture.clone()))).unwrap()).unwrap();
    let Report::Picture(again) = report else { panic!("a picture was sent") };
    let bits = |plane: &[f32]| plane.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&again.sides[1].visibility), bits(&picture.sides[1].visibility));
    assert_eq!(
        bits(&again.sides[0].cones.as_ref().unwrap().alpha),
        bits(&picture.sides[0].cones.as_ref().unwrap().alpha)
    );
    let cut = pack(&Report::Picture(Box::new(picture))).unwrap();
    assert!(unpack::<Report>(&cut[..cut.len() / 2]).is_err());
}
