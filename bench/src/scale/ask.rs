//! The measurements, a function for each question.

use super::{Answer, Series, tessellated};
use crate::{
    Judged,
    cone_sets::ConeSets,
    hemispheres::Hemispheres,
    judged,
    kernels::{Bundles, Kernel},
    memory,
    octree_build::OctreeBuild,
    race,
};
use conray::{AoSettings, ConeSet, Distance};
use conray_bvh::Bvh;
use conray_voxel::{Octree, OctreeOptions};
use std::{error::Error, sync::Arc, time::Instant};

/// How much is measured.
#[derive(Clone, Debug)]
pub struct ScaleOptions {
    /// Built-in scenes, or files.
    pub scenes: Vec<String>,
    /// Side of the image whose points are taken, in pixels.
    pub side: u32,
    /// Timed rounds.
    pub rounds: usize,
    /// Most triangles.
    pub most_triangles: u64,
    /// A scene with instances, measured as it is.
    pub instanced: Option<String>,
}

/// Rays per point where that is not the question.
const RAYS: usize = 64;
/// Octree resolution where that is not the question.
const VOXELS: u32 = 512;
/// Shares of the scene's diagonal; no distance in a scene exceeds 1, which is asked for as infinite.
const DISTANCES: [f32; 6] = [0.05, 0.1, 0.2, 0.4, 0.7, 1.0];
const TRIANGLES: [u64; 8] = [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000, 20_000_000];
/// Free bytes without which a count of triangles is left out: twice what the builds were seen to take at their peak, 4.7 GB
/// for 20 million.
const BYTES_PER_TRIANGLE: u64 = 480;
/// Builds that take less are done again.
const SHORT_BUILD_SECS: f64 = 1.0;

const MICROSECONDS: &str = "microseconds a point, all threads";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

impl ScaleOptions {
    fn points_of(&self, judged: Judged, distance: Distance) -> Result<Hemispheres> {
        let settings = AoSettings { distance, ..AoSettings::default() };
        Ok(Hemispheres::new(judged, &settings, self.side)?)
    }

    /// Microseconds of all threads for the rays of a point, in bundles.
    fn hemisphere_us(&self, scene: &Hemispheres, rays: usize) -> f64 {
        let (bvh, distance) = (scene.session.bvh(), scene.distance);
        let kernels: [Box<dyn Kernel + '_>; 1] = [Box::new(Bundles { bvh, distance })];
        let race = race::race(&scene.points, rays, &kernels, self.rounds);
        race.finishes[0].seconds / scene.points.len() as f64 * 1e6
    }

    /// Microseconds of all threads for the 16 cones of a point.
    fn cones_us(&self, scene: &Hemispheres, octree: &Octree) -> f64 {
        let (seconds, _) =
            ConeSets::new(octree, ConeSet::Sixteen, scene.distance).time(&scene.points, self.rounds);
        seconds / scene.points.len() as f64 * 1e6
    }

    /// Seconds of the BVH build, the middle of three where it is short.
    fn bvh_seconds(&self, scene: &Hemispheres) -> Result<f64> {
        let mut seconds = vec![scene.session.report().bvh_seconds];
        while seconds[0] < SHORT_BUILD_SECS && seconds.len() < 3 {
            let start = Instant::now();
            Bvh::build(Arc::clone(scene.session.bvh().geometry()))?;
            seconds.push(start.elapsed().as_secs_f64());
        }
        Ok(race::median(&mut seconds))
    }
}

fn octree(scene: &Hemispheres, resolution: u32) -> Result<Octree> {
    let options = OctreeOptions { resolution, ..OctreeOptions::default() };
    Ok(Octree::build(scene.session.geometry(), &options)?)
}

/// Cost against triangles: built-in scenes cut finer and finer, the rays and cones of their points and both builds.
///
/// # Errors
/// What loading or building says.
pub fn triangles(options: &ScaleOptions, tell: &dyn Fn(&str)) -> Result<[Answer; 2]> {
    let (mut costs, mut builds) = (Vec::new(), Vec::new());
    for name in &options.scenes {
        let mut rays = Series::new(format!("64 rays, {name}"));
        let mut cones = Series::new(format!("16 cones, {name}"));
        let mut bvh = Series::new(format!("BVH, {name}"));
        let mut voxels = Series::new(format!("octree at 512, {name}"));
        let coarse = judged(name)?;
        let base = coarse.scene.geometry.triangle_count();
        let mut before = 0;
        for target in TRIANGLES.into_iter().filter(|t| *t <= options.most_triangles) {
            let segments = (target as f64 / base as f64).sqrt().round().max(1.0) as u32;
            let count = base * u64::from(segments).pow(2);
            // Coarse scenes begin later; and nothing is measured twice.
            if count == before || count > target * 3 / 2 {
                continue;
            }
            before = count;
            if memory::available().is_some_and(|bytes| bytes < count * BYTES_PER_TRIANGLE) {
                tell(&format!("{name}: {count} triangles are left out, memory is short"));
                continue;
            }
            tell(&format!("{name}: {count} triangles"));
            let mut finer = judged(name)?;
            finer.scene.geometry = tessellated(&coarse.scene.geometry, segments)?;
            let scene = options.points_of(finer, Distance::Auto)?;
            let x = count as f64;
            bvh.points.push([x, options.bvh_seconds(&scene)?]);
            rays.points.push([x, options.hemisphere_us(&scene, RAYS)]);
            let times = if count < 1_000_000 { 3 } else { 1 };
            let build = OctreeBuild::time(scene.session.geometry(), VOXELS, times)?;
            voxels.points.push([x, build.seconds.median]);
            cones.points.push([x, options.cones_us(&scene, &octree(&scene, VOXELS)?)]);
        }
        costs.extend([rays, cones]);
        builds.extend([bvh, voxels]);
    }
    if let Some(name) = &options.instanced {
        tell(&format!("{name}: as it is, with instances"));
        let scene = options.points_of(judged(name)?, Distance::Auto)?;
        let x = scene.session.geometry().triangle_count() as f64;
        let one = |name: String, y| Series { name, points: vec![[x, y]] };
        costs.push(one(format!("64 rays, {name} (instances)"), options.hemisphere_us(&scene, RAYS)));
        builds.push(one(format!("BVH, {name} (instances)"), options.bvh_seconds(&scene)?));
    }
    Ok(by_triangles(costs, builds))
}

fn by_triangles(costs: Vec<Series>, builds: Vec<Series>) -> [Answer; 2] {
    let answer = |name, title, y_title, series| Answer { name, title, x_title: "triangles", y_title, series };
    [
        answer("triangles", "Time of a point against triangles", MICROSECONDS, costs),
        answer("builds", "Build time against triangles", "seconds", builds),
    ]
}

/// Cost against octree resolution.
///
/// # Errors
/// What loading or building says.
pub fn resolution(options: &ScaleOptions, tell: &dyn Fn(&str)) -> Result<[Answer; 2]> {
    let (mut costs, mut builds) = (Vec::new(), Vec::new());
    for name in &options.scenes {
        let scene = options.points_of(judged(name)?, Distance::Auto)?;
        let mut cones = Series::new(format!("16 cones, {name}"));
        let mut build = Series::new(format!("build, {name}"));
        for resolution in [128, 256, 512, 1024, 2048] {
            tell(&format!("{name}: octree at {resolution}"));
            let x = f64::from(resolution);
            let times = if resolution < 1024 { 3 } else { 1 };
            let built = OctreeBuild::time(scene.session.geometry(), resolution, times)?;
            build.points.push([x, built.seconds.median]);
            cones.points.push([x, options.cones_us(&scene, &octree(&scene, resolution)?)]);
        }
        costs.push(cones);
        builds.push(build);
    }
    let answer = |name, title, y_title, series| {
        let x_title = "octree leaves along the longest side";
        Answer { name, title, x_title, y_title, series }
    };
    Ok([
        answer("resolution", "Time of a point's cones against resolution", MICROSECONDS, costs),
        answer("octree-builds", "Octree build against resolution", "seconds", builds),
    ])
}

/// Cost against AO distance.
///
/// # Errors
/// What loading or building says.
pub fn distance(options: &ScaleOptions, tell: &dyn Fn(&str)) -> Result<Answer> {
    let mut series = Vec::new();
    for name in &options.scenes {
        let mut scene = options.points_of(judged(name)?, Distance::Auto)?;
        let octree = octree(&scene, VOXELS)?;
        let mut rays = Series::new(format!("64 rays, {name}"));
        let mut cones = Series::new(format!("16 cones, {name}"));
        for share in DISTANCES {
            tell(&format!("{name}: distance {share} of the diagonal"));
            let length = share * scene.session.bounds().diagonal();
            scene.distance = if share < 1.0 { length } else { f32::INFINITY };
            rays.points.push([f64::from(share), options.hemisphere_us(&scene, RAYS)]);
            cones.points.push([f64::from(share), options.cones_us(&scene, &octree)]);
        }
        series.extend([rays, cones]);
    }
    let title = "Time of a point against AO distance";
    let x_title = "AO distance, shares of the diagonal (1: infinite)";
    Ok(Answer { name: "distance", title, x_title, y_title: MICROSECONDS, series })
}

/// Cost against rays per point.
///
/// # Errors
/// What loading or building says.
pub fn rays(options: &ScaleOptions, tell: &dyn Fn(&str)) -> Result<Answer> {
    let mut series = Vec::new();
    for name in &options.scenes {
        let scene = options.points_of(judged(name)?, Distance::Auto)?;
        let mut rays = Series::new(name.as_str());
        for count in [4, 8, 16, 32, 64, 128, 256, 512, 1024] {
            tell(&format!("{name}: {count} rays"));
            rays.points.push([count as f64, options.hemisphere_us(&scene, count)]);
        }
        series.push(rays);
    }
    let title = "Time of a point against its rays";
    Ok(Answer { name: "rays", title, x_title: "rays per point", y_title: MICROSECONDS, series })
}
