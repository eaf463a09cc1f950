//! Cones over the hemisphere: partitions into cells of equal cosine weight, and the usual six.

use crate::{LANES, Vec2, Vec3, cosine_hemisphere, cosine_hemisphere_lanes, square_from_disc, uniform_cone};
use fearless_simd::{Simd, f32x16, prelude::*};
use std::f32::consts::{FRAC_PI_3, FRAC_PI_6, TAU};
use std::fmt;

/// Which cones stand for the hemisphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ConeSet {
    /// One cone about the normal and five at 60 degrees from it, each 60 degrees wide, with weights 1/4 and 3/20.
    ///
    /// The set in common use since Crassin, Neyret, Sainz, Green, Eisemann, "Interactive Indirect Illumination Using
    /// Voxel Cone Tracing", 2011. The cones leave gaps between them, so their rays do not converge to the truth.
    Six,
    /// 3 x 3 cells of equal weight.
    Nine,
    /// 4 x 4 cells of equal weight.
    #[default]
    Sixteen,
    /// 5 x 5 cells of equal weight.
    TwentyFive,
}

impl ConeSet {
    /// Every set, for tests and help texts.
    pub const ALL: [Self; 4] = [Self::Six, Self::Nine, Self::Sixteen, Self::TwentyFive];

    /// The set of that many cones.
    pub fn from_count(count: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|set| set.count() == count)
    }

    /// How many cones.
    pub fn count(self) -> u32 {
        match self {
            Self::Six => 6,
            Self::Nine => 9,
            Self::Sixteen => 16,
            Self::TwentyFive => 25,
        }
    }
}

impl fmt::Display for ConeSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.count().fmt(f)
    }
}

/// What part of the hemisphere a cone stands for, in a frame whose z is the normal.
#[derive(Clone, Copy, Debug)]
enum Region {
    /// Cosine-weighted image of a square cell: lowest corner and edge length in the unit square.
    Cell(Vec2, f32),
    /// All directions within the half-angle of the axis.
    Cap,
}

/// One cone, in a frame whose z is the normal.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Unit axis.
    pub axis: Vec3,
    /// Half of the aperture. For a cell: of the cone with the cell's solid angle.
    pub half_angle_rad: f32,
    /// Share of the cosine-weighted hemisphere; the weights of a set sum to 1.
    pub weight: f32,
    region: Region,
}

impl Cone {
    /// Direction of a ray inside the cone for `u` in the unit square.
    ///
    /// In a cell the density is the cosine's, so that rays of all cells converge to the visibility. In a cap it is
    /// uniform in solid angle.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec3 {
        match self.region {
            Region::Cell(low, edge) => cosine_hemisphere(low + u * edge),
            Region::Cap => uniform_cone(u, self.axis, self.half_angle_rad),
        }
    }

    /// The square of the unit square, by its lowest corner and its edge, that is taken to the cone by the cosine-weighted map; `None` for caps.
    pub fn cell(&self) -> Option<(Vec2, f32)> {
        match self.region {
            Region::Cell(low, edge) => Some((low, edge)),
            Region::Cap => None,
        }
    }

    /// [`Cone::sample`] for sixteen points of the square; in cells but for the roundings of
    /// [`cosine_hemisphere_lanes`](crate::cosine_hemisphere_lanes), in caps one after the other.
    #[inline(always)]
    pub fn sample_lanes<S: Simd>(&self, simd: S, [u, v]: [f32x16<S>; 2]) -> [f32x16<S>; 3] {
        match self.region {
            Region::Cell(low, edge) => {
                let edge = f32x16::splat(simd, edge);
                let (x, y) = (f32x16::splat(simd, low.x) + u * edge, f32x16::splat(simd, low.y) + v * edge);
                cosine_hemisphere_lanes(simd, [x, y])
            }
            Region::Cap => self.sample_cap_lanes(simd, u.into(), v.into()),
        }
    }

    #[inline(always)]
    fn sample_cap_lanes<S: Simd>(&self, simd: S, u: [f32; LANES], v: [f32; LANES]) -> [f32x16<S>; 3] {
        let mut axes = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let direction = uniform_cone(Vec2::new(u[lane], v[lane]), self.axis, self.half_angle_rad);
            (axes[0][lane], axes[1][lane], axes[2][lane]) = direction.into();
        }
        [f32x16::simd_from(simd, axes[0]), f32x16::simd_from(simd, axes[1]), f32x16::simd_from(simd, axes[2])]
    }
}

/// The cones of a set.
#[derive(Clone, Debug)]
pub struct HemisphereCones {
    cones: Vec<Cone>,
}

impl HemisphereCones {
    /// Makes the cones of a set.
    pub fn new(set: ConeSet) -> Self {
        let cones = match set {
            ConeSet::Six => six(),
            ConeSet::Nine => cells(3),
            ConeSet::Sixteen => cells(4),
            ConeSet::TwentyFive => cells(5),
        };
        Self { cones }
    }

    /// The cones, in a fixed order.
    pub fn cones(&self) -> &[Cone] {
        &self.cones
    }

    /// Half of the aperture that stands for all cones where one must: that of a cone with their mean solid angle.
    pub fn half_angle_rad(&self) -> f32 {
        let mean_cos =
            self.cones.iter().map(|c| c.half_angle_rad.cos()).sum::<f32>() / self.cones.len() as f32;
        mean_cos.acos()
    }
}

fn six() -> Vec<Cone> {
    let cap = |axis, weight| Cone { axis, half_angle_rad: FRAC_PI_6, weight, region: Region::Cap };
    let tilted = (0..5).map(|i| {
        let (sin, cos) = (TAU * i as f32 / 5.0).sin_cos();
        let (sin_tilt, cos_tilt) = FRAC_PI_3.sin_cos();
        cap(Vec3::new(sin_tilt * cos, sin_tilt * sin, cos_tilt), 0.15)
    });
    std::iter::once(cap(Vec3::Z, 0.25)).chain(tilted).collect()
}

/// n x n cells of the unit square, taken to the hemisphere by the cosine-weighted map.
fn cells(n: u32) -> Vec<Cone> {
    let edge = 1.0 / n as f32;
    let cell = |(i, (axis, solid_angle)): (u32, (Vec3, f32))| Cone {
        axis,
        // Solid angle of a cap: 2 pi (1 - cos a).
        half_angle_rad: (1.0 - solid_angle / TAU).acos(),
        weight: edge * edge,
        region: Region::Cell(Vec2::new((i % n) as f32, (i / n) as f32) * edge, edge),
    };
    (0..).zip(axes_and_solid_angles(n)).map(cell).collect()
}

/// Mean direction (cosine-weighted) and solid angle of each of n x n cells.
///
/// By the midpoint rule over the hemisphere itself, where the solid angle has no singularity at the horizon.
fn axes_and_solid_angles(n: u32) -> Vec<(Vec3, f32)> {
    const STEPS: u32 = 512;
    let mut sums = vec![(glam::DVec3::ZERO, 0u32); (n * n) as usize];
    for i in 0..STEPS * STEPS {
        let z = ((i / STEPS) as f32 + 0.5) / STEPS as f32;
        let (sin, cos) = (TAU * ((i % STEPS) as f32 + 0.5) / STEPS as f32).sin_cos();
        let disc = Vec2::new(cos, sin) * (1.0 - z * z).sqrt();
        let cell = (square_from_disc(disc) * n as f32).as_uvec2().min(glam::UVec2::splat(n - 1));
        let (axis, count) = &mut sums[(cell.y * n + cell.x) as usize];
        *axis += (disc.extend(z) * z).as_dvec3();
        *count += 1;
    }
    let patch = TAU / (STEPS * STEPS) as f32;
    sums.iter().map(|(axis, count)| (axis.normalize().as_vec3(), *count as f32 * patch)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Moments, owen_sobol_2d};

    #[test]
    fn weights_sum_to_one_and_axes_are_above_the_horizon() {
        for set in ConeSet::ALL {
            let cones = HemisphereCones::new(set);
            assert_eq!(cones.cones().len(), set.count() as usize);
            assert_eq!(ConeSet::from_count(set.count()), Some(set));
            let sum: f32 = cones.cones().iter().map(|c| c.weight).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{set}: {sum}");
            for c in cones.cones() {
                assert!((c.axis.length() - 1.0).abs() < 1e-5 && c.axis.z > 0.1);
                assert!(c.half_angle_rad > 0.0 && c.half_angle_rad < std::f32::consts::FRAC_PI_2);
            }
        }
    }

    #[test]
    fn sixteen_samples_at_once_are_those_one_by_one() {
        #[inline(always)]
        fn sampled<S: Simd>(simd: S, cone: &Cone, u: [f32; LANES], v: [f32; LANES]) -> [[f32; LANES]; 3] {
            cone.sample_lanes(simd, [f32x16::simd_from(simd, u), f32x16::simd_from(simd, v)]).map(Into::into)
        }
        let points: [Vec2; LANES] = std::array::from_fn(|i| owen_sobol_2d(i as u32, 9));
        let (u, v) = (points.map(|p| p.x), points.map(|p| p.y));
        for set in ConeSet::ALL {
            for cone in HemisphereCones::new(set).cones() {
                let expected = points.map(|p| cone.sample(p));
                for level in crate::simd_levels() {
                    let found = fearless_simd::dispatch!(level, simd => sampled(simd, cone, u, v));
                    for lane in 0..LANES {
                        let direction = Vec3::new(found[0][lane], found[1][lane], found[2][lane]);
                        // Near the horizon the root magnifies roundings.
                        let error = direction.distance(expected[lane]);
                        assert!(error < 1e-3, "{set} at {level:?}: {direction} {}", expected[lane]);
                    }
                }
            }
        }
    }

    #[test]
    fn solid_angles_of_a_partition_fill_the_hemisphere() {
        for set in [ConeSet::Nine, ConeSet::Sixteen, ConeSet::TwentyFive] {
            let solid: f32 =
                HemisphereCones::new(set).cones().iter().map(|c| TAU * (1.0 - c.half_angle_rad.cos())).sum();
            assert!((solid / TAU - 1.0).abs() < 0.004, "{set}: {solid}");
        }
    }

    #[test]
    fn rays_of_all_cells_converge_to_the_cosine_weighted_integral() {
        // A cap of half-angle a about the normal carries sin^2 a; so does the sum over cells of their rays in the cap.
        for set in [ConeSet::Nine, ConeSet::Sixteen, ConeSet::TwentyFive] {
            let cones = HemisphereCones::new(set);
            for half_angle_rad in [0.3f32, 0.8, 1.3] {
                let draws: Moments = (0..64)
                    .map(|seed| {
                        let inside = |c: &Cone, k: u32| {
                            let hits = (0..64).filter(|&i| {
                                c.sample(owen_sobol_2d(i, hash(seed, k))).z > half_angle_rad.cos()
                            });
                            c.weight * hits.count() as f32 / 64.0
                        };
                        f64::from(cones.cones().iter().zip(0..).map(|(c, k)| inside(c, k)).sum::<f32>())
                    })
                    .collect();
                let truth = f64::from(half_angle_rad.sin().powi(2));
                assert!(
                    (draws.mean - truth).abs() < 4.0 * draws.standard_error() + 1e-6,
                    "{set}: {draws:?} {truth}"
                );
            }
        }
    }

    fn hash(seed: u32, cone: u32) -> u32 {
        crate::hash_u32(seed * 1000 + cone)
    }
}
