//! Points all over surfaces, as a target: their estimates become values at vertices.

use super::{
    fit::{Element, fit},
    kinks::{Kink, kinks},
    slots::Slots,
    values::VertexValues,
};
use crate::Facing;
use conray::Session;
use conray_core::{Estimate, SurfacePoint, Vec2, Vec3, owen_sobol_2d};
use conray_target::{Target, TargetError};
use rayon::prelude::*;
use std::ops::{Range, RangeInclusive};

/// Points that every triangle gets, however small, where the mean is no less. Three values need three points that lie on no line; four are an
/// aligned block of the sequence, one in each of four parts of equal area.
const LEAST: f32 = 4.0;
/// Points of a triangle at most beyond those: it has three values, and that many points tell them as well as more would.
const MOST: u32 = 252;

/// How values are found for vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexSettings {
    /// Points for each triangle in the mean, in [`VertexSettings::SAMPLES`]: four for each, the others by area.
    pub samples_per_triangle: f32,
    /// How much kinks between triangles count against nearness to the estimates (alpha of the paper), in [`VertexSettings::SMOOTHNESS`], without a unit: 0
    /// is nearness alone; at 1 a kink at every edge counts for as much as being off by as much everywhere.
    pub smoothness: f32,
}

impl VertexSettings {
    /// Range of `samples_per_triangle`.
    pub const SAMPLES: RangeInclusive<f32> = 1.0..=256.0;
    /// Range of `smoothness`.
    pub const SMOOTHNESS: RangeInclusive<f32> = 0.0..=1000.0;

    fn validate(&self) -> Result<(), TargetError> {
        let settings = [
            ("samples-per-triangle", self.samples_per_triangle, Self::SAMPLES),
            ("smoothness", self.smoothness, Self::SMOOTHNESS),
        ];
        for (setting, found, range) in settings {
            if !range.contains(&found) {
                let problem = format!("{found} is not from {} to {}", range.start(), range.end());
                return Err(TargetError::Settings { setting, problem });
            }
        }
        Ok(())
    }
}

impl Default for VertexSettings {
    fn default() -> Self {
        // On the corner and the waves of fit/tests.rs, with noise of 0.05 on the estimates, a smoothness of 0.1 to 0.3 left the least error; on the waves
        // without noise 0.1 leaves 5 % more than none. Twice the points left 2 to 14 % less with noise, and 1 % less without.
        Self { samples_per_triangle: 8.0, smoothness: 0.1 }
    }
}

/// A triangle, and the points on it.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    instance: u32,
    triangle: u32,
    pub(super) slots: [u32; 3],
    /// In the world.
    pub(super) area: f64,
    /// Its points among all; before they are found only their number is right.
    points: Range<usize>,
}

impl Patch {
    /// A triangle without points.
    pub(super) fn new(instance: u32, triangle: u32, slots: [u32; 3], corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let area = 0.5 * (b - a).cross(c - a).length();
        Self { instance, triangle, slots, area, points: 0..0 }
    }
}

/// Points all over the triangles of surfaces.
///
/// Points are listed triangle by triangle; the `id` of each is its place in the list, its footprint the side of a square as large as the area that it stands
/// for. What comes out is one value a slot.
#[derive(Clone, Debug)]
pub struct VertexTarget {
    slots: Slots,
    smoothness: f32,
    patches: Vec<Patch>,
    kinks: Vec<Kink>,
    points: Vec<SurfacePoint>,
    /// Weights of the second and third corner of its triangle, for each point.
    places: Vec<[f32; 2]>,
    unusable: usize,
}

impl VertexTarget {
    /// Spreads points over surfaces, by area within and between triangles; the result does not depend on threads.
    ///
    /// Points that are not valid ([`SurfacePoint::is_valid`]) are left out, and counted ([`VertexTarget::unusable`]). Triangles without area get none.
    ///
    /// # Errors
    /// A setting outside its range.
    ///
    /// # Panics
    /// Where the slots are those of another scene.
    pub fn new(
        session: &Session,
        slots: Slots,
        settings: &VertexSettings,
        facing: &Facing,
    ) -> Result<Self, TargetError> {
        settings.validate()?;
        Ok(session.install(|| Self::spread(session, slots, settings, facing)))
    }

    fn spread(session: &Session, slots: Slots, settings: &VertexSettings, facing: &Facing) -> Self {
        let mut patches: Vec<Patch> = Vec::new();
        for surface in slots.surfaces() {
            let patch = |at: usize| {
                let (instance, triangle) = (surface.instance, at as u32);
                let corners = session.bvh().world_corners(instance, triangle);
                Patch::new(instance, triangle, surface.corners(at), corners)
            };
            patches.par_extend((0..surface.triangles.len()).into_par_iter().map(patch));
        }
        count_points(&mut patches, settings.samples_per_triangle);
        let found = |(seed, patch): (usize, &Patch)| {
            let footprint = (patch.area / patch.points.len() as f64).sqrt() as f32;
            let (instance, triangle) = (patch.instance, patch.triangle);
            let point = move |k: usize| {
                let place = on_triangle(owen_sobol_2d(k as u32, seed as u32));
                (place, facing.point(session, [instance, triangle], place, footprint, footprint))
            };
            (0..patch.points.len()).map(point)
        };
        let found: Vec<([f32; 2], SurfacePoint)> =
            patches.par_iter().enumerate().flat_map_iter(found).collect();
        let mut all = found.into_iter();
        let (mut points, mut places, mut unusable) = (Vec::with_capacity(all.len()), Vec::new(), 0);
        places.reserve(all.len());
        for patch in &mut patches {
            let start = points.len();
            for (place, point) in all.by_ref().take(patch.points.len()) {
                if point.is_valid() {
                    points.push(point.with_id(points.len() as u32));
                    places.push(place);
                } else {
                    unusable += 1;
                }
            }
            patch.points = start..points.len();
        }
        let corners = |patch: &Patch| session.bvh().world_corners(patch.instance, patch.triangle);
        let kinks = kinks(&patches, corners);
        Self { slots, smoothness: settings.smoothness, patches, kinks, points, places, unusable }
    }

    /// The slots that the values are of.
    pub fn slots(&self) -> &Slots {
        &self.slots
    }

    /// Points that were left out because they were not valid.
    pub fn unusable(&self) -> usize {
        self.unusable
    }

    /// The instance that each point lies on.
    pub fn instances(&self) -> Vec<u32> {
        let of = |patch: &Patch| std::iter::repeat_n(patch.instance, patch.points.len());
        self.patches.iter().flat_map(of).collect()
    }
}

impl Target for VertexTarget {
    type Output = VertexValues;

    fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// The values that fit the estimates best; pending estimates count for nothing.
    fn resolve(&self, estimates: &[Estimate]) -> Result<VertexValues, TargetError> {
        let (expected, found) = (self.points.len(), estimates.len());
        if expected != found {
            return Err(TargetError::EstimateCount { expected, found });
        }
        let element = |patch: &Patch| {
            let each = patch.area / patch.points.len() as f64;
            let samples = self.places[patch.points.clone()].iter().zip(&estimates[patch.points.clone()]);
            Element::of(patch.slots, each, samples)
        };
        let elements: Vec<Element> = self.patches.par_iter().map(element).collect();
        Ok(fit(self.slots.count(), &elements, &self.kinks, self.smoothness.into()))
    }
}

/// Says how many points triangles get: as many as every one gets, and their shares by area, which are rounded so that they add up along the list.
fn count_points(patches: &mut [Patch], mean: f32) {
    let least = mean.min(LEAST).floor();
    let (count, whole) = patches
        .iter()
        .filter(|patch| patch.area > 0.0)
        .fold((0.0, 0.0), |(n, sum), p| (n + 1.0, sum + p.area));
    let density = f64::from(mean - least) * count / whole;
    let mut along = 0.5;
    for patch in patches.iter_mut().filter(|patch| patch.area > 0.0) {
        let from = f64::floor(along);
        along += density * patch.area;
        patch.points = 0..least as usize + (along.floor() - from).min(MOST.into()) as usize;
    }
}

/// Weights of the second and third corner at the place of a triangle that belongs to one of the unit square: equal areas stay equal, and squares are bent
/// little.
///
/// Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
fn on_triangle(place: Vec2) -> [f32; 2] {
    let half = 0.5 * place.min_element();
    if place.y > place.x { [half, place.y - half] } else { [place.x - half, half] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patches(areas: &[f64]) -> Vec<Patch> {
        let patch = |&area: &f64| Patch { instance: 0, triangle: 0, slots: [0, 1, 2], area, points: 0..0 };
        areas.iter().map(patch).collect()
    }

    fn counts(areas: &[f64], mean: f32) -> Vec<usize> {
        let mut patches = patches(areas);
        count_points(&mut patches, mean);
        patches.iter().map(|patch| patch.points.len()).collect()
    }

    #[test]
    fn each_triangle_gets_its_least_and_the_others_go_by_area() {
        assert_eq!(counts(&[1.0, 1.0, 1.0, 1.0], 8.0), [8; 4]);
        assert_eq!(counts(&[2.0, 2.0, 4.0, 0.0], 8.0), [7, 7, 10, 0]);
        assert_eq!(counts(&[1.0; 4], 1.0), [1; 4]);
        assert_eq!(counts(&[1.0; 4], 2.5).iter().sum::<usize>(), 10);
        // One large triangle among many small ones does not take all.
        let mut areas = vec![1e-6; 1000];
        areas.push(1.0);
        let found = counts(&areas, 8.0);
        assert!(found[..1000].iter().all(|&count| (4..6).contains(&count)));
        assert_eq!(found[1000], 256);
        assert_eq!(counts(&[], 8.0), [0usize; 0]);
        assert_eq!(counts(&[0.0], 8.0), [0]);
    }

    #[test]
    fn points_of_a_triangle_lie_on_it_evenly() {
        // Moments of barycentric weights over a triangle: 1/3, 1/6 of their squares and 1/12 of products.
        let mean = |of: &dyn Fn([f32; 2]) -> f32, map: &dyn Fn(Vec2) -> [f32; 2]| {
            (0..4096).map(|k| of(map(owen_sobol_2d(k, 3)))).sum::<f32>() / 4096.0
        };
        let is_right = |map: &dyn Fn(Vec2) -> [f32; 2]| {
            let close = |found: f32, expected: f32| (found - expected).abs() < 1e-3;
            close(mean(&|[u, _]| u, map), 1.0 / 3.0)
                && close(mean(&|[u, v]| 1.0 - u - v, map), 1.0 / 3.0)
                && close(mean(&|[_, v]| v * v, map), 1.0 / 6.0)
                && close(mean(&|[u, v]| u * v, map), 1.0 / 12.0)
        };
        assert!(is_right(&on_triangle));
        assert!(!is_right(&|place| [place.x * (1.0 - place.y), place.y]), "not by area");
        assert!(
            (0..1000)
                .map(|k| on_triangle(owen_sobol_2d(k, 1)))
                .all(|[u, v]| u >= 0.0 && v >= 0.0 && u + v <= 1.0)
        );
    }

    #[test]
    fn the_four_points_of_a_small_triangle_surround_its_middle() {
        // Each corner has a point that it weighs at least a quarter for, whatever the seed.
        for seed in 0..500 {
            let weights = (0..4).map(|k| on_triangle(owen_sobol_2d(k, seed)));
            let all: Vec<[f32; 3]> = weights.map(|[u, v]| [1.0 - u - v, u, v]).collect();
            for corner in 0..3 {
                let most = all.iter().map(|weights| weights[corner]).fold(0.0, f32::max);
                assert!(most > 0.25, "{seed} {all:?}");
            }
        }
    }

    #[test]
    fn settings_outside_their_ranges_are_refused_by_name() {
        let wrong = |samples_per_triangle, smoothness| {
            VertexSettings { samples_per_triangle, smoothness }.validate().unwrap_err().to_string()
        };
        assert_eq!(wrong(0.5, 0.0), "samples-per-triangle: 0.5 is not from 1 to 256");
        assert_eq!(wrong(8.0, f32::NAN), "smoothness: NaN is not from 0 to 1000");
        assert!(VertexSettings::default().validate().is_ok());
    }
}
