//! The engine beside a device that answers later, as on a page. Needs an adapter, if only a program on the CPU (Debian: mesa-vulkan-drivers).

use conray::{AoSettings, Device, Method};
use conray_viewer::engine::{Engine, Order, Picture, Question, Report, Source, Stop, Wish};
use std::sync::Mutex;

const SIZE: [u32; 2] = [120, 90];

/// All that an engine tells until it has nothing left to do.
fn told(engine: &mut Engine, order: Order) -> Vec<Report> {
    engine.take(order);
    let all = Mutex::new(Vec::new());
    while engine.step(&Stop::never(), &|report| all.lock().unwrap().push(report)) {}
    let all = all.into_inner().unwrap();
    let trouble = all.iter().find(|report| matches!(report, Report::Trouble(_)));
    assert!(trouble.is_none(), "{trouble:?}");
    all
}

fn opened(scene: &str) -> (Engine, Wish) {
    let mut engine = Engine::default();
    let reports = told(&mut engine, Order::Open(1, Source::Builtin(scene.into())));
    let facts = reports.into_iter().find_map(|report| match report {
        Report::Scene(facts) => Some(facts),
        _ => None,
    });
    let facts = facts.unwrap();
    let settings = AoSettings { error: Some(0.02), ..AoSettings::default() };
    let wish = Wish {
        scene: facts.number,
        look: facts.views[0].1,
        size: SIZE,
        sides: vec![settings],
        device: Device::Cpu,
        adapter: None,
        again: 0,
    };
    (engine, wish)
}

/// The same from a little to the side.
fn orbit(wish: &Wish) -> Wish {
    Wish { look: wish.look.orbit(0.2, 0.0), ..wish.clone() }
}

fn pictures(reports: &[Report]) -> Vec<&Picture> {
    fn picture(report: &Report) -> Option<&Picture> {
        if let Report::Picture(picture) = report { Some(picture) } else { None }
    }
    reports.iter().filter_map(picture).collect()
}

/// Where the last build said that each side is made.
fn places(reports: &[Report]) -> Vec<String> {
    let built = reports.iter().rev().find_map(|report| match report {
        Report::Built(built) => Some(built.places.clone()),
        _ => None,
    });
    built.unwrap_or_default()
}

/// Root mean square difference over the pixels that both know.
fn rms(a: &[f32], b: &[f32]) -> f64 {
    let both = a.iter().zip(b).filter(|(a, b)| a.is_finite() && b.is_finite());
    let squares: Vec<f64> = both.map(|(a, b)| f64::from(a - b).powi(2)).collect();
    assert!(squares.len() > 7000, "{}", squares.len());
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// The last picture, on a device and on the CPU.
fn both(scene: &str, change: impl Fn(&mut AoSettings)) -> [Picture; 2] {
    let (mut engine, mut wish) = opened(scene);
    change(&mut wish.sides[0]);
    let on_device = Wish { device: Device::Gpu, ..wish.clone() };
    let reports = told(&mut engine, Order::Wish(Box::new(on_device)));
    assert!(!places(&reports)[0].starts_with("CPU"), "{:?}", places(&reports));
    let drawn = pictures(&reports);
    assert!(drawn.len() > 1 && drawn[0].is_preview() && !drawn[1].is_preview());
    let errors: Vec<f64> = drawn[1..].iter().map(|p| p.sides[0].expected_rmse).collect();
    assert!(errors.windows(2).all(|w| w[1] < 1.05 * w[0]), "{errors:?}");
    let last = drawn[drawn.len() - 1].clone();
    assert!(last.sides[0].ended.is_some());
    // The same by the CPU, at once.
    let reports = told(&mut engine, Order::Wish(Box::new(wish)));
    assert!(places(&reports)[0].starts_with("CPU"));
    [last, (*pictures(&reports).last().unwrap()).clone()]
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_device_shows_what_the_cpu_shows_gpu() {
    let [drawn, by_cpu] = both("cornell", |_| {});
    assert!(drawn.sides[0].expected_rmse <= 0.02);
    let visibility = rms(&drawn.sides[0].visibility, &by_cpu.sides[0].visibility);
    let facing = rms(&drawn.facing, &by_cpu.facing);
    assert!(visibility < 0.03 && facing < 1e-3, "{visibility} {facing}");
    let other = drawn.sides[0].visibility.clone();
    // The others by the same samples.
    for method in [Method::Rays, Method::Cones, Method::Paper] {
        let [drawn, by_cpu] = both("cornell", |side| {
            *side = AoSettings { method, voxels: 128, error: None, rays: Some(32), ..AoSettings::default() };
        });
        let visibility = rms(&drawn.sides[0].visibility, &by_cpu.sides[0].visibility);
        assert!(visibility < 0.003, "{method}: {visibility}");
        assert_eq!(drawn.sides[0].cones.is_some(), method.needs_octree());
        if let (Some(a), Some(b)) = (&drawn.sides[0].cones, &by_cpu.sides[0].cones) {
            assert!(rms(&a.visibility, &b.visibility) < 0.003 && rms(&a.alpha, &b.alpha) < 0.01, "{method}");
        }
        // The oracle can fail: another method is another picture.
        assert!(rms(&other, &by_cpu.sides[0].visibility) > 0.003, "{method}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn answers_and_comparisons_beside_a_device_gpu() {
    let (mut engine, wish) = opened("atrium");
    let mut split = Wish { device: Device::Gpu, ..wish };
    let rays = AoSettings { method: Method::Rays, rays: Some(64), ..split.sides[0].clone() };
    split.sides.push(rays);
    let reports = told(&mut engine, Order::Wish(Box::new(split.clone())));
    let drawn = pictures(&reports);
    let last = drawn[drawn.len() - 1];
    assert_eq!(last.sides.iter().map(|s| s.method).collect::<Vec<_>>(), [Method::Hybrid, Method::Rays]);
    assert!(last.sides.iter().all(|side| side.ended.is_some()));
    assert_eq!(
        places(&reports).iter().map(|place| place.starts_with("CPU")).collect::<Vec<_>>(),
        [false, false]
    );
    // A picture made wholly on a device has no directions; passes over points have.
    for (side, has_bent) in [(0, false), (1, true)] {
        let reports = told(&mut engine, Order::Ask(Question::Exr { side, path: None }));
        let bytes = reports.iter().find_map(|r| if let Report::Bytes(_, b) = r { Some(b) } else { None });
        let image = conray::target::decode_exr_channels("told.exr", bytes.unwrap()).unwrap();
        assert!(image.channel("R").is_some() && image.channel("rays").is_some());
        assert_eq!(image.channel("bent.X").is_some(), has_bent, "side {side}");
    }
    // What is built later leaves pictures where they are made, and a truth waits for no device.
    let reports = told(&mut engine, Order::Ask(Question::Boxes { level: 2 }));
    assert!(!places(&reports)[0].starts_with("CPU"), "{:?}", places(&reports));
    let reports = told(&mut engine, Order::Ask(Question::Truth { key: "view".into(), rays: 64 }));
    let is_whole = |r: &Report| matches!(r, Report::Truth(truth) if truth.done == 1.0 && truth.size == SIZE);
    assert!(reports.iter().any(is_whole));
    // A camera that moves keeps the device and its room.
    let reports = told(&mut engine, Order::Wish(Box::new(orbit(&split))));
    assert!(places(&reports).is_empty(), "nothing is built anew");
    assert!(pictures(&reports).len() > 2);
}

#[test]
fn without_a_device_the_cpu_works_and_says_so() {
    let (mut engine, wish) = opened("cornell");
    let wish = Wish { device: Device::Auto, adapter: Some("no such thing".into()), ..wish };
    let reports = told(&mut engine, Order::Wish(Box::new(wish.clone())));
    let notices = |reports: &[Report]| {
        let of_device =
            |r: &&Report| matches!(r, Report::Notice(text) if text.contains("no graphics adapter has"));
        reports.iter().filter(of_device).count()
    };
    assert_eq!(notices(&reports), 1);
    assert!(pictures(&reports).last().unwrap().sides[0].ended.is_some());
    let reports = told(&mut engine, Order::Wish(Box::new(orbit(&wish))));
    assert_eq!(notices(&reports), 0, "it is said once");
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_device_that_is_lost_leaves_the_work_to_the_cpu_gpu() {
    for method in [Method::Hybrid, Method::Rays] {
        let (mut engine, wish) = opened("cornell");
        let mut wish = Wish { device: Device::Gpu, ..wish };
        wish.sides[0].method = method;
        wish.sides[0].error = Some(0.015);
        engine.take(Order::Wish(Box::new(wish.clone())));
        let all = Mutex::new(Vec::new());
        let is_on_device =
            |r: &Report| matches!(r, Report::Built(built) if !built.places[0].starts_with("CPU"));
        while !all.lock().unwrap().iter().any(is_on_device) {
            assert!(engine.step(&Stop::never(), &|report| all.lock().unwrap().push(report)), "{method}");
        }
        engine.lose_device();
        all.lock().unwrap().clear();
        while engine.step(&Stop::never(), &|report| all.lock().unwrap().push(report)) {}
        let all = all.into_inner().unwrap();
        let troubles: Vec<&str> = all
            .iter()
            .filter_map(|r| if let Report::Trouble(t) = r { Some(t.message.as_str()) } else { None })
            .collect();
        assert!(troubles.len() == 1 && !troubles[0].is_empty(), "{method}: {troubles:?}");
        assert!(all.iter().any(|r| matches!(r, Report::Notice(text) if text == "the CPU has taken over")));
        assert!(places(&all)[0].starts_with("CPU"), "{method}: {:?}", places(&all));
        let last = pictures(&all).last().unwrap().sides[0].clone();
        assert!(last.expected_rmse <= 0.015 && last.ended.is_some(), "{method}");
        // It is not asked for again, until another place was wished for.
        let reports = told(&mut engine, Order::Wish(Box::new(orbit(&wish))));
        assert!(places(&reports).is_empty(), "{method}");
        let on_cpu = Wish { device: Device::Cpu, ..wish.clone() };
        told(&mut engine, Order::Wish(Box::new(on_cpu)));
        wish.sides[0].error = Some(0.1);
        let reports = told(&mut engine, Order::Wish(Box::new(wish)));
        assert!(!places(&reports)[0].starts_with("CPU"), "{method}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_truth_goes_on_where_its_device_is_lost_gpu() {
    let (mut engine, wish) = opened("cornell");
    let wish = Wish { device: Device::Gpu, ..wish };
    told(&mut engine, Order::Wish(Box::new(wish)));
    engine.lose_device();
    engine.take(Order::Ask(Question::Truth { key: "view".into(), rays: 128 }));
    let all = Mutex::new(Vec::new());
    while engine.step(&Stop::never(), &|report| all.lock().unwrap().push(report)) {}
    let all = all.into_inner().unwrap();
    assert_eq!(all.iter().filter(|r| matches!(r, Report::Trouble(_))).count(), 1);
    assert!(all.iter().any(|r| matches!(r, Report::Truth(truth) if truth.done == 1.0)));
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn sides_by_hybrid_have_pictures_of_their_own_gpu() {
    let (mut engine, mut wish) = opened("cornell");
    let near = AoSettings { distance: conray::Distance::World(0.02), ..wish.sides[0].clone() };
    wish.sides.push(near);
    let on_device = Wish { device: Device::Gpu, ..wish.clone() };
    let reports = told(&mut engine, Order::Wish(Box::new(on_device)));
    assert!(places(&reports).iter().all(|place| !place.starts_with("CPU")));
    let drawn = (*pictures(&reports).last().unwrap()).clone();
    let reports = told(&mut engine, Order::Wish(Box::new(wish)));
    let by_cpu = (*pictures(&reports).last().unwrap()).clone();
    for side in 0..2 {
        let [same, other] =
            [side, 1 - side].map(|k| rms(&drawn.sides[side].visibility, &by_cpu.sides[k].visibility));
        assert!(same < 0.03 && other > 0.05, "side {side}: {same} {other}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn another_opacity_is_uploaded_anew_gpu() {
    let (mut engine, wish) = opened("cornell");
    let mut wish = Wish { device: Device::Gpu, ..wish };
    wish.sides[0].error = Some(0.1);
    told(&mut engine, Order::Wish(Box::new(wish.clone())));
    wish.sides[0].alpha = conray::Alpha::Opaque;
    let reports = told(&mut engine, Order::Wish(Box::new(wish)));
    let opened = |r: &&Report| matches!(r, Report::Busy(what, _) if what.starts_with("opening"));
    assert_eq!(reports.iter().filter(opened).count(), 1);
    assert!(!places(&reports)[0].starts_with("CPU"));
}
