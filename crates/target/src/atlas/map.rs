//! Maps of values, one a texel.

use super::grow::{Known, grow};
use conray_core::Vec3;

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

impl AtlasMap {
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

    /// Texels that a surface reads and that have no value.
    pub fn missing(&self) -> usize {
        self.is_read.iter().zip(&self.visibility).filter(|(read, value)| **read && value.is_nan()).count()
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
