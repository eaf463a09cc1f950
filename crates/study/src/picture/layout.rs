//! Cutting pictures out and putting them side by side.

use super::Picture;

impl Picture {
    /// The square of `side` pixels around `centre` (column, row), each pixel drawn as `factor` x `factor` pixels.
    ///
    /// At a border the square is moved inside; where the picture is smaller than the square, all of it is taken.
    pub fn crop_enlarged(&self, centre: [u32; 2], side: u32, factor: u32) -> Self {
        let (left, width) = span(centre[0], side, self.width);
        let (top, height) = span(centre[1], side, self.height);
        let (wide, high) = (width * factor, height * factor);
        let pixels = (0..high).flat_map(|y| (0..wide).map(move |x| (left + x / factor, top + y / factor)));
        Self { width: wide, height: high, rgb: pixels.flat_map(|(x, y)| self.pixel(x, y)).collect() }
    }

    /// Pictures side by side with `gap` white pixels between them, their tops aligned.
    pub fn beside(pictures: &[Self], gap: u32) -> Self {
        let gaps = gap * u32::try_from(pictures.len().saturating_sub(1)).unwrap_or(0);
        let width = pictures.iter().map(|p| p.width).sum::<u32>() + gaps;
        let height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
        let mut all = Self::plain(width, height, [255; 3]);
        let mut left = 0;
        for picture in pictures {
            for y in 0..picture.height {
                for x in 0..picture.width {
                    let at = 3 * (y as usize * width as usize + (left + x) as usize);
                    all.rgb[at..at + 3].copy_from_slice(&picture.pixel(x, y));
                }
            }
            left += picture.width + gap;
        }
        all
    }

    /// White outside the picture.
    fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        let at = 3 * (y as usize * self.width as usize + x as usize);
        match self.rgb.get(at..at + 3) {
            Some(&[r, g, b]) if x < self.width => [r, g, b],
            _ => [255; 3],
        }
    }
}

/// First pixel and length of a stretch of `side` pixels around `centre`, inside `[0, size)`.
fn span(centre: u32, side: u32, size: u32) -> (u32, u32) {
    let length = side.min(size);
    (centre.saturating_sub(length / 2).min(size - length), length)
}
