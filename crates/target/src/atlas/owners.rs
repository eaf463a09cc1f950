//! Which triangle each texel of a map belongs to.

use super::coverage::{Touched, reached, touched};
use conray_core::Vec2;
use rayon::prelude::*;
use std::ops::Range;

/// Rows that one thread works on at a time.
const BAND: u32 = 32;
/// Stands for a texel that no triangle touches.
const NONE: u32 = u32::MAX;

/// The texels of some rows of a map, each with the triangle that covers most of it, or, where none covers any of it, the nearest whose taps read it.
pub(super) struct Owners {
    width: u32,
    rows: Range<u32>,
    tap: f32,
    /// Index of the triangle, row by row.
    owner: Vec<u32>,
    /// Area in texels that is covered more than once, at the least.
    pub(super) overlap: f64,
    /// For each band of rows the triangles that may touch it, ascending.
    bands: Vec<Vec<u32>>,
}

/// How well a triangle stands for a texel: by what it covers of it, else by how near it is.
fn rank(touched: &Touched) -> f32 {
    if touched.area > 0.0 { touched.area } else { -1.0 - touched.off }
}

impl Owners {
    /// Finds the owners of the texels in rows of a map of that width. Triangles are told in texels; see [`touched`] for `tap`.
    pub(super) fn new(triangles: &[[Vec2; 3]], width: u32, rows: Range<u32>, tap: f32) -> Self {
        let bands = bands(triangles, &rows, tap);
        let mut owner = vec![NONE; width as usize * rows.len()];
        let in_bands = owner.par_chunks_mut((width * BAND).max(1) as usize).zip(&bands).enumerate();
        let overlaps: Vec<f64> = in_bands
            .map(|(band, (owner, these))| {
                let rows = rows_of(band, &rows);
                let mut best = vec![f32::NEG_INFINITY; owner.len()];
                let mut covered = vec![0.0f32; owner.len()];
                for &index in these {
                    touched(triangles[index as usize], width, rows.clone(), tap, |touched| {
                        let [x, y] = touched.texel;
                        let at = ((y - rows.start) * width + x) as usize;
                        covered[at] += touched.area;
                        let rank = rank(&touched);
                        if rank > best[at] {
                            (best[at], owner[at]) = (rank, index);
                        }
                    });
                }
                covered.iter().map(|&covered| f64::from((covered - 1.0).max(0.0))).sum()
            })
            .collect();
        // In the order of the bands, so that the sum does not depend on threads.
        Self { width, rows, tap, owner, overlap: overlaps.iter().sum(), bands }
    }

    /// What becomes of the touched texels of each triangle that are its own, in bands of rows, row by row.
    pub(super) fn each<T: Send>(
        &self,
        triangles: &[[Vec2; 3]],
        make: impl Fn(u32, Touched) -> T + Sync,
    ) -> Vec<Vec<T>> {
        let of_band = |(band, these): (usize, &Vec<u32>)| {
            let rows = rows_of(band, &self.rows);
            let mut found: Vec<(u32, T)> = Vec::new();
            for &index in these {
                touched(triangles[index as usize], self.width, rows.clone(), self.tap, |touched| {
                    let [x, y] = touched.texel;
                    let at = (y - self.rows.start) * self.width + x;
                    if self.owner[at as usize] == index {
                        found.push((at, make(index, touched)));
                    }
                });
            }
            found.sort_by_key(|(at, _)| *at);
            found.into_iter().map(|(_, made)| made).collect()
        };
        self.bands.par_iter().enumerate().map(of_band).collect()
    }

    /// The triangle of a texel.
    #[cfg(test)]
    fn of(&self, [x, y]: [u32; 2]) -> Option<u32> {
        Some(self.owner[((y - self.rows.start) * self.width + x) as usize]).filter(|&owner| owner != NONE)
    }
}

/// How UVs lie in a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UvUse {
    /// Area of all triangles, in shares of the map.
    pub area: f64,
    /// Area that is covered more than once, at the least, in shares of the map.
    pub overlap: f64,
    /// The first triangle that leaves the map, or has a UV that is not finite.
    pub outside: Option<usize>,
}

/// UVs may leave the map by so much of it: rounding of exporters.
const MARGIN: f32 = 1e-4;

impl UvUse {
    /// Of these triangles, in shares of the map; overlaps are found in a raster of `side` x `side` texels.
    pub fn of(uvs: &[[Vec2; 3]], side: u32) -> Self {
        let inside = |uv: &Vec2| {
            let within = |x: f32| (-MARGIN..=1.0 + MARGIN).contains(&x);
            within(uv.x) && within(uv.y)
        };
        let outside = uvs.iter().position(|uvs| !uvs.iter().all(inside));
        let triangles: Vec<[Vec2; 3]> = uvs.iter().map(|uvs| uvs.map(|uv| uv * side as f32)).collect();
        let owners = Owners::new(&triangles, side, 0..side, 0.5);
        let area = |[a, b, c]: &[Vec2; 3]| 0.5 * f64::from((*b - *a).perp_dot(*c - *a).abs());
        let texels = f64::from(side) * f64::from(side);
        Self { area: uvs.iter().map(area).sum(), overlap: owners.overlap / texels, outside }
    }
}

fn rows_of(band: usize, within: &Range<u32>) -> Range<u32> {
    let start = within.start + band as u32 * BAND;
    start..(start + BAND).min(within.end)
}

fn bands(triangles: &[[Vec2; 3]], within: &Range<u32>, tap: f32) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); within.len().div_ceil(BAND as usize)];
    for (index, corners) in (0..).zip(triangles) {
        let [a, b, c] = corners.map(|corner| corner.y);
        let rows = reached([a.min(b).min(c), a.max(b).max(c)], within.clone(), tap);
        if rows.is_empty() || !(a + b + c).is_finite() {
            continue;
        }
        for band in (rows.start - within.start) / BAND..=(rows.end - 1 - within.start) / BAND {
            bands[band as usize].push(index);
        }
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(left: f32, top: f32, side: f32) -> [[Vec2; 3]; 2] {
        let corner = |x: f32, y: f32| Vec2::new(left + x * side, top + y * side);
        [
            [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)],
            [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
        ]
    }

    #[test]
    fn texels_go_to_the_triangle_that_covers_most_of_them() {
        let [a, b] = square(2.0, 30.0, 10.0);
        let owners = Owners::new(&[a, b], 64, 0..64, 1.0);
        assert_eq!((owners.of([10, 31]), owners.of([3, 38])), (Some(0), Some(1)));
        // Read by taps at the rim, of two texels' distance no more.
        assert_eq!(owners.of([1, 35]), Some(1));
        assert_eq!((owners.of([0, 35]), owners.of([2, 28])), (None, None));
        assert!(owners.overlap < 1e-3);
        let count: usize = owners.each(&[a, b], |_, touched| touched.texel).iter().map(Vec::len).sum();
        assert_eq!(count, 12 * 12, "ten texels and one on either side");
    }

    #[test]
    fn each_texel_is_told_once_and_in_order_whatever_the_threads() {
        let triangles: Vec<[Vec2; 3]> =
            (0..40).flat_map(|k| square((k % 8) as f32 * 9.3, (k / 8) as f32 * 23.1, 8.0)).collect();
        let told = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let texels = |_, touched: Touched| touched.texel;
            pool.install(|| Owners::new(&triangles, 80, 0..130, 1.0).each(&triangles, texels)).concat()
        };
        let found = told(1);
        assert!(found.is_sorted_by(|a, b| (a[1], a[0]) < (b[1], b[0])));
        assert_eq!(found, told(3));
    }

    #[test]
    fn rows_by_themselves_have_the_owners_that_they_have_in_the_map() {
        let triangles: Vec<[Vec2; 3]> =
            (0..6).flat_map(|k| square(3.0 + k as f32 * 7.1, 20.3, 50.0)).collect();
        let whole = Owners::new(&triangles, 64, 0..100, 1.0);
        let rows = Owners::new(&triangles, 64, 37..90, 1.0);
        let all = (37..90).flat_map(|y| (0..64).map(move |x| [x, y]));
        assert!(all.clone().all(|texel| rows.of(texel) == whole.of(texel)));
        let told = rows.each(&triangles, |_, touched| touched.texel).concat();
        assert_eq!(told, all.filter(|&texel| whole.of(texel).is_some()).collect::<Vec<_>>());
    }

    #[test]
    fn uvs_are_judged() {
        let share = |[a, b, c]: [Vec2; 3]| [a, b, c].map(|corner| corner / 100.0);
        let one: Vec<[Vec2; 3]> = square(10.0, 10.0, 50.0).map(share).to_vec();
        let found = UvUse::of(&one, 128);
        assert!((found.area - 0.25).abs() < 1e-6 && found.overlap < 1e-5 && found.outside.is_none());
        let mut both = one.clone();
        both.extend(square(35.0, 35.0, 50.0).map(share));
        let found = UvUse::of(&both, 128);
        assert!((found.area - 0.5).abs() < 1e-6 && (found.overlap - 0.0625).abs() < 1e-3, "{found:?}");
        let beyond: Vec<[Vec2; 3]> = [one[0], one[1].map(|uv| uv + Vec2::X), [Vec2::NAN; 3]].to_vec();
        assert_eq!(UvUse::of(&beyond, 16).outside, Some(1));
        assert_eq!(UvUse::of(&beyond[2..], 16).outside, Some(0));
    }

    #[test]
    fn what_is_covered_twice_is_measured() {
        let mut triangles = square(2.0, 2.0, 20.0).to_vec();
        triangles.extend(square(12.0, 12.0, 20.0));
        let owners = Owners::new(&triangles, 40, 0..40, 1.0);
        assert!((owners.overlap - 100.0).abs() < 1e-2, "{}", owners.overlap);
    }
}
