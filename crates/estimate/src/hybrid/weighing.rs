//! Weighing on a device: what is handed to it once, what at every weighing, and what it tells.

use super::{
    Hybrid, HybridDevice, shown,
    tallies::{Rays, Tally},
    weigh::Known,
};
use crate::BackendError;
use conray_bvh::Level;
use std::borrow::Cow;
use web_time::Instant;

/// What is known of places without a ray: rows of an image, or points of no image laid out as one.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// Places in a row that may have points.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Places in a row, a multiple of 16; of each there is a value below.
    pub stride: usize,
    /// Position in a unit of length of the method's own, then shading normal.
    pub place: [&'a [f32]; 6],
    /// One over the footprint in that unit; 0 where there is no point.
    pub sharpness: &'a [f32],
    /// Points that were asked about, those without a place among them.
    pub points: usize,
}

/// Weighs what rays found at some places with what their neighbours found; made by [`HybridDevice::weigher`].
pub trait PlaceWeigher: Send + Sync {
    /// What is known of each place. `tallies` has one of each, `rays` tells how they err.
    ///
    /// # Errors
    /// [`BackendError::Device`] of a device that fails.
    fn weigh(&self, tallies: &[Tally], rays: &Rays) -> Result<Known, BackendError>;
}

/// Which rays are weighed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weighed {
    /// Those of an interrupted round too.
    Shown,
    /// Those alone that choosing may see.
    WholeRounds,
}

/// A device that weighs, where one does.
pub(super) type OnDevice<'a> = Option<Box<dyn PlaceWeigher + 'a>>;

impl Hybrid {
    /// What a device weighs by; nothing where that is the CPU's, or where the device fails.
    pub(super) fn weigher_on<'a>(&mut self, device: Option<&'a dyn HybridDevice>) -> OnDevice<'a> {
        let made = device?.weigher(&self.constants, &self.places());
        made.unwrap_or_else(|e| {
            self.failure = Some(e);
            None
        })
    }

    fn places(&self) -> Places<'_> {
        let pixels = &self.pixels;
        Places {
            width: pixels.width,
            height: pixels.height,
            stride: pixels.stride,
            place: pixels.place.each_ref().map(|column| &column[..]),
            sharpness: &pixels.sharpness,
            points: pixels.place_of.len(),
        }
    }

    /// Weighs all that is shown, or what whole rounds found alone: on the device, where there is one that does not fail.
    pub(super) fn weigh(&mut self, on_device: &OnDevice<'_>, level: Level, what: Weighed) {
        let start = Instant::now();
        let tallies = match what {
            Weighed::Shown => shown(&self.tallies, &self.unfinished),
            Weighed::WholeRounds => Cow::Borrowed(&self.tallies[..]),
        };
        self.known_of_unfinished = what == Weighed::Shown && !self.unfinished.is_empty();
        let told = on_device.as_ref().map(|device| device.weigh(&tallies, &self.rays));
        self.known_on_device = matches!(told, Some(Ok(_)));
        match told {
            Some(Ok(known)) => self.known = known,
            other => {
                self.failure = other.and_then(Result::err).or(self.failure.take());
                let Self { constants, pixels, rays, known, weigher, .. } = self;
                weigher.weigh(level, constants, pixels, &tallies, rays, known);
            }
        }
        self.costs.weighing_seconds = Some(start.elapsed().as_secs_f64());
    }
}
