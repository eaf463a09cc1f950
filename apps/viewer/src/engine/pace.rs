//! How many pixels a first picture may have to be there at once.

/// What a first picture may take. With the end of what it interrupts, and the frame that shows it, that makes about a tenth of a second on two cores.
const FIRST_PICTURE_SECONDS: f64 = 0.03;
/// Sides of the wanted size are divided by at most this.
const MOST: u32 = 12;
/// Before anything was measured.
const UNKNOWN: u32 = 6;

/// Foresees the time of first pictures from those before.
#[derive(Clone, Debug, Default)]
pub(super) struct Pace {
    seconds_per_pixel: Option<f64>,
}

impl Pace {
    /// By what the sides of a picture of so many pixels are divided at first: 1 is the whole size.
    pub(super) fn divisor(&self, pixels: u64) -> u32 {
        let Some(each) = self.seconds_per_pixel else { return UNKNOWN };
        let seconds = pixels as f64 * each;
        // Time goes with the pixels, which go with the square of the divisor.
        ((seconds / FIRST_PICTURE_SECONDS).sqrt().ceil() as u32).clamp(1, MOST)
    }

    /// A first picture of so many pixels took so long. What is slower than foreseen counts at once, what is faster by and by.
    pub(super) fn note(&mut self, pixels: u64, seconds: f64) {
        let now = seconds / pixels.max(1) as f64;
        let kept = self.seconds_per_pixel.unwrap_or(now);
        self.seconds_per_pixel = Some(if now > kept { now } else { 0.6 * kept + 0.4 * now });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_machines_get_fewer_pixels_and_fast_ones_all() {
        let mut pace = Pace::default();
        assert_eq!(pace.divisor(512 * 512), UNKNOWN);
        pace.note(1 << 14, FIRST_PICTURE_SECONDS);
        assert_eq!(pace.divisor(1 << 14), 1);
        assert_eq!(pace.divisor(1 << 18), 4, "sixteen times the pixels");
        pace.note(1 << 14, 10.0);
        assert_eq!(pace.divisor(1 << 18), MOST);
        for _ in 0..40 {
            pace.note(1 << 14, 1e-4);
        }
        assert_eq!(pace.divisor(1 << 18), 1);
    }
}
