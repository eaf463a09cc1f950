//! What a device makes of rays and neighbours against what the CPU makes of the same rays, in whole pictures and in odd ones. Needs an adapter, if only
//! a program on the CPU (Debian: mesa-vulkan-drivers).

use conray_bvh::Bvh;
use conray_core::{Estimate, SurfacePoint, Vec3};
use conray_estimate::{
    AoPlan, AoSettings, Backend, BackendError, Batch, BatchFound, Budget, Control, Ended, Hybrid,
    HybridConstants, HybridDevice, Method, PlaceWeigher, Places,
};
use conray_gpu::{Gpu, GpuBackend};
use proptest::{prelude::*, test_runner::TestRunner};
use std::sync::Arc;

/// Rounding alone.
const MOST: f64 = 2e-5;
/// The same where further rays are chosen by it: a device that rounds in another way chooses another ray now and then.
const MOST_WITH_CHOICES: f64 = 0.003;
/// Below so many rays a point none are chosen.
const FEW: u32 = 8;

/// The rays of a device, weighed by whom and how one likes.
struct Weighed<'a> {
    device: &'a dyn HybridDevice,
    by: By,
}

#[derive(Clone, Copy)]
enum By {
    Device,
    Cpu,
    /// The device, with surfaces told apart in another way.
    DeviceWith(HybridConstants),
}

impl HybridDevice for Weighed<'_> {
    fn trace(
        &self,
        plan: &AoPlan,
        points: &[SurfacePoint],
        batches: &[Batch],
        salt: u32,
    ) -> Result<Vec<BatchFound>, BackendError> {
        self.device.trace(plan, points, batches, salt)
    }

    fn weigher<'a>(
        &'a self,
        constants: &HybridConstants,
        places: &Places<'_>,
    ) -> Result<Option<Box<dyn PlaceWeigher + 'a>>, BackendError> {
        let weigher = match self.by {
            By::Cpu => return Ok(None),
            By::Device => self.device.weigher(constants, places)?,
            By::DeviceWith(other) => self.device.weigher(&other, places)?,
        };
        assert!(weigher.is_some(), "the device leaves weighing to the CPU");
        Ok(weigher)
    }
}

/// A scene on both.
struct Bench {
    plan: AoPlan,
    bvh: Bvh,
    device: GpuBackend,
}

impl Bench {
    fn new(name: &str) -> Self {
        let geometry = conray_scene::builtin(name).unwrap().geometry;
        let settings = AoSettings { method: Method::Hybrid, ..AoSettings::default() };
        let plan = AoPlan::new(&settings, geometry.bounds()).unwrap();
        let device = GpuBackend::new(Gpu::open(None).unwrap(), Some(&geometry), None).unwrap();
        Self { plan, bvh: Bvh::build(Arc::new(geometry)).unwrap(), device }
    }

    /// Middles of triangles over and over, a little apart: `of` makes a point of an index.
    fn points(&self, count: u32, of: impl Fn(u32) -> [f32; 2]) -> Vec<SurfacePoint> {
        let geometry = self.bvh.geometry();
        let point = |id: u32| {
            let triangles = geometry.mesh_of(0).triangles().len() as u32;
            self.bvh.front_point(0, (id / 61) % triangles, of(id)).with_id(id)
        };
        (0..count).map(point).collect()
    }

    fn run(&self, mut work: Hybrid, points: &[SurfacePoint], rays: u32, by: By) -> (Vec<Estimate>, f64) {
        let weighed = Weighed { device: self.device.hybrid_device().unwrap(), by };
        let budget = Budget::rays(rays);
        let ended = work.refine_on(Some(&weighed), &self.plan, &self.bvh, points, budget, Control::none());
        assert!(matches!(ended, Ended::Rays | Ended::Done), "{ended:?}: {:?}", work.failure());
        (work.estimates(), work.expected_rmse())
    }

    /// Root mean square differences of values and of expected errors between two ways of weighing.
    fn off(&self, begun: &Hybrid, points: &[SurfacePoint], rays: u32, by: [By; 2]) -> [f64; 2] {
        let [a, b] = by.map(|by| self.run(begun.clone(), points, rays, by));
        let valid = |e: &Estimate| e.error.is_finite() && e.visibility.is_finite();
        assert!(
            a.0.iter()
                .zip(&b.0)
                .zip(points)
                .all(|((a, b), point)| { valid(a) == valid(b) && (valid(a) || !point.is_valid()) })
        );
        let rms = |of: fn(&Estimate) -> f32| {
            let both = a.0.iter().zip(&b.0).filter(|(a, _)| valid(a));
            let squares: Vec<f64> = both.map(|(a, b)| f64::from(of(a) - of(b)).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
        };
        [rms(|e| e.visibility), rms(|e| e.error)]
    }
}

const SAME_RAYS: [By; 2] = [By::Device, By::Cpu];

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn few_and_many_rays_are_weighed_alike_gpu() {
    let bench = Bench::new("atrium");
    let side = 96;
    let points = bench.points(side * side, |id| [0.01 * (id % 61) as f32 + 0.1, 0.2]);
    let begun = Hybrid::of_image(&bench.plan, &points, 0, [side, side]);
    for rays in [1, 2, 6, 16, 40] {
        let [values, errors] = bench.off(&begun, &points, rays, SAME_RAYS);
        eprintln!("{rays} rays: values {values:.1e}, errors {errors:.1e}");
        let most = if rays < FEW { MOST } else { MOST_WITH_CHOICES };
        assert!(values < most && errors < most, "{rays} rays: {values}, {errors}");
    }
    // Points of no image, laid out by the method itself.
    let begun = Hybrid::of_scattered(&bench.plan, &points);
    let [values, errors] = bench.off(&begun, &points, 4, SAME_RAYS);
    assert!(values < MOST && errors < MOST, "scattered: {values}, {errors}");
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn other_constants_are_told_gpu() {
    // Negative control: each constant that weighing reads changes what it comes to.
    let bench = Bench::new("atrium");
    let side = 64;
    let points = bench.points(side * side, |id| [0.01 * (id % 61) as f32 + 0.1, 0.2]);
    let begun = Hybrid::of_image(&bench.plan, &points, 0, [side, side]);
    let constants = HybridConstants::default();
    let others = [
        ("distance", HybridConstants { distance: 0.01, ..constants }),
        ("cells", HybridConstants { cells: 0.3, ..constants }),
        ("plane", HybridConstants { plane: 50.0, ..constants }),
        ("cosine", HybridConstants { cosine: 3.0, ..constants }),
        ("slope", HybridConstants { slope: 0.1, ..constants }),
        ("bend", HybridConstants { bend: 1.0, ..constants }),
        ("prior_samples", HybridConstants { prior_samples: 20.0, ..constants }),
        ("beyond_chance", HybridConstants { beyond_chance: 0.1, ..constants }),
        ("least_noise", HybridConstants { least_noise: 5.0, ..constants }),
        ("doubt_units", HybridConstants { doubt_units: 1.0, ..constants }),
    ];
    for (name, other) in others {
        let [values, errors] = bench.off(&begun, &points, 6, [By::DeviceWith(other), By::Cpu]);
        assert!(values.max(errors) > 5.0 * MOST, "{name}: {values}, {errors}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn odd_pictures_are_weighed_alike_gpu() {
    let bench = Bench::new("cornell");
    let cases = ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() };
    let strategy = (1u32..70, 1u32..70, 0.0f32..1.0, 1..FEW, any::<u32>());
    let checked = TestRunner::new(cases).run(&strategy, |(width, height, holes, rays, seed)| {
        let hash = |id: u32| conray_core::hash_u32(id ^ seed);
        let mut points = bench.points(width * height, |id| {
            let [u, v] = [hash(id), hash(id ^ 0x9e37)].map(|bits| bits as f32 / u32::MAX as f32);
            [u * (1.0 - v), v * 0.99]
        });
        for point in points.iter_mut().filter(|point| hash(point.id * 7 + 1) as f32 / 4.3e9 < holes) {
            point.position = Vec3::NAN;
        }
        let begun = Hybrid::of_image(&bench.plan, &points, 0, [width, height]);
        let [values, errors] = bench.off(&begun, &points, rays, SAME_RAYS);
        prop_assert!(values < MOST && errors < MOST, "{} {}", values, errors);
        Ok(())
    });
    checked.unwrap();
}
