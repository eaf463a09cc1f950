//! Truths are right, say by how much they err, and come to the same bits however often they are interrupted.

use super::*;
use crate::testing::{case_of, test_case};
use conray::{Affine3A, Distance, Geometry, Material, Opacity, TriangleMesh, Vec3, View};
use std::sync::atomic::{AtomicBool, AtomicU32};

const QUIET: &(dyn Fn(u64, u64) + Sync) = &|_, _| {};

fn options(error: f64, max_rays: u32) -> TruthOptions {
    TruthOptions { error, max_rays, min_rays: 1, folder: None }
}

fn kept_in(folder: &Path, error: f64, max_rays: u32) -> TruthOptions {
    TruthOptions { folder: Some(folder.into()), ..options(error, max_rays) }
}

fn find(case: &Case, options: &TruthOptions) -> Truth {
    Truth::find(case, options, Control::none(), QUIET).unwrap()
}

fn with_seed(case: &Case, seed: u32) -> Case {
    let mut case = case.clone();
    case.settings.seed = seed;
    case
}

fn mean_square(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0), |(sum, count), e| (sum + e * e, count + 1));
    sum / f64::from(count.max(1))
}

/// Root mean squares, over several truths, of what they say they err by and of what they do against `reference`.
fn stated_and_actual(truths: &[Truth], reference: &[f32]) -> [f64; 2] {
    let stated = mean_square(truths.iter().map(|truth| truth.error));
    let errors = |truth: &Truth| -> Vec<f64> {
        truth.visibility.iter().zip(reference).map(|(a, b)| f64::from(*a) - f64::from(*b)).collect()
    };
    let actual = mean_square(truths.iter().flat_map(errors));
    [stated.sqrt(), actual.sqrt()]
}

/// Whether a statement of the error is right.
fn is_right([stated, actual]: [f64; 2]) -> bool {
    (0.75..1.25).contains(&(stated / actual))
}

/// A floor under a ceiling that lets half through, at half the AO distance; all that is seen is floor.
fn half_open_room() -> Case {
    let square = |height: f32| {
        let corners =
            [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| Vec3::new(x, y, height));
        TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    };
    let mut geometry = Geometry::default();
    geometry.add_material(Material::default());
    geometry.add_material(Material { opacity: Opacity::Constant(0.5), ..Material::default() });
    for (height, material) in [(0.0, 0), (0.5, 1)] {
        let mesh = geometry.add_mesh(square(height).with_material(material)).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    let eye = Vec3::new(0.0, 0.0, 0.4);
    let view = View { name: "down".into(), eye, look_at: Vec3::ZERO, up: Vec3::Y, vertical_fov_deg: 60.0 };
    let settings = AoSettings { distance: Distance::World(1.0), voxels: 16, ..AoSettings::default() };
    case_of(geometry, view, 16, settings)
}

#[test]
fn a_closed_form_is_met_as_closely_as_stated() {
    let case = half_open_room();
    assert_eq!(case.points().len(), 256);
    // Directions whose cosine is above 1/2 reach the ceiling in time: 3/4 of the measure, half of it closed.
    let expected = 1.0 - 0.5 * 0.75;
    let truths: Vec<_> = (0..4).map(|seed| find(&with_seed(&case, seed), &options(1e-9, 256))).collect();
    let check = |expected: f32| is_right(stated_and_actual(&truths, &[expected; 256]));
    assert!(check(expected), "{:?}", stated_and_actual(&truths, &[expected; 256]));
    assert!(!check(expected * 1.02), "a wrong truth must be caught");
}

/// Truths of `cornell` by 128 rays for several seeds, and one by many more rays.
fn cornell_truths(seeds: impl Fn(u32) -> [u32; 2]) -> (Vec<Truth>, Truth) {
    let case = test_case(16);
    let with_seeds = |seeds, rays| {
        let all = TruthOptions { min_rays: rays, ..options(1.0, rays) };
        find_with_seeds(&case, &all, seeds, Control::none(), QUIET).unwrap()
    };
    ((0..8).map(|seed| with_seeds(seeds(seed), 128)).collect(), with_seeds(half_seeds(1000), 1 << 14))
}

#[test]
fn the_stated_error_is_the_actual_one() {
    let (truths, reference) = cornell_truths(half_seeds);
    let found = stated_and_actual(&truths, &reference.visibility);
    assert!(is_right(found), "{found:?}");
    assert!(reference.error < 0.1 * found[1], "the reference is far better: {}", reference.error);
}

#[test]
fn halves_that_share_their_rays_are_caught() {
    let (truths, reference) = cornell_truths(|seed| [half_seeds(seed)[0]; 2]);
    assert!(!is_right(stated_and_actual(&truths, &reference.visibility)));
}

#[test]
fn rays_stop_where_the_error_is_small_enough_and_not_before() {
    let case = test_case(12);
    let wanted = 0.01;
    let truth = find(&case, &options(wanted, 1 << 14));
    let fewer = find(&case, &options(1e-9, truth.rays / 2));
    assert!(truth.error <= wanted && fewer.error > wanted && fewer.rays == truth.rays / 2, "{}", fewer.error);
    // Numbers of rays that are no powers of two.
    assert_eq!(find(&case, &options(1e-9, 127)).rays, 64);
    assert_eq!(find(&case, &TruthOptions { min_rays: 100, ..options(1.0, 1000) }).rays, 128);
    assert_eq!(find(&case, &options(1e-9, 1)).rays, LEAST_RAYS);
}

#[test]
fn nothing_is_traced_twice_and_later_searches_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let case = test_case(12);
    let points = case.points().len() as u64;
    // Rays between the first progress and the last.
    let traced = |options: &TruthOptions| {
        let (calls, most) = (AtomicU32::new(0), AtomicU64::new(0));
        let progress = |done: u64, total: u64| {
            calls.fetch_add(1, Ordering::Relaxed);
            most.fetch_max(done, Ordering::Relaxed);
            assert!(done <= total, "{done} of {total}");
        };
        let truth = Truth::find(&case, options, Control::none(), &progress).unwrap();
        (truth, calls.into_inner(), most.into_inner())
    };
    let (coarse, calls, most) = traced(&kept_in(folder.path(), 1e-9, 128));
    assert!(calls > 0 && most == 128 * points);
    let (again, calls, _) = traced(&kept_in(folder.path(), 1e-9, 128));
    assert_eq!((&again, calls), (&coarse, 0));
    let (fine, calls, most) = traced(&kept_in(folder.path(), 1e-9, 512));
    assert_eq!(fine, find(&case, &options(1e-9, 512)));
    assert!(most == 512 * points);
    let blocks = points.div_ceil(64) as u32;
    assert_eq!(calls, 4 * blocks, "two doublings of two halves");
    // A finer truth at hand does not change what a coarser search finds.
    assert_eq!(traced(&kept_in(folder.path(), 1e-9, 128)).0, coarse);
    assert_ne!(fine.visibility, coarse.visibility);
}

#[test]
fn an_interrupted_search_comes_to_the_same_bits() {
    let (broken, unbroken) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let case = test_case(12);
    let points = case.points().len() as u64;
    let mut interruptions = 0;
    // Stopped in each slice in turn; what the stopped slice did is lost.
    for rays in (16..1024).step_by(48) {
        let cancelled = AtomicBool::new(false);
        let control = Control { cancelled: &cancelled, progress: &|_| {} };
        let stop = |done: u64, _: u64| cancelled.fetch_or(done > rays * points, Ordering::Relaxed);
        let progress = |done: u64, total: u64| {
            stop(done, total);
        };
        match Truth::find(&case, &kept_in(broken.path(), 1e-9, 1024), control, &progress) {
            Err(StudyError::Interrupted) => interruptions += 1,
            other => panic!("{other:?}"),
        }
    }
    assert!(interruptions > 10);
    let found = find(&case, &kept_in(broken.path(), 1e-9, 1024));
    assert_eq!(found, find(&case, &kept_in(unbroken.path(), 1e-9, 1024)));
    assert_eq!(found, find(&case, &options(1e-9, 1024)), "kept or not makes no difference");
    let only = |folder: &Path| {
        let mut files = fs::read_dir(folder).unwrap();
        let path = files.next().unwrap().unwrap().path();
        assert!(files.next().is_none());
        (path.file_name().unwrap().to_owned(), fs::read(&path).unwrap())
    };
    assert_eq!(only(broken.path()), only(unbroken.path()));
}

#[test]
fn damaged_files_and_closed_folders_stop_it_before_any_ray() {
    let folder = tempfile::tempdir().unwrap();
    let case = test_case(6);
    let never = &|_, _| panic!("no ray must be traced");
    find(&case, &kept_in(folder.path(), 1e-9, 64));
    let path = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&path).unwrap();
    bytes[100] ^= 1;
    fs::write(&path, bytes).unwrap();
    let error = Truth::find(&case, &kept_in(folder.path(), 1e-9, 64), Control::none(), never).unwrap_err();
    assert!(matches!(&error, StudyError::Kept { path: found, .. } if *found == path), "{error}");

    let closed = path.join("beneath a file");
    let error = Truth::find(&case, &kept_in(&closed, 1e-9, 64), Control::none(), never).unwrap_err();
    assert!(matches!(error, StudyError::Output { .. }), "{error}");
}

#[test]
fn seeds_differ_from_each_other_and_from_the_judged() {
    for judged in (0..1000).chain([0x7eed, u32::MAX, SEED_SALT]) {
        let [a, b] = half_seeds(judged);
        assert!(a != b && a != judged && b != judged, "{judged}");
    }
}

#[test]
fn slices_are_powers_of_two_of_bounded_work() {
    for points in [0, 1, 64, 1000, 262_144, 1 << 24, 1 << 30] {
        let slice = slice_rays(points);
        assert!(slice.is_power_of_two() && slice <= SLICE_RAYS_PER_POINT);
        assert!(slice == 1 || u64::from(slice) * points as u64 <= SLICE_RAYS, "{points}");
    }
    assert_eq!(slice_rays(262_144), 256);
}
