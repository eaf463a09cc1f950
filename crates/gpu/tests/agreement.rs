//! Rays on a device against the same rays on the CPU. Needs an adapter, if only a program on the CPU (Debian: mesa-vulkan-drivers).

use conray_bvh::Bvh;
use conray_core::{
    Affine2, Affine3A, AlphaTexture, Backs, Estimate, Falloff, Geometry, Material, Opacity, SurfacePoint,
    TextureOpacity, TriangleMesh, Vec2, Vec3, Wrap,
};
use conray_estimate::{AoPlan, AoSettings, Backend, Control, CpuBackend, Distance, Method};
use conray_gpu::{Gpu, GpuBackend, GpuError, adapters};
use conray_voxel::{Octree, OctreeOptions};
use std::sync::{Arc, atomic::AtomicBool};

/// Root mean square difference that rounding may make, as the goal for all methods is.
const MOST: f64 = 0.003;

fn both(geometry: Geometry, settings: &AoSettings, points: &[SurfacePoint]) -> [Vec<Estimate>; 2] {
    let plan = AoPlan::new(settings, geometry.bounds()).unwrap();
    let gpu = Gpu::open(None).unwrap();
    let octree = settings.method.needs_octree().then(|| {
        let options = OctreeOptions { resolution: settings.voxels, ..OctreeOptions::default() };
        Arc::new(Octree::build(&geometry, &options).unwrap())
    });
    let mut on_gpu = vec![Estimate::PENDING; points.len()];
    let device = GpuBackend::new(gpu, Some(&geometry), octree.as_deref()).unwrap();
    device.estimate(&plan, 0..plan.samples(), points, &mut on_gpu, Control::none()).unwrap();
    let mut on_cpu = on_gpu.clone();
    let bvh = Arc::new(Bvh::build(Arc::new(geometry)).unwrap());
    let cpu = CpuBackend::new(bvh, octree);
    cpu.estimate(&plan, 0..plan.samples(), points, &mut on_cpu, Control::none()).unwrap();
    [on_gpu, on_cpu]
}

fn rmse([a, b]: &[Vec<Estimate>; 2]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.visibility - b.visibility).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// Points at the middles of triangles, some of them, as seen from the front.
fn middles(geometry: &Geometry, most: usize) -> Vec<SurfacePoint> {
    let bvh = Bvh::build(Arc::new(geometry.clone())).unwrap();
    let all = geometry.instances().iter().enumerate().flat_map(|(instance, _)| {
        let triangles = geometry.mesh_of(instance).triangles().len() as u32;
        (0..triangles).map(move |triangle| (instance as u32, triangle))
    });
    let all: Vec<_> = all.collect();
    let every = all.len().div_ceil(most).max(1);
    let points = all.iter().step_by(every).map(|&(i, t)| bvh.front_point(i, t, [1.0 / 3.0; 2]));
    points.filter(SurfacePoint::is_valid).zip(0..).map(|(point, id)| point.with_id(id)).collect()
}

fn settings(rays: u32) -> AoSettings {
    AoSettings { method: Method::Rays, rays: Some(rays), ..AoSettings::default() }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn built_in_scenes_agree_gpu() {
    for name in ["cornell", "atrium", "grove"] {
        let scene = conray_scene::builtin(name).unwrap();
        let points = middles(&scene.geometry, 800);
        let found = both(scene.geometry, &settings(64), &points);
        let off = rmse(&found);
        eprintln!("{name}: {} points, off by {off:.5}", points.len());
        assert!(off < MOST, "{name}: {off}");
        let bent = found[0].iter().zip(&found[1]).map(|(a, b)| f64::from((a.bent - b.bent).length_squared()));
        assert!((bent.sum::<f64>() / points.len() as f64).sqrt() < 2.0 * MOST, "{name}");
        // Errors and rays are told alike, and it is not that all is one value.
        assert!(found[0].iter().zip(&found[1]).all(|(a, b)| a.rays == b.rays));
        let [low, high] =
            [f32::min, f32::max].map(|pick| found[0].iter().map(|e| e.visibility).reduce(pick).unwrap());
        assert!(high - low > 0.5, "{name}: from {low} to {high}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn cones_of_built_in_scenes_agree_gpu() {
    for (name, falloff, cones) in
        [("cornell", Falloff::None, 16), ("atrium", Falloff::Smooth, 9), ("grove", Falloff::Linear, 16)]
    {
        let scene = conray_scene::builtin(name).unwrap();
        let mut points = middles(&scene.geometry, 500);
        // One that stands outside of the cube looks in.
        points[0].position += 3.0 * scene.geometry.bounds().diagonal() * Vec3::Y;
        points[0].geometric_normal = Vec3::NEG_Y;
        points[0].shading_normal = Vec3::NEG_Y;
        let settings = AoSettings { method: Method::Cones, falloff, cones, voxels: 128, ..settings(1) };
        let found = both(scene.geometry, &settings, &points);
        let off = rmse(&found);
        let errors = found[0].iter().zip(&found[1]).map(|(a, b)| f64::from(a.error - b.error).powi(2));
        let errors_off = (errors.sum::<f64>() / points.len() as f64).sqrt();
        eprintln!("{name}: {} points, off by {off:.5}, errors by {errors_off:.5}", points.len());
        assert!(off < MOST && errors_off < MOST, "{name}: {off} {errors_off}");
        let mean = found[0].iter().map(|e| e.visibility).sum::<f32>() / points.len() as f32;
        assert!((0.05..0.95).contains(&mean), "{name}: {mean}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn the_blend_of_built_in_scenes_agrees_gpu() {
    for (name, falloff, cones, max_rays) in
        [("cornell", Falloff::None, 16, 16), ("atrium", Falloff::Smooth, 6, 100)]
    {
        let scene = conray_scene::builtin(name).unwrap();
        let points = middles(&scene.geometry, 300);
        let settings =
            AoSettings { method: Method::Paper, falloff, cones, max_rays, voxels: 128, ..settings(1) };
        let found = both(scene.geometry, &settings, &points);
        let off = rmse(&found);
        let rays = found.iter().map(|all| all.iter().map(|e| u64::from(e.rays)).sum::<u64>());
        let rays: Vec<u64> = rays.collect();
        eprintln!("{name}: {} points, {rays:?} rays, off by {off:.5}", points.len());
        assert!(off < MOST, "{name}: {off}");
        // Where a count lies between two wholes rounding may decide.
        assert!(rays[0] > 1000 && rays[0].abs_diff(rays[1]) <= rays[1] / 1000, "{name}: {rays:?}");
    }
}

/// A floor of many points and a leaf over it, whose texture lets rays through here and there.
fn under_a_leaf(opacity: Opacity, turn: bool, normals: bool) -> (Geometry, Vec<SurfacePoint>) {
    let mut geometry = Geometry::default();
    geometry.add_material(Material { opacity, ..Material::default() });
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let positions: Vec<Vec3> = corners.map(|(x, z)| Vec3::new(x, 0.5, z)).to_vec();
    let triangles = if turn { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] };
    let uvs = corners.map(|(x, z)| Vec2::new(1.3 * x, 0.7 * z)).to_vec();
    let mut leaf = TriangleMesh::new(positions, triangles).unwrap().with_uv_set(uvs).unwrap();
    if normals {
        leaf = leaf.with_normals(vec![Vec3::Y; 4]).unwrap();
    }
    let leaf = geometry.add_mesh(leaf).unwrap();
    geometry.add_instance(leaf, Affine3A::IDENTITY).unwrap();
    geometry.add_instance(leaf, Affine3A::from_translation(Vec3::new(0.3, 0.4, 0.1))).unwrap();
    let point = |k: u32| {
        let at = Vec3::new((k % 20) as f32 * 0.1 - 1.0, 0.0, (k / 20) as f32 * 0.1 - 1.0);
        SurfacePoint::new(at, Vec3::Y).with_id(k)
    };
    (geometry, (0..400).map(point).collect())
}

fn texture(wrap: [Wrap; 2], cutoff: Option<f32>) -> Opacity {
    let texels = (0..6 * 5).map(|k| (k * 37 % 256) as u8).collect();
    Opacity::Texture(TextureOpacity {
        texture: Arc::new(AlphaTexture::new(6, 5, texels).unwrap()),
        uv_set: 0,
        texture_from_uv: Affine2::from_scale_angle_translation(
            Vec2::new(1.0, -2.0),
            0.3,
            Vec2::new(0.1, 0.7),
        ),
        wrap,
        factor: 0.9,
        cutoff,
    })
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn opacities_falloffs_and_lobes_agree_gpu() {
    let opacities = [
        Opacity::Constant(1.0),
        Opacity::Constant(0.3),
        Opacity::Constant(0.0),
        texture([Wrap::Repeat; 2], None),
        texture([Wrap::Mirror; 2], None),
        texture([Wrap::Clamp, Wrap::Repeat], None),
        texture([Wrap::Mirror, Wrap::Clamp], Some(0.4)),
    ];
    let mut told = Vec::new();
    for opacity in opacities {
        for falloff in [Falloff::None, Falloff::Linear, Falloff::Smooth] {
            let (geometry, points) = under_a_leaf(opacity.clone(), false, false);
            let settings = AoSettings { falloff, distance: Distance::World(1.5), ..settings(64) };
            let found = both(geometry, &settings, &points);
            let off = rmse(&found);
            assert!(off < MOST, "{opacity:?} {falloff}: {off}");
            told.push(found[0].iter().map(|e| e.visibility).sum::<f32>() / points.len() as f32);
        }
    }
    told.sort_by(f32::total_cmp);
    told.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
    assert!(told.len() > 8, "the cases differ: {told:?}");
    let (geometry, points) = under_a_leaf(Opacity::Constant(1.0), false, false);
    let narrow = AoSettings { spread: 60.0, bias_angle: 20.0, seed: 7, ..settings(64) };
    assert!(rmse(&both(geometry, &narrow, &points)) < MOST);
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn backs_agree_gpu() {
    let mut means = Vec::new();
    for (turn, normals) in [(false, false), (true, false), (false, true), (true, true)] {
        for mirror in [false, true] {
            let (mut geometry, points) = under_a_leaf(Opacity::Constant(1.0), turn, normals);
            if mirror {
                let mesh = geometry.instances()[0].mesh;
                geometry.add_instance(mesh, Affine3A::from_scale(Vec3::new(-1.0, 0.6, 1.0))).unwrap();
            }
            geometry.set_backs(Backs::Pass);
            let settings = AoSettings { distance: Distance::World(3.0), ..settings(64) };
            let found = both(geometry, &settings, &points);
            assert!(rmse(&found) < MOST, "{turn} {normals} {mirror}: {}", rmse(&found));
            means.push(found[0].iter().map(|e| e.visibility).sum::<f32>());
        }
    }
    assert!(means.iter().any(|mean| (mean - means[0]).abs() > 1.0), "some pass and some do not: {means:?}");
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn parts_of_a_sequence_and_odd_points_gpu() {
    let (geometry, mut points) = under_a_leaf(Opacity::Constant(1.0), false, false);
    points[3].position = Vec3::NAN;
    // The frame about a normal depends on the sign of its z, that of a zero too.
    points[20..60].iter_mut().for_each(|point| point.shading_normal = Vec3::new(0.6, 0.8, -0.0));
    points[5].shading_normal = Vec3::ZERO;
    let [on_gpu, on_cpu] = both(geometry.clone(), &settings(16), &points);
    for (at, (a, b)) in on_gpu.iter().zip(&on_cpu).enumerate() {
        assert!((a.visibility - b.visibility).abs() < 1e-5, "{at}: {a:?} {b:?}");
    }
    for at in [3, 5] {
        assert_eq!((on_gpu[at].visibility, on_gpu[at].error), (0.0, f32::INFINITY));
        assert_eq!(on_cpu[at].visibility, 0.0);
    }
    points.truncate(3);
    let gpu = Gpu::open(None).unwrap();
    let device = GpuBackend::new(gpu, Some(&geometry), None).unwrap();
    let plan = AoPlan::new(&settings(64), geometry.bounds()).unwrap();
    let part = |samples| {
        let mut found = vec![Estimate::PENDING; points.len()];
        device.estimate(&plan, samples, &points, &mut found, Control::none()).unwrap();
        found
    };
    let [whole, first, second] = [0..64, 0..40, 40..64].map(part);
    for ((whole, first), second) in whole.iter().zip(&first).zip(&second) {
        let mean = (40.0 * first.visibility + 24.0 * second.visibility) / 64.0;
        assert!((whole.visibility - mean).abs() < 1e-5);
    }
    let stopped = AtomicBool::new(true);
    let mut found = vec![Estimate::PENDING; points.len()];
    let control = Control { cancelled: &stopped, progress: &|_| {} };
    device.estimate(&plan, 0..64, &points, &mut found, control).unwrap();
    assert!(found.iter().all(Estimate::is_pending));
    // Point by point, without neighbours to share with, hybrid is rays.
    let settings_of = |method| AoSettings { method, ..settings(64) };
    let [hybrid, cones] = [Method::Hybrid, Method::Cones]
        .map(|method| AoPlan::new(&settings_of(method), geometry.bounds()).unwrap());
    let mut by_rays = found.clone();
    device.estimate(&hybrid, 0..64, &points, &mut found, Control::none()).unwrap();
    device.estimate(&plan, 0..64, &points, &mut by_rays, Control::none()).unwrap();
    assert_eq!(found, by_rays);
    // It needs an octree, which this device was not given.
    let refused = device.estimate(&cones, 0..1, &points, &mut found, Control::none()).unwrap_err();
    assert_eq!(refused.to_string(), "nothing was uploaded for method cones: build a session with it");
}

#[test]
#[ignore = "needs a graphics adapter, if only a software one"]
fn adapters_are_told_and_named_gpu() {
    let all = adapters();
    assert!(!all.is_empty());
    let name = &all[0].name;
    assert_eq!(Gpu::open(Some(&name.to_uppercase())).unwrap().facts(), &all[0]);
    let refused = Gpu::open(Some("no such thing")).err().unwrap();
    assert!(matches!(&refused, GpuError::NoAdapter { .. }));
    assert!(
        refused.to_string().contains("no such thing") && refused.to_string().contains(&name[..]),
        "{refused}"
    );
}
