//! Maps of values, one a texel.

use super::grow::{Known, grow};
use conray_core::{Vec2, Vec3};

/// What a map holds for each texel, rows from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtlasMap {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Visibility, 1 is open; NaN where no surface reads the texel.
    pub visibility: Vec<f32>,
    /// Its expected error.
    pub error: Vec<f32>,
    /// Mean open direction in world space, of length at most 1.
    pub bent: Vec<Vec3>,
    /// True where a surface reads the texel, by itself or through a bilinear tap.
    pub is_read: Vec<bool>,
}

/// What became of a texel that a surface reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// Which map.
    pub map: u32,
    /// Its place in it, row by row.
    pub at: u32,
    /// Visibility, 1 is open; NaN where nothing is known.
    pub visibility: f32,
    /// Its expected error.
    pub error: f32,
    /// Mean open direction in world space, of length at most 1.
    pub bent: Vec3,
}

impl Texel {
    /// Nothing about the first texel of the first map.
    pub const UNKNOWN: Self =
        Self { map: 0, at: 0, visibility: f32::NAN, error: f32::INFINITY, bent: Vec3::ZERO };
}

impl AtlasMap {
    /// A texel as it is, told to be of the map of that number.
    pub fn texel(&self, map: u32, at: u32) -> Texel {
        let k = at as usize;
        Texel { map, at, visibility: self.visibility[k], error: self.error[k], bent: self.bent[k] }
    }

    /// Takes over a texel that is one of this map's.
    pub fn put(&mut self, texel: &Texel) {
        let at = texel.at as usize;
        self.is_read[at] = true;
        (self.visibility[at], self.error[at], self.bent[at]) = (texel.visibility, texel.error, texel.bent);
    }

    /// A map that nothing was found for.
    pub(super) fn empty(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        Self {
            width,
            height,
            visibility: vec![f32::NAN; count],
            error: vec![f32::INFINITY; count],
            bent: vec![Vec3::ZERO; count],
            is_read: vec![false; count],
        }
    }

    /// Visibility at a place, between four texels, as a renderer reads it; beyond the map that of its rim.
    pub fn read(&self, uv: Vec2) -> f32 {
        self.taps(uv).map(|(at, weight)| weight * self.visibility[at]).sum()
    }

    /// The texels that a renderer reads at a place, and how much each counts; those that count for nothing are left out.
    pub(super) fn taps(&self, uv: Vec2) -> impl Iterator<Item = (usize, f32)> {
        let place = uv * Vec2::new(self.width as f32, self.height as f32) - 0.5;
        let (first, share) = (place.floor(), place - place.floor());
        let [width, height] = [self.width, self.height].map(|side| side as f32);
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].into_iter().filter_map(move |(dx, dy)| {
            let along = |share: f32, other: f32| if other > 0.0 { share } else { 1.0 - share };
            let weight = along(share.x, dx) * along(share.y, dy);
            let x = (first.x + dx).clamp(0.0, width - 1.0);
            let y = (first.y + dy).clamp(0.0, height - 1.0);
            (weight > 0.0).then_some((y as usize * width as usize + x as usize, weight))
        })
    }

    /// As layers of an image: visibility, its expected error, bent directions, and `A`, which is 1 where a surface reads.
    pub fn layers(&self) -> crate::Layers {
        crate::Layers::of_map(self)
    }

    /// Texels that a surface reads and that have no value.
    pub fn missing(&self) -> usize {
        self.is_read.iter().zip(&self.visibility).filter(|(read, value)| **read && value.is_nan()).count()
    }

    /// Gives values to texels that surfaces read and that have none, from their own island, however far.
    pub(super) fn fill(&mut self) {
        self.grow(None, true);
    }

    /// Gives values to texels that have none, from those about them: first to those that surfaces read, from their own island however far, then
    /// about islands, by so many texels or until they meet, and last to islands that have no value at all. A map without any
    /// value becomes open.
    pub fn extend(&mut self, padding: Option<u32>) {
        if self.visibility.iter().all(|value| value.is_nan()) {
            self.visibility.fill(1.0);
            self.error.fill(0.0);
        }
        self.grow(None, true);
        self.grow(padding, false);
        if self.missing() > 0 {
            self.grow(None, false);
        }
    }

    fn grow(&mut self, padding: Option<u32>, read_only: bool) {
        let Self { width, visibility, error, bent, is_read, .. } = self;
        let mut has: Vec<bool> = visibility.iter().map(|value| !value.is_nan()).collect();
        let known = &mut Known { width: *width as usize, has: &mut has };
        grow(
            known,
            padding,
            |at| !read_only || is_read[at],
            |at, from| {
                let count = from.len() as f32;
                visibility[at] = from.iter().map(|&near| visibility[near]).sum::<f32>() / count;
                error[at] = from.iter().map(|&near| error[near]).sum::<f32>() / count;
                bent[at] = from.iter().map(|&near| bent[near]).sum::<Vec3>() / count;
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row; `.` is not read, `?` is read and has no value, digits are tenths.
    fn map(row: &str) -> AtlasMap {
        let mut map = AtlasMap::empty(row.len() as u32, 1);
        for (at, c) in row.chars().enumerate() {
            map.is_read[at] = c != '.';
            if let Some(tenths) = c.to_digit(10) {
                (map.visibility[at], map.error[at]) = (tenths as f32 / 10.0, 0.01);
            }
        }
        map
    }

    fn row(map: &AtlasMap) -> String {
        let one =
            |value: &f32| if value.is_nan() { '.' } else { char::from(b'0' + (value * 10.0).round() as u8) };
        map.visibility.iter().map(one).collect()
    }

    #[test]
    fn places_between_texels_are_read_between_their_values() {
        let map = map("246");
        let read = |x: f32| map.read(Vec2::new(x / 3.0, 0.5));
        for (x, expected) in
            [(0.5, 0.2), (1.0, 0.3), (1.75, 0.45), (0.1, 0.2), (2.9, 0.6), (-7.0, 0.2), (9.0, 0.6)]
        {
            assert!((read(x) - expected).abs() < 1e-5, "{} at {x}", read(x));
        }
    }

    #[test]
    fn missing_texels_take_the_values_of_their_own_island() {
        let mut found = map("9..2???..");
        assert_eq!(found.missing(), 3);
        found.extend(Some(0));
        assert_eq!(row(&found), "9..2222..");
        let mut found = map("9..2???..");
        found.extend(None);
        // The texels between 9 and 2 go to the nearer.
        assert_eq!(row(&found), "992222222");
        assert_eq!(found.missing(), 0);
    }

    #[test]
    fn islands_without_a_value_take_what_is_nearest_whatever_the_padding() {
        let mut found = map("9...??");
        found.extend(Some(1));
        assert_eq!((found.missing(), &row(&found)[..2], &row(&found)[4..]), (0, "99", "99"));
        let mut found = map("..??.");
        found.extend(Some(1));
        assert_eq!(found.visibility, [1.0; 5]);
    }
}
