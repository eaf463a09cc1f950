//! Maps as a target: the surface points behind their texels.

use super::{coverage::Touched, map::AtlasMap, owners::Owners};
use crate::{Target, TargetError, target::check_count};
use conray_core::{Estimate, SurfacePoint, Vec2, Vec3};
use rayon::prelude::*;

/// Size of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapSize {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Triangles that read a map.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Which map.
    pub map: usize,
    /// UVs of each triangle's corners, in shares of the map; (0, 0) is the upper left corner.
    pub uvs: Vec<[Vec2; 3]>,
}

/// The texels of maps, as surface points: one for each texel that a surface reads, or one for each part of it that is covered where texels
/// are divided (`supersample`).
///
/// Points are listed map by map, row by row; the `id` of each is its texel, counted through all maps, or its place in the list where texels
/// are divided.
#[derive(Clone, Debug)]
pub struct AtlasTarget {
    sizes: Vec<MapSize>,
    /// Area of each map, in texels, that is covered more than once.
    overlaps: Vec<f64>,
    points: Vec<SurfacePoint>,
    /// For each point its texel, counted through all maps, and how much it counts for there.
    texels: Vec<(u32, f32)>,
    /// For each point the surface that it lies on.
    surfaces: Vec<u32>,
    unusable: usize,
}

/// A part of a texel, and the point that stands for it.
struct Sample {
    texel: u32,
    surface: u32,
    area: f32,
    off: f32,
    point: SurfacePoint,
}

impl AtlasTarget {
    /// Finds the texels that surfaces read, in parallel; the result does not depend on threads.
    ///
    /// `point(surface, triangle, weights)` is the surface point at those weights of a triangle's corners; `id` is set here, and `footprint`
    /// from what it tells is that of a texel. With `supersample` n each texel is divided into n x n parts. A point that is not
    /// valid ([`SurfacePoint::is_valid`]) is left out, and counted ([`AtlasTarget::unusable`]).
    pub fn new(
        sizes: Vec<MapSize>,
        surfaces: &[Surface],
        supersample: u32,
        point: impl Fn(usize, usize, [f32; 3]) -> SurfacePoint + Sync,
    ) -> Self {
        let fine = supersample.max(1);
        let mut target = Self {
            sizes,
            overlaps: Vec::new(),
            points: Vec::new(),
            texels: Vec::new(),
            surfaces: Vec::new(),
            unusable: 0,
        };
        let mut first = 0u32;
        for (map, &MapSize { width, height }) in target.sizes.clone().iter().enumerate() {
            let scale = Vec2::new((width * fine) as f32, (height * fine) as f32);
            let mut triangles = Vec::new();
            let mut whose = Vec::new();
            for (s, surface) in surfaces.iter().enumerate().filter(|(_, surface)| surface.map == map) {
                triangles.extend(surface.uvs.iter().map(|uvs| uvs.map(|uv| uv * scale)));
                whose.extend((0..surface.uvs.len()).map(|triangle| (s, triangle)));
            }
            let owners = Owners::new(&triangles, [width * fine, height * fine], fine as f32);
            let sample = |index: u32, touched: Touched| {
                let (surface, triangle) = whose[index as usize];
                let [x, y] = touched.texel.map(|place| place / fine);
                let point = point(surface, triangle, touched.weights);
                let texel = first + y * width + x;
                Sample { texel, surface: surface as u32, area: touched.area, off: touched.off, point }
            };
            target.overlaps.push(owners.overlap / f64::from(fine * fine));
            let mut samples: Vec<Sample> = owners.each(&triangles, sample).into_iter().flatten().collect();
            if fine > 1 {
                samples.par_sort_by_key(|sample| sample.texel);
                samples = chosen(samples);
            }
            for Sample { texel, surface, area, point, .. } in samples {
                if !point.is_valid() {
                    target.unusable += 1;
                    continue;
                }
                let part = target.points.len() as u32;
                let id = if fine > 1 { part } else { texel };
                target.points.push(SurfacePoint { id, footprint: point.footprint / fine as f32, ..point });
                target.texels.push((texel, if area > 0.0 { area } else { 1.0 }));
                target.surfaces.push(surface);
            }
            first += width * height;
        }
        target
    }

    /// Area of each map, in texels, that surfaces cover more than once: what is baked there is right for one of them only.
    pub fn overlaps(&self) -> &[f64] {
        &self.overlaps
    }

    /// Points that were left out because they were not valid.
    pub fn unusable(&self) -> usize {
        self.unusable
    }

    /// The surface that each point lies on.
    pub fn surfaces(&self) -> &[u32] {
        &self.surfaces
    }
}

/// Of the parts of each texel those that are covered, else the one that lies nearest to a surface.
fn chosen(samples: Vec<Sample>) -> Vec<Sample> {
    let mut out: Vec<Sample> = Vec::with_capacity(samples.len());
    for sample in samples {
        match out.last_mut().filter(|last| last.texel == sample.texel) {
            Some(last) if last.area == 0.0 => {
                if sample.area > 0.0 || sample.off < last.off {
                    *last = sample;
                }
            }
            Some(_) if sample.area == 0.0 => {}
            _ => out.push(sample),
        }
    }
    out
}

impl Target for AtlasTarget {
    type Output = Vec<AtlasMap>;

    fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// The maps, not extended yet; pending estimates leave their texels without a value.
    fn resolve(&self, estimates: &[Estimate]) -> Result<Vec<AtlasMap>, TargetError> {
        check_count(&self.points, estimates)?;
        let mut maps: Vec<AtlasMap> =
            self.sizes.iter().map(|size| AtlasMap::empty(size.width, size.height)).collect();
        let of = |texel: u32| {
            let mut at = texel as usize;
            for (map, size) in self.sizes.iter().enumerate() {
                let count = size.width as usize * size.height as usize;
                if at < count {
                    return (map, at);
                }
                at -= count;
            }
            unreachable!("points lie in the maps that they were made for")
        };
        let mut parts = self.texels.iter().zip(estimates).peekable();
        while let Some(&(&(texel, _), _)) = parts.peek() {
            let (mut sum, mut visibility, mut error, mut bent) = (0.0f32, 0.0, 0.0, Vec3::ZERO);
            while let Some((&(_, area), estimate)) = parts.next_if(|((other, _), _)| *other == texel) {
                if !estimate.is_pending() && estimate.error.is_finite() {
                    sum += area;
                    visibility += area * estimate.visibility;
                    // Parts of a texel mostly err for one cause.
                    error += area * estimate.error;
                    bent += area * estimate.bent;
                }
            }
            let (map, at) = of(texel);
            let map = &mut maps[map];
            map.is_read[at] = true;
            if sum > 0.0 {
                map.visibility[at] = visibility / sum;
                map.error[at] = error / sum;
                map.bent[at] = bent / sum;
            }
        }
        Ok(maps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square from (0.25, 0.25) to (0.75, 0.75) of the map, in the plane y = 0.
    fn surface() -> Surface {
        let corner = |x: f32, y: f32| Vec2::new(0.25 + 0.5 * x, 0.25 + 0.5 * y);
        let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        Surface { map: 0, uvs: vec![[a, b, c], [a, c, d]] }
    }

    fn target(size: u32, supersample: u32) -> AtlasTarget {
        let surface = surface();
        let sizes = vec![MapSize { width: size, height: size }];
        let uvs = surface.uvs.clone();
        AtlasTarget::new(sizes, &[surface], supersample, |_, triangle, weights| {
            let uv: Vec2 = (0..3).map(|k| uvs[triangle][k] * weights[k]).sum();
            SurfacePoint::new(Vec3::new(uv.x, 0.0, uv.y), Vec3::Y)
        })
    }

    /// Visibility is the place in x.
    fn estimates(target: &AtlasTarget) -> Vec<Estimate> {
        let at =
            |point: &SurfacePoint| Estimate { visibility: point.position.x, error: 0.1, ..Estimate::PENDING };
        target.points().iter().map(at).collect()
    }

    #[test]
    fn each_texel_that_is_read_has_a_value_of_the_surface() {
        let target = target(16, 1);
        assert_eq!(target.points().len(), 10 * 10, "8 texels and one on either side");
        let map = &target.resolve(&estimates(&target)).unwrap()[0];
        assert_eq!(map.missing(), 0);
        for y in 0..16 {
            for x in 0..16 {
                let at = y * 16 + x;
                assert_eq!(map.is_read[at], (3..13).contains(&x) && (3..13).contains(&y));
                if map.is_read[at] {
                    let expected = ((x as f32 + 0.5) / 16.0).clamp(0.25, 0.75);
                    assert!((map.visibility[at] - expected).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn parts_of_a_texel_are_put_together() {
        let target = target(16, 3);
        let map = &target.resolve(&estimates(&target)).unwrap()[0];
        assert_eq!(map.is_read.iter().filter(|read| **read).count(), 100);
        // Nine parts each inside, one each about.
        assert_eq!(target.points().len(), 64 * 9 + 36);
        assert!((map.visibility[8 * 16 + 8] - 8.5 / 16.0).abs() < 1e-5);
        assert!((map.error[8 * 16 + 8] - 0.1).abs() < 1e-6);
        let mut ids: Vec<u32> = target.points().iter().map(|point| point.id).collect();
        ids.dedup();
        assert_eq!(ids.len(), target.points().len());
    }

    #[test]
    fn several_maps_and_points_without_an_answer() {
        let mut other = surface();
        other.map = 1;
        let sizes = vec![MapSize { width: 8, height: 8 }, MapSize { width: 12, height: 6 }];
        let target = AtlasTarget::new(sizes, &[other, surface()], 1, |surface, _, _| {
            SurfacePoint::new(Vec3::splat(surface as f32), if surface == 0 { Vec3::Y } else { Vec3::Z })
        });
        let mut estimates: Vec<Estimate> = target
            .points()
            .iter()
            .map(|point| Estimate { visibility: point.position.x, error: 0.0, ..Estimate::PENDING })
            .collect();
        estimates[0] = Estimate::PENDING;
        let maps = target.resolve(&estimates).unwrap();
        assert_eq!((maps[0].missing(), maps[1].missing()), (1, 0));
        assert!(maps[1].visibility.iter().all(|value| value.is_nan() || *value == 0.0));
        assert!(maps[0].visibility.iter().all(|value| value.is_nan() || *value == 1.0));
        assert!(target.resolve(&estimates[1..]).is_err());
    }
}
