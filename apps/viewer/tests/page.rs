//! The engine as a page runs it: pictures by method `hybrid` are made by a device that answers later. Needs an adapter, if only a program on the CPU
//! (Debian: mesa-vulkan-drivers).

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
    let mut engine = Engine::of_page();
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

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_page_shows_what_the_cpu_shows_gpu() {
    let (mut engine, wish) = opened("cornell");
    let on_device = Wish { device: Device::Gpu, ..wish.clone() };
    let reports = told(&mut engine, Order::Wish(Box::new(on_device.clone())));
    assert!(!places(&reports)[0].starts_with("CPU"), "{:?}", places(&reports));
    let drawn = pictures(&reports);
    assert!(drawn.len() > 2 && drawn[0].is_preview() && !drawn[1].is_preview());
    let last = drawn[drawn.len() - 1].clone();
    assert!(last.sides[0].expected_rmse <= 0.02 && last.sides[0].ended.is_some());
    let errors: Vec<f64> = drawn[1..].iter().map(|p| p.sides[0].expected_rmse).collect();
    assert!(errors.windows(2).all(|w| w[1] < 1.05 * w[0]), "{errors:?}");
    // The same by the CPU, at once.
    let reports = told(&mut engine, Order::Wish(Box::new(wish)));
    assert!(places(&reports)[0].starts_with("CPU"));
    let by_cpu = (*pictures(&reports).last().unwrap()).clone();
    let rms = |of: fn(&Picture) -> &[f32]| {
        let both = of(&last).iter().zip(of(&by_cpu)).filter(|(a, b)| a.is_finite() && b.is_finite());
        let squares: Vec<f64> = both.map(|(a, b)| f64::from(a - b).powi(2)).collect();
        assert!(squares.len() > 7000, "{}", squares.len());
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    let [visibility, facing] = [rms(|p| &p.sides[0].visibility), rms(|p| &p.facing)];
    assert!(visibility < 0.03 && facing < 1e-3, "{visibility} {facing}");
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_page_answers_and_compares_beside_its_device_gpu() {
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
        [false, true]
    );
    let reports = told(&mut engine, Order::Ask(Question::Exr { side: 0, path: None }));
    assert!(reports.iter().any(|report| matches!(report, Report::Bytes(_, bytes) if bytes.len() > 10_000)));
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
fn a_page_without_a_device_works_on_the_cpu_and_says_so() {
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
