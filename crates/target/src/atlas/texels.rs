//! Maps as targets: the surface points behind their texels.

use super::{
    coverage::Touched,
    map::{AtlasMap, Texel},
    owners::Owners,
    portion::{Part, Portion, portions},
};
use crate::{Target, TargetError, target::check_count};
use conray_core::{Estimate, Layout, SurfacePoint, Vec2, Vec3};
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

/// Maps and what reads them.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// The size of each map.
    pub sizes: Vec<MapSize>,
    /// What reads them.
    pub surfaces: Vec<Surface>,
    /// Each texel is divided into so many parts in both directions, each asked about by itself; at least 1.
    pub supersample: u32,
}

/// The texels in a portion of maps, as surface points: one for each texel that a surface reads, or one for each part of it that is covered where texels
/// are divided.
///
/// Points are listed row by row of the portion's image, and are its pixels.
#[derive(Clone, Debug)]
pub struct AtlasTarget {
    portion: Portion,
    /// Area in texels that is covered more than once, of each part.
    overlaps: Vec<f64>,
    points: Vec<SurfacePoint>,
    /// For each point its texel, and how much it counts for there.
    texels: Vec<(TexelOf, f32)>,
    /// For each point the surface that it lies on.
    surfaces: Vec<u32>,
    /// For each point the triangle of that, and the weights of its second and third corner.
    places: Vec<(u32, [f32; 2])>,
    unusable: usize,
    /// Several points may stand for parts of one texel.
    is_divided: bool,
}

/// A texel of a map: the map, and its place there, row by row.
type TexelOf = (u32, u32);

/// A part of a texel, and the point that stands for it.
struct Sample {
    texel: u32,
    surface: u32,
    place: (u32, [f32; 2]),
    area: f32,
    off: f32,
    point: SurfacePoint,
}

impl Atlas {
    /// Divides the maps into portions of at most `most` places, or of one row where that is more.
    ///
    /// # Errors
    /// [`TargetError::TooManyTexels`] where there are more places than ids.
    pub fn portions(&self, most: u64) -> Result<Vec<Portion>, TargetError> {
        portions(&self.sizes, self.supersample, most).ok_or(TargetError::TooManyTexels)
    }

    /// The maps, of which nothing is known yet.
    pub fn maps(&self) -> Vec<AtlasMap> {
        self.sizes.iter().map(|size| AtlasMap::empty(size.width, size.height)).collect()
    }

    /// About how many texels of a portion are read: those of the triangles whose middles lie in it.
    pub fn reads(&self, portion: &Portion) -> f64 {
        let of_part = |Part { map, rows }: &Part| {
            let MapSize { width, height } = self.sizes[*map];
            let rows = rows.start as f32..rows.end as f32;
            let surfaces = self.surfaces.iter().filter(|surface| surface.map == *map);
            let area = |[a, b, c]: &[Vec2; 3]| {
                let is_in = rows.contains(&((a.y + b.y + c.y) / 3.0 * height as f32));
                if is_in { 0.5 * f64::from((*b - *a).perp_dot(*c - *a).abs()) } else { 0.0 }
            };
            let shares: f64 = surfaces.flat_map(|surface| &surface.uvs).map(area).sum();
            let texels = f64::from(width) * f64::from(height);
            (shares * texels).min(f64::from(width) * f64::from(rows.end - rows.start))
        };
        portion.parts.iter().map(of_part).sum()
    }

    /// Finds the texels of a portion that surfaces read, in parallel; the result does not depend on threads.
    ///
    /// `point(surface, triangle, weights)` is the surface point at those weights of a triangle's corners; `id` is set here, and `footprint`
    /// from what it tells is that of a texel. A point that is not
    /// valid ([`SurfacePoint::is_valid`]) is left out, and counted ([`AtlasTarget::unusable`]).
    pub fn texels(
        &self,
        portion: &Portion,
        point: impl Fn(usize, usize, [f32; 3]) -> SurfacePoint + Sync,
    ) -> AtlasTarget {
        let mut target = AtlasTarget {
            portion: portion.clone(),
            overlaps: Vec::new(),
            points: Vec::new(),
            texels: Vec::new(),
            surfaces: Vec::new(),
            places: Vec::new(),
            unusable: 0,
            is_divided: self.supersample > 1,
        };
        let mut top = 0;
        for part in &portion.parts {
            self.add(&mut target, part, top, &point);
            top += part.rows.len() as u32;
        }
        target
    }

    /// Adds the points of a part that begins `top` rows down in the portion.
    fn add(
        &self,
        target: &mut AtlasTarget,
        Part { map, rows }: &Part,
        top: u32,
        point: &(impl Fn(usize, usize, [f32; 3]) -> SurfacePoint + Sync),
    ) {
        let (fine, MapSize { width, height }) = (self.supersample, self.sizes[*map]);
        let scale = Vec2::new((width * fine) as f32, (height * fine) as f32);
        let mut triangles = Vec::new();
        let mut whose = Vec::new();
        for (s, surface) in self.surfaces.iter().enumerate().filter(|(_, surface)| surface.map == *map) {
            triangles.extend(surface.uvs.iter().map(|uvs| uvs.map(|uv| uv * scale)));
            whose.extend((0..surface.uvs.len()).map(|triangle| (s, triangle)));
        }
        let owners = Owners::new(&triangles, width * fine, rows.start * fine..rows.end * fine, fine as f32);
        target.overlaps.push(owners.overlap / f64::from(fine * fine));
        let Portion { size, first, .. } = &target.portion;
        let sample = |index: u32, touched: Touched| {
            let (surface, triangle) = whose[index as usize];
            let [x, y] = touched.texel;
            let point = point(surface, triangle, touched.weights);
            let id = first + (y - rows.start * fine + top * fine) * size[0] + x;
            let point = SurfacePoint { id, footprint: point.footprint / fine as f32, ..point };
            let texel = y / fine * width + x / fine;
            let place = (triangle as u32, [touched.weights[1], touched.weights[2]]);
            Sample { texel, surface: surface as u32, place, area: touched.area, off: touched.off, point }
        };
        let mut samples: Vec<Sample> =
            owners.each(&triangles, sample).into_par_iter().flatten_iter().collect();
        if fine > 1 {
            samples.par_sort_by_key(|sample| sample.texel);
            samples = chosen(samples);
        }
        let all = samples.len();
        samples.retain(|sample| sample.point.is_valid());
        target.unusable += all - samples.len();
        let samples = samples.par_iter();
        target.points.par_extend(samples.clone().map(|sample| sample.point));
        target.surfaces.par_extend(samples.clone().map(|sample| sample.surface));
        target.places.par_extend(samples.clone().map(|sample| sample.place));
        let counts = |area: f32| if area > 0.0 { area } else { 1.0 };
        target.texels.par_extend(samples.map(|sample| ((*map as u32, sample.texel), counts(sample.area))));
    }
}

impl AtlasTarget {
    /// Area in texels that surfaces cover more than once, for each part of the portion: what is baked there is right for one of them only.
    pub fn overlaps(&self) -> &[f64] {
        &self.overlaps
    }

    /// Points that were left out because they were not valid.
    pub fn unusable(&self) -> usize {
        self.unusable
    }

    /// The texel that each point stands for or is a part of: the map, and its place there, row by row.
    pub fn texels(&self) -> impl Iterator<Item = (u32, u32)> {
        self.texels.iter().map(|(texel, _)| *texel)
    }

    /// The surface that each point lies on.
    pub fn surfaces(&self) -> &[u32] {
        &self.surfaces
    }

    /// The triangle of its surface that each point lies on, and the weights of the triangle's second and third corner there.
    pub fn places(&self) -> &[(u32, [f32; 2])] {
        &self.places
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
    type Output = Vec<Texel>;

    fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    fn layout(&self) -> Layout {
        let [width, height] = self.portion.size;
        Layout::Image { first: self.portion.first, width, height }
    }

    /// The texels that surfaces read, for [`AtlasMap::put`]; those of pending estimates have no value.
    fn resolve(&self, estimates: &[Estimate]) -> Result<Vec<Texel>, TargetError> {
        check_count(&self.points, estimates)?;
        if !self.is_divided {
            let texel = |(&((map, at), _), estimate): (&(TexelOf, f32), &Estimate)| {
                let Estimate { visibility, error, bent, .. } = *estimate;
                let is_known = !estimate.is_pending() && error.is_finite();
                let texel = Texel { map, at, ..Texel::UNKNOWN };
                if is_known { Texel { visibility, error, bent, ..texel } } else { texel }
            };
            return Ok(self.texels.par_iter().zip(estimates).map(texel).collect());
        }
        let mut found = Vec::new();
        let mut parts = self.texels.iter().zip(estimates).peekable();
        while let Some(&(&((map, at), _), _)) = parts.peek() {
            let (mut sum, mut visibility, mut error, mut bent) = (0.0f32, 0.0, 0.0, Vec3::ZERO);
            while let Some((&(_, area), estimate)) = parts.next_if(|((other, _), _)| *other == (map, at)) {
                if !estimate.is_pending() && estimate.error.is_finite() {
                    sum += area;
                    visibility += area * estimate.visibility;
                    // Parts of a texel mostly err for one cause.
                    error += area * estimate.error;
                    bent += area * estimate.bent;
                }
            }
            let mut texel = Texel { map, at, ..Texel::UNKNOWN };
            if sum > 0.0 {
                texel = Texel { visibility: visibility / sum, error: error / sum, bent: bent / sum, ..texel };
            }
            found.push(texel);
        }
        Ok(found)
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

    fn atlas(size: u32, supersample: u32) -> Atlas {
        Atlas { sizes: vec![MapSize { width: size, height: size }], surfaces: vec![surface()], supersample }
    }

    /// The targets of its portions; the place of a point is that in the map.
    fn targets(atlas: &Atlas, most: u64) -> Vec<AtlasTarget> {
        let uvs = &atlas.surfaces[0].uvs;
        let target = |portion: &Portion| {
            atlas.texels(portion, |_, triangle, weights| {
                let uv: Vec2 = (0..3).map(|k| uvs[triangle][k] * weights[k]).sum();
                SurfacePoint::new(Vec3::new(uv.x, 0.0, uv.y), Vec3::Y)
            })
        };
        atlas.portions(most).unwrap().iter().map(target).collect()
    }

    /// The maps when each point sees its place in x.
    fn resolved(atlas: &Atlas, targets: &[AtlasTarget]) -> Vec<AtlasMap> {
        let mut maps = atlas.maps();
        for target in targets {
            let texels = target.resolve(&estimates(target)).unwrap();
            texels.iter().for_each(|texel| maps[texel.map as usize].put(texel));
        }
        maps
    }

    /// Visibility is the place in x.
    fn estimates(target: &AtlasTarget) -> Vec<Estimate> {
        let at =
            |point: &SurfacePoint| Estimate { visibility: point.position.x, error: 0.1, ..Estimate::PENDING };
        target.points().iter().map(at).collect()
    }

    #[test]
    fn each_texel_that_is_read_has_a_value_of_the_surface() {
        let atlas = atlas(16, 1);
        for (most, portions) in [(1 << 20, 1), (64, 4)] {
            let targets = targets(&atlas, most);
            assert_eq!(targets.len(), portions);
            let points: usize = targets.iter().map(|target| target.points().len()).sum();
            assert_eq!(points, 10 * 10, "8 texels and one on either side");
            let map = &resolved(&atlas, &targets)[0];
            assert_eq!(map.missing(), 0);
            for (at, x, y) in (0..16 * 16).map(|at| (at, at % 16, at / 16)) {
                assert_eq!(map.is_read[at], (3..13).contains(&x) && (3..13).contains(&y));
                if map.is_read[at] {
                    let expected = ((x as f32 + 0.5) / 16.0).clamp(0.25, 0.75);
                    assert!((map.visibility[at] - expected).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn points_are_the_pixels_of_their_portions() {
        for supersample in [1, 2] {
            let mut known = std::collections::HashSet::new();
            for target in targets(&atlas(16, supersample), 64 * u64::from(supersample)) {
                let Layout::Image { first, width, height } = target.layout() else { panic!("an image") };
                for point in target.points() {
                    assert!(known.insert(point.id), "twice");
                    let [x, y] = [(point.id - first) % width, (point.id - first) / width];
                    assert!(y < height);
                    let place = (x as f32 + 0.5) / (16 * supersample) as f32;
                    assert!((point.position.x - place).abs() < 1.5 / 16.0, "{x} {}", point.position);
                }
            }
        }
    }

    #[test]
    fn parts_of_a_texel_are_put_together() {
        let atlas = atlas(16, 3);
        let targets = targets(&atlas, 1 << 20);
        let map = &resolved(&atlas, &targets)[0];
        assert_eq!(map.is_read.iter().filter(|read| **read).count(), 100);
        // Nine parts each inside, one each about.
        assert_eq!(targets[0].points().len(), 64 * 9 + 36);
        assert!((map.visibility[8 * 16 + 8] - 8.5 / 16.0).abs() < 1e-5);
        assert!((map.error[8 * 16 + 8] - 0.1).abs() < 1e-6);
    }

    #[test]
    fn several_maps_and_points_without_an_answer() {
        let mut other = surface();
        other.map = 1;
        let sizes = vec![MapSize { width: 8, height: 8 }, MapSize { width: 12, height: 6 }];
        let atlas = Atlas { sizes, surfaces: vec![other, surface()], supersample: 1 };
        let portions = atlas.portions(1 << 20).unwrap();
        assert_eq!(portions.len(), 1);
        let target = atlas.texels(&portions[0], |surface, _, _| {
            SurfacePoint::new(Vec3::splat(surface as f32), if surface == 0 { Vec3::Y } else { Vec3::Z })
        });
        let mut found = estimates(&target);
        found[0] = Estimate::PENDING;
        let mut maps = atlas.maps();
        target.resolve(&found).unwrap().iter().for_each(|texel| maps[texel.map as usize].put(texel));
        assert_eq!((maps[0].missing(), maps[1].missing()), (1, 0));
        assert!(maps[1].visibility.iter().all(|value| value.is_nan() || *value == 0.0));
        assert!(maps[0].visibility.iter().all(|value| value.is_nan() || *value == 1.0));
        assert!(target.resolve(&found[1..]).is_err());
        // Half of the first map in both directions, and of the second.
        assert!((atlas.reads(&portions[0]) - (16.0 + 18.0)).abs() < 1e-3);
    }
}
