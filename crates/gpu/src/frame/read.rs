//! What pictures hold, for those who want more than to show them.

use super::{Frames, passes::UNIT};
use crate::{
    GpuError,
    weighing::{GpuPlace, GpuPlaceTally},
};
use conray_core::Vec3;

/// A pixel that sees something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePixel {
    /// Visibility in [0, 1].
    pub visibility: f32,
    /// Its expected error.
    pub error: f32,
    /// Rays traced from it.
    pub rays: u32,
    /// Where what it sees is, in world space.
    pub position: Vec3,
    /// Unit shading normal there.
    pub normal: Vec3,
}

impl Frames {
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

    /// All that is known of each pixel, row by row; none where nothing is seen.
    ///
    /// # Errors
    /// A device that fails.
    pub fn pixels(&self) -> Result<Vec<Option<FramePixel>>, GpuError> {
        pollster::block_on(self.pixels_later())
    }

    /// The same as a future.
    ///
    /// # Errors
    /// A device that fails.
    pub async fn pixels_later(&self) -> Result<Vec<Option<FramePixel>>, GpuError> {
        let ([width, height, stride], buffers) = (self.size, &self.weighing.buffers);
        let (gpu, count) = (self.backend.gpu(), (stride * height) as usize);
        let places: Vec<GpuPlace> = gpu.read_later(&buffers.places, count).await?;
        let tallies: Vec<GpuPlaceTally> = gpu.read_later(&buffers.tallies, count).await?;
        let known: Vec<[f32; 4]> = gpu.read_later(&buffers.known, count).await?;
        let pixel = |k: u32| {
            let at = (k / width * stride + k % width) as usize;
            let (place, [visibility, error2, ..]) = (&places[at], known[at]);
            (place.sharpness > 0.0).then(|| FramePixel {
                visibility,
                error: error2.sqrt(),
                rays: UNIT * tallies[at].units,
                position: self.eye + self.unit * place.position,
                normal: place.normal,
            })
        };
        Ok((0..width * height).map(pixel).collect())
    }
}
