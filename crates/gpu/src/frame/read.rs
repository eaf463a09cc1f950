//! What pictures hold, for those who want more than to show them.

use super::Frames;
use crate::{GpuError, weighing::GpuPlace};
use conray_core::Vec3;

impl Frames<'_> {
    /// The picture, row by row: visibility as grey of eight bits a channel, the first of them lowest; 0 where nothing is seen.
    ///
    /// # Errors
    /// A device that fails.
    pub fn picture(&self) -> Result<Vec<u32>, GpuError> {
        pollster::block_on(self.picture_later())
    }

    /// The same as a future.
    ///
    /// # Errors
    /// A device that fails.
    pub async fn picture_later(&self) -> Result<Vec<u32>, GpuError> {
        let [width, height, _] = self.size;
        self.backend.gpu().read_later(&self.picture, (width * height) as usize).await
    }

    /// Visibility and expected error of each pixel, row by row; none where nothing is seen.
    ///
    /// # Errors
    /// A device that fails.
    pub fn known(&self) -> Result<Vec<Option<[f32; 2]>>, GpuError> {
        pollster::block_on(self.known_later())
    }

    /// The same as a future.
    ///
    /// # Errors
    /// A device that fails.
    pub async fn known_later(&self) -> Result<Vec<Option<[f32; 2]>>, GpuError> {
        let known: Vec<[f32; 4]> =
            self.backend.gpu().read_later(&self.weigher.buffers.known, self.places()).await?;
        let found = |at: usize, _: &GpuPlace| [known[at][0], known[at][1].sqrt()];
        Ok(self.of_pixels(&self.read_places().await?, found))
    }

    /// What is seen of each pixel, row by row: position and shading normal; none where that is nothing. `eye` is where the camera stood.
    ///
    /// # Errors
    /// A device that fails.
    pub fn seen(&self, eye: Vec3) -> Result<Vec<Option<[Vec3; 2]>>, GpuError> {
        pollster::block_on(self.seen_later(eye))
    }

    /// The same as a future.
    ///
    /// # Errors
    /// A device that fails.
    pub async fn seen_later(&self, eye: Vec3) -> Result<Vec<Option<[Vec3; 2]>>, GpuError> {
        let seen = |_: usize, place: &GpuPlace| [eye + self.unit * place.position, place.normal];
        Ok(self.of_pixels(&self.read_places().await?, seen))
    }

    fn places(&self) -> usize {
        let [_, height, stride] = self.size;
        (stride * height) as usize
    }

    async fn read_places(&self) -> Result<Vec<GpuPlace>, GpuError> {
        self.backend.gpu().read_later(&self.weigher.buffers.places, self.places()).await
    }

    fn of_pixels<T>(&self, places: &[GpuPlace], of: impl Fn(usize, &GpuPlace) -> T) -> Vec<Option<T>> {
        let [width, height, stride] = self.size;
        let pixel = |k: u32| {
            let at = (k / width * stride + k % width) as usize;
            (places[at].sharpness > 0.0).then(|| of(at, &places[at]))
        };
        (0..width * height).map(pixel).collect()
    }
}
