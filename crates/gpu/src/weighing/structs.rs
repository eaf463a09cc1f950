//! What weighing reads and tells: twins of shaders/shared/weighing.wgsl, layer.wgsl, state.wgsl and sums.wgsl.

use bytemuck::{Pod, Zeroable};
use conray_core::Vec3;
use conray_estimate::{HybridConstants, PlaceTally, Places, RayErrors};

/// What all places share.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct WeighingUniform {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) stride: u32,
    pub(crate) points: u32,
    pub(crate) unit: f32,
    pub(crate) full: f32,
    pub(crate) enough: f32,
    pub(crate) distance: f32,
    pub(crate) cells: f32,
    pub(crate) plane: f32,
    pub(crate) cosine: f32,
    pub(crate) slope: f32,
    pub(crate) bend: f32,
    pub(crate) prior_samples: f32,
    pub(crate) beyond_chance: f32,
    pub(crate) least_noise: f32,
    pub(crate) doubt_units: f32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
    pub(crate) pad_c: u32,
}

impl WeighingUniform {
    /// Before it is known how rays err.
    pub(super) fn new(constants: &HybridConstants, places: &Places<'_>) -> Self {
        let [width, height, stride, points] =
            [places.width, places.height, places.stride, places.points].map(|count| count as u32);
        Self { points, ..Self::of_size(constants, [width, height, stride]) }
    }

    /// For a picture of that width, height and stride, of which all may have points.
    pub(crate) fn of_size(constants: &HybridConstants, [width, height, stride]: [u32; 3]) -> Self {
        Self {
            width,
            height,
            stride,
            points: width * height,
            distance: constants.distance,
            cells: constants.cells,
            plane: constants.plane,
            cosine: constants.cosine,
            slope: constants.slope,
            bend: constants.bend,
            prior_samples: constants.prior_samples,
            beyond_chance: constants.beyond_chance,
            least_noise: constants.least_noise,
            doubt_units: constants.doubt_units,
            ..Self::zeroed()
        }
    }

    pub(super) fn with_rays(self, rays: &RayErrors) -> Self {
        Self { unit: rays.unit, full: rays.full, enough: rays.enough(), ..self }
    }
}

/// What is known of a place without a ray.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuPlace {
    pub(crate) position: Vec3,
    pub(crate) sharpness: f32,
    pub(crate) normal: Vec3,
    pub(crate) pad: u32,
}

impl GpuPlace {
    pub(super) fn all(places: &Places<'_>) -> Vec<Self> {
        let [px, py, pz, nx, ny, nz] = places.place;
        let one = |at: usize| Self {
            position: Vec3::new(px[at], py[at], pz[at]),
            sharpness: places.sharpness[at],
            normal: Vec3::new(nx[at], ny[at], nz[at]),
            pad: 0,
        };
        (0..places.sharpness.len()).map(one).collect()
    }
}

/// What the rays of a place found.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuPlaceTally {
    pub(crate) units: u32,
    pub(crate) sum: f32,
    pub(crate) in_units: f32,
    pub(crate) in_fulls: f32,
}

impl GpuPlaceTally {
    pub(super) fn of(tally: &PlaceTally) -> Self {
        let PlaceTally { units, sum, in_units, in_fulls, .. } = *tally;
        Self { units, sum, in_units, in_fulls }
    }
}

/// Tallies of like places put together.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuCell {
    pub(crate) position: Vec3,
    pub(crate) worth: f32,
    pub(crate) normal: Vec3,
    pub(crate) value: f32,
}

/// Which size of cells a run is about.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LayerUniform {
    pub(crate) size: u32,
    pub(crate) again: u32,
    pub(crate) pad_a: u32,
    pub(crate) pad_b: u32,
}

/// What holds everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct WeighingState {
    pub(crate) unit: f32,
    pub(crate) sizes: u32,
    pub(crate) unit_variance: f32,
    pub(crate) pad: u32,
    pub(crate) factors: [f32; 8],
}

/// How far guesses have come.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Counts {
    pub(crate) sizes: u32,
    pub(crate) lacking: [u32; 7],
}

/// What rays tell of guesses, summed over a cell.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuSums {
    pub(crate) samples: f32,
    pub(crate) unit_variance: f32,
    pub(crate) variance: f32,
    pub(crate) pad: f32,
    pub(crate) guesses: [[f32; 2]; 6],
}
