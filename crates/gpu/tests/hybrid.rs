//! Method `hybrid` with its rays on a device against the same on the CPU, and what becomes of it when the device is lost. Needs an adapter, if only
//! a program on the CPU (Debian: mesa-vulkan-drivers).

use conray_bvh::Bvh;
use conray_core::{Estimate, Falloff, Fingerprint, Ray, SurfacePoint, Vec3};
use conray_estimate::{
    AoPlan, AoSettings, Backend, BackendError, Budget, Control, Distance, Ended, Hybrid, Method,
};
use conray_gpu::{Gpu, GpuBackend};
use std::sync::{Arc, atomic::AtomicBool};

/// Root mean square difference that rounding may make, as the goal for all methods is.
const MOST: f64 = 0.003;
const SIDE: u32 = 64;

/// A scene, what a camera sees of it, and where to work on it.
struct Bench {
    plan: AoPlan,
    bvh: Bvh,
    points: Vec<SurfacePoint>,
    device: GpuBackend,
}

impl Bench {
    /// `from` and `to` in the scene's box, whose corners are 0 and 1.
    fn new(name: &str, settings: &AoSettings, [from, to]: [Vec3; 2]) -> Self {
        let geometry = conray_scene::builtin(name).unwrap().geometry;
        let plan = AoPlan::new(settings, geometry.bounds()).unwrap();
        let device = GpuBackend::new(Gpu::open(None).unwrap(), Some(&geometry), None).unwrap();
        let (low, size) = (geometry.bounds().min, geometry.bounds().max - geometry.bounds().min);
        let bvh = Bvh::build(Arc::new(geometry)).unwrap();
        let points = seen(&bvh, low + from * size, low + to * size);
        Self { plan, bvh, points, device }
    }

    fn begun(&self) -> Hybrid {
        Hybrid::of_image(&self.plan, &self.points, 0, [SIDE, SIDE])
    }

    fn refine(&self, hybrid: &mut Hybrid, on_device: bool, rays: u32, control: Control<'_>) -> Ended {
        let device = if on_device { self.device.hybrid_device() } else { None };
        hybrid.refine_on(device, &self.plan, &self.bvh, &self.points, Budget::rays(rays), control)
    }
}

/// What a square picture of a right angle shows.
fn seen(bvh: &Bvh, eye: Vec3, to: Vec3) -> Vec<SurfacePoint> {
    let forward = (to - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let along = |k: u32| 2.0 * (k as f32 + 0.5) / SIDE as f32 - 1.0;
    let point = |id: u32| {
        let direction = (forward + along(id % SIDE) * right - along(id / SIDE) * up).normalize();
        let ray = Ray { origin: eye, direction, t_max: f32::INFINITY };
        bvh.nearest(&ray).map(|hit| bvh.surface_point(&hit, &ray).with_id(id))
    };
    (0..SIDE * SIDE).filter_map(point).collect()
}

fn rmse(a: &[Estimate], b: &[Estimate]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.visibility - b.visibility).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

fn hybrid() -> AoSettings {
    AoSettings { method: Method::Hybrid, ..AoSettings::default() }
}

const INSIDE: [Vec3; 2] = [Vec3::new(0.5, 0.5, 0.9), Vec3::new(0.5, 0.3, 0.0)];

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn pictures_agree_gpu() {
    let smooth = AoSettings { falloff: Falloff::Smooth, bias_angle: 10.0, spread: 160.0, ..hybrid() };
    let cases = [
        ("cornell", 4, hybrid()),
        ("cornell", 64, hybrid()),
        ("atrium", 16, hybrid()),
        ("atrium", 48, smooth),
        ("grove", 20, hybrid()),
    ];
    for (name, rays, settings) in cases {
        let bench = Bench::new(name, &settings, INSIDE);
        let [mut on_gpu, mut on_cpu] = [bench.begun(), bench.begun()];
        for (work, on_device) in [(&mut on_gpu, true), (&mut on_cpu, false)] {
            assert_eq!(bench.refine(work, on_device, rays, Control::none()), Ended::Rays);
        }
        let [a, b] = [on_gpu.estimates(), on_cpu.estimates()];
        let off = rmse(&a, &b);
        let expected = on_gpu.expected_rmse() / on_cpu.expected_rmse();
        let alike = a.iter().zip(&b).filter(|(a, b)| a.rays == b.rays).count();
        eprintln!(
            "{name}, {rays} rays: off by {off:.5}, expected errors 1 to {expected:.4}, as many rays at {alike} of {}",
            a.len()
        );
        assert!(off < MOST, "{name}: {off}");
        assert!((expected - 1.0).abs() < 0.01, "{name}: {expected}");
        assert!(alike * 100 >= 98 * a.len(), "{name}: {alike} of {}", a.len());
        let bent = a.iter().zip(&b).map(|(a, b)| f64::from((a.bent - b.bent).length_squared()));
        assert!((bent.sum::<f64>() / a.len() as f64).sqrt() < 4.0 * MOST, "{name}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn another_seed_is_another_picture_gpu() {
    // Negative control of the agreement.
    let bench = Bench::new("cornell", &hybrid(), INSIDE);
    let mut on_gpu = bench.begun();
    bench.refine(&mut on_gpu, true, 4, Control::none());
    let other = Bench { plan: AoPlan { seed: 7, ..bench.plan.clone() }, ..bench };
    let mut on_cpu = other.begun();
    other.refine(&mut on_cpu, false, 4, Control::none());
    assert!(rmse(&on_gpu.estimates(), &on_cpu.estimates()) > 2.0 * MOST);
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_lost_device_loses_no_work_gpu() {
    let whole = Bench::new("atrium", &hybrid(), INSIDE);
    // After the lattice, so that the pilot fails, and after a whole round, so that the next one fails.
    for before in [None, Some(48)] {
        let bench = Bench::new("atrium", &hybrid(), INSIDE);
        let (mut work, mut unbroken) = (bench.begun(), whole.begun());
        if let Some(rays) = before {
            assert_eq!(bench.refine(&mut work, true, rays, Control::none()), Ended::Rays);
            whole.refine(&mut unbroken, true, rays, Control::none());
            bench.device.gpu().destroy();
        }
        assert_eq!(whole.refine(&mut unbroken, true, 128, Control::none()), Ended::Rays);
        let never = AtomicBool::new(false);
        let progress = |_: usize| bench.device.gpu().destroy();
        let control = Control { cancelled: &never, progress: &progress };
        assert_eq!(bench.refine(&mut work, true, 128, control), Ended::Failed, "{before:?}");
        let Some(BackendError::Device(reason)) = work.failure() else { panic!("no reason") };
        assert!(reason.contains("failed"), "{reason}");
        assert!(work.rays() > 0 && work.rays() < unbroken.rays());
        assert!(work.estimates().iter().all(|e| e.visibility.is_finite() && !e.is_pending()));
        // Kept and taken up again it becomes what it would have been.
        let (scene, mut kept) = (Fingerprint::of(|feed| feed.u32(1)), Vec::new());
        work.save(&bench.plan, scene, &bench.points, &mut kept).unwrap();
        let level = whole.bvh.level();
        let mut again = whole.begun().load(&whole.plan, scene, &whole.points, level, &kept).unwrap();
        assert_eq!(whole.refine(&mut again, true, 128, Control::none()), Ended::Rays);
        assert!(again.failure().is_none());
        assert!(again.estimates() == unbroken.estimates(), "{before:?}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_lost_device_fails_other_methods_too_gpu() {
    let settings = AoSettings { method: Method::Rays, distance: Distance::Auto, ..AoSettings::default() };
    let bench = Bench::new("cornell", &settings, INSIDE);
    bench.device.gpu().destroy();
    let mut estimates = vec![Estimate::PENDING; bench.points.len()];
    let failed = bench
        .device
        .estimate(&bench.plan, 0..16, &bench.points, &mut estimates, Control::none())
        .unwrap_err();
    assert!(failed.to_string().contains("failed"), "{failed}");
    assert!(estimates.iter().all(Estimate::is_pending));
}
