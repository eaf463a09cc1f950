//! Pictures made wholly on a device against what the CPU sees and makes of as many rays. Needs an adapter, if only a program on the CPU (Debian:
//! mesa-vulkan-drivers).

use conray_bvh::Bvh;
use conray_core::{Bounds, Estimate, Falloff, Geometry, Ray, SurfacePoint, Vec3};
use conray_estimate::{AoPlan, AoSettings, Backend, Budget, Control, CpuBackend, Hybrid, Method, RayErrors};
use conray_gpu::{FrameCamera, FramePixel, Gpu, GpuBackend};
use std::sync::Arc;

/// Root mean square difference that rounding may make, as the goal for all methods is.
const MOST: f64 = 0.003;
const WIDTH: u32 = 90;
const HEIGHT: u32 = 71;

struct Bench {
    plan: AoPlan,
    bounds: Bounds,
    bvh: Bvh,
    device: Arc<GpuBackend>,
    camera: FrameCamera,
}

impl Bench {
    /// Looking from and to places of the scene's box, whose corners are 0 and 1.
    fn new(geometry: Geometry, settings: &AoSettings, [from, to]: [Vec3; 2]) -> Self {
        let bounds = geometry.bounds();
        let plan = AoPlan::new(settings, bounds).unwrap();
        let device = GpuBackend::new(Gpu::open(None).unwrap(), Some(&geometry), None).unwrap();
        let [eye, to] = [from, to].map(|at| bounds.min + at * (bounds.max - bounds.min));
        let forward = (to - eye).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let camera =
            FrameCamera { eye, right, up: right.cross(forward), forward, pixel_side: 2.0 / HEIGHT as f32 };
        Self { plan, bounds, bvh: Bvh::build(Arc::new(geometry)).unwrap(), device: Arc::new(device), camera }
    }

    fn built_in(name: &str, settings: &AoSettings) -> Self {
        Self::new(conray_scene::builtin(name).unwrap().geometry, settings, INSIDE)
    }

    /// What the CPU sees.
    fn points(&self) -> Vec<SurfacePoint> {
        let FrameCamera { eye, right, up, forward, pixel_side } = self.camera;
        let point = |id: u32| {
            let x = (id % WIDTH) as f32 + 0.5 - 0.5 * WIDTH as f32;
            let y = 0.5 * HEIGHT as f32 - (id / WIDTH) as f32 - 0.5;
            let direction = (forward + pixel_side * (x * right + y * up)).normalize();
            let ray = Ray { origin: eye, direction, t_max: f32::INFINITY };
            let hit = self.bvh.nearest(&ray)?;
            let point = self.bvh.surface_point(&hit, &ray);
            let footprint = (point.position - eye).dot(forward) * pixel_side;
            Some(SurfacePoint { id, footprint, ..point })
        };
        (0..WIDTH * HEIGHT).filter_map(point).collect()
    }

    /// Whether that is a point that the CPU sees.
    fn is_seen_at(&self, pixel: &FramePixel, point: &SurfacePoint) -> bool {
        let extent = (self.bounds.max - self.bounds.min).length();
        (pixel.position - point.position).length() < 2e-5 * extent
            && pixel.normal.dot(point.shading_normal) > 0.9999
    }

    /// Root mean square differences of visibility and of its error between the device's picture and the CPU's.
    fn off(&self, points: &[SurfacePoint], rays: u32, seed: u32) -> [f64; 2] {
        let plan = AoPlan { seed, ..self.plan.clone() };
        let mut hybrid = Hybrid::of_image(&plan, points, 0, [WIDTH, HEIGHT]);
        hybrid.refine(&plan, &self.bvh, points, Budget::rays(rays), Control::none());
        let mut frames = self.device.frames(&self.plan, self.bounds, [WIDTH, HEIGHT]).unwrap();
        let found = frames.render(&self.camera, rays as f32, &hybrid.ray_errors()).unwrap();
        let pixels = frames.pixels().unwrap();
        let (estimates, mut squares, mut count) = (hybrid.estimates(), [0.0; 2], 0);
        for (estimate, point) in estimates.iter().zip(points) {
            // At the rim of a leaf rounding decides what is seen: another test counts those.
            if let Some(pixel) = pixels[point.id as usize].filter(|pixel| self.is_seen_at(pixel, point)) {
                squares[0] += f64::from(pixel.visibility - estimate.visibility).powi(2);
                squares[1] += f64::from(pixel.error - estimate.error).powi(2);
                assert_eq!(pixel.rays, estimate.rays);
                count += 1;
            }
        }
        assert!(count * 1000 >= 997 * points.len(), "{count} of {} are seen", points.len());
        assert!((found.points as usize).abs_diff(points.len()) * 1000 <= points.len());
        assert!(seed != self.plan.seed || (found.expected_rmse / hybrid.expected_rmse() - 1.0).abs() < 0.02);
        assert_picture(&frames.picture().unwrap(), &pixels);
        squares.map(|squares| (squares / count as f64).sqrt())
    }
}

/// The picture is grey, and what is known.
fn assert_picture(picture: &[u32], pixels: &[Option<FramePixel>]) {
    for (pixel, known) in picture.iter().zip(pixels) {
        let [red, green, blue, alpha] = pixel.to_le_bytes();
        match known {
            Some(FramePixel { visibility: value, .. }) => {
                assert!((f32::from(red) - 255.0 * value).abs() <= 0.51, "{red} {value}");
                assert_eq!([green, blue, alpha], [red, red, 255]);
            }
            None => assert_eq!(*pixel, 0),
        }
    }
}

fn hybrid() -> AoSettings {
    AoSettings { method: Method::Hybrid, ..AoSettings::default() }
}

const INSIDE: [Vec3; 2] = [Vec3::new(0.5, 0.5, 0.9), Vec3::new(0.45, 0.3, 0.0)];

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn what_is_seen_agrees_gpu() {
    for name in ["cornell", "atrium", "grove"] {
        let bench = Bench::built_in(name, &hybrid());
        let mut frames = bench.device.frames(&bench.plan, bench.bounds, [WIDTH, HEIGHT]).unwrap();
        frames.render(&bench.camera, 0.1, &RayErrors::UNKNOWN).unwrap();
        let seen = frames.pixels().unwrap();
        let points = bench.points();
        let alike = |point: &&SurfacePoint| {
            seen[point.id as usize].is_some_and(|pixel| bench.is_seen_at(&pixel, point))
        };
        let [found, covered] = [points.iter().filter(alike).count(), seen.iter().flatten().count()];
        eprintln!("{name}: {found} of {} alike", points.len());
        assert!(found * 1000 >= 997 * points.len(), "{name}: {found} of {}", points.len());
        assert!(covered.abs_diff(points.len()) * 1000 <= points.len());
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn pictures_agree_gpu() {
    let smooth = AoSettings { falloff: Falloff::Smooth, bias_angle: 10.0, spread: 160.0, ..hybrid() };
    let cases =
        [("cornell", 1, hybrid()), ("cornell", 6, hybrid()), ("atrium", 4, smooth), ("grove", 3, hybrid())];
    for (name, rays, settings) in cases {
        let bench = Bench::built_in(name, &settings);
        let [values, errors] = bench.off(&bench.points(), rays, bench.plan.seed);
        eprintln!("{name}, {rays} rays: off by {values:.5}, errors by {errors:.5}");
        assert!(values < MOST && errors < MOST, "{name}: {values}, {errors}");
    }
    // Negative control: other rays.
    let bench = Bench::built_in("cornell", &hybrid());
    let [values, _] = bench.off(&bench.points(), 4, 99);
    assert!(values > 2.0 * MOST, "{values}");
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn a_camera_that_sees_nothing_gpu() {
    let bench = Bench::built_in("cornell", &hybrid());
    let mut frames = bench.device.frames(&bench.plan, bench.bounds, [1, 1]).unwrap();
    let away = FrameCamera { eye: bench.bounds.max + Vec3::splat(9.0), forward: Vec3::Y, ..bench.camera };
    let found = frames.render(&away, 4.0, &RayErrors::UNKNOWN).unwrap();
    assert_eq!((found.points, found.expected_rmse), (0, 0.0));
    assert_eq!(frames.pixels().unwrap(), [None]);
    assert_eq!(frames.picture().unwrap(), [0]);
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn more_rays_come_to_the_truth_gpu() {
    let bench = Bench::built_in("cornell", &hybrid());
    let points = bench.points();
    let plan = AoPlan { seed: 4711, method: Method::Rays, ..bench.plan.clone() };
    let mut truth = vec![Estimate::PENDING; points.len()];
    let cpu = CpuBackend::new(Arc::new(bench.bvh), None);
    cpu.estimate(&plan, 0..2048, &points, &mut truth, Control::none()).unwrap();
    let mut frames = bench.device.frames(&bench.plan, bench.bounds, [WIDTH, HEIGHT]).unwrap();
    let mut found = frames.render(&bench.camera, 1.0, &RayErrors::UNKNOWN).unwrap();
    let mut rmses = Vec::new();
    for more in [1.0, 2.0, 4.0, 8.0, 16.0, 16.0, 16.0, 16.0, 16.0, 16.0, 16.0, 16.0] {
        let pixels = frames.pixels().unwrap();
        let off = |(truth, point): (&Estimate, &SurfacePoint)| {
            f64::from(pixels[point.id as usize].unwrap().visibility - truth.visibility).powi(2)
        };
        let rmse = (truth.iter().zip(&points).map(off).sum::<f64>() / points.len() as f64).sqrt();
        eprintln!("{} rays: RMSE {rmse:.4}, expected {:.4}", found.rays, found.expected_rmse);
        assert!((0.6..1.5).contains(&(found.expected_rmse / rmse)), "{} of {rmse}", found.expected_rmse);
        rmses.push(rmse);
        found = frames.refine(more, &RayErrors::UNKNOWN).unwrap();
    }
    assert!(rmses.windows(2).all(|w| w[1] < 1.02 * w[0]) && rmses[11] < 0.25 * rmses[0], "{rmses:?}");
}
