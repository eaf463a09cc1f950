//! How much a surface blocks: constants and alpha textures, by the one rule that rays and voxels share.

use crate::{Affine2, Vec2, Wrap, wrap::taps};
use std::sync::Arc;

/// One channel of opacity, 8 bits a texel; the first row is at v = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaTexture {
    width: u32,
    height: u32,
    texels: Vec<u8>,
}

impl AlphaTexture {
    /// A texture from `width * height` texels in rows; `None` where the count differs or is zero.
    pub fn new(width: u32, height: u32, texels: Vec<u8>) -> Option<Self> {
        let count = u64::from(width) * u64::from(height);
        (count > 0 && texels.len() as u64 == count).then_some(Self { width, height, texels })
    }

    /// Texels per row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The texels, row by row.
    pub fn texels(&self) -> &[u8] {
        &self.texels
    }

    /// Bilinear look-up in [0, 1]; texel centres lie at half-integers. Non-finite coordinates give 1.
    pub fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2]) -> f32 {
        if !uv.is_finite() {
            return 1.0;
        }
        let (x0, x1, fx) = taps(uv.x, self.width, wrap[0]);
        let (y0, y1, fy) = taps(uv.y, self.height, wrap[1]);
        let texel = |x: usize, y: usize| f32::from(self.texels[y * self.width as usize + x]);
        let top = texel(x0, y0) + fx * (texel(x1, y0) - texel(x0, y0));
        let bottom = texel(x0, y1) + fx * (texel(x1, y1) - texel(x0, y1));
        (top + fy * (bottom - top)) / 255.0
    }
}

/// Opacity read from a texture.
#[derive(Clone, Debug)]
pub struct TextureOpacity {
    /// The alpha channel.
    pub texture: Arc<AlphaTexture>,
    /// Which UV set of the mesh it reads.
    pub uv_set: usize,
    /// From mesh UVs to texture coordinates: flips, offsets, scales, rotations.
    pub texture_from_uv: Affine2,
    /// Outside the unit square, in u and v.
    pub wrap: [Wrap; 2],
    /// Multiplies the texel before the cutoff, in [0, 1].
    pub factor: f32,
    /// With a cutoff, opacity is 1 where the filtered value reaches it and 0 elsewhere; without, it is fractional.
    pub cutoff: Option<f32>,
}

impl TextureOpacity {
    /// Opacity in [0, 1] at a mesh's UV.
    pub fn at(&self, uv: Vec2) -> f32 {
        let value = self.factor * self.texture.bilinear(self.texture_from_uv.transform_point2(uv), self.wrap);
        match self.cutoff {
            Some(cutoff) => f32::from(value >= cutoff),
            None => value.clamp(0.0, 1.0),
        }
    }
}

/// How much of what meets a surface it blocks: 1 is opaque, 0 lets all through.
#[derive(Clone, Debug)]
pub enum Opacity {
    /// The same everywhere, in [0, 1].
    Constant(f32),
    /// Read from a texture.
    Texture(TextureOpacity),
}

impl Default for Opacity {
    fn default() -> Self {
        Self::Constant(1.0)
    }
}

impl Opacity {
    /// True where no look-up is ever needed.
    pub fn is_opaque(&self) -> bool {
        matches!(self, Self::Constant(opacity) if *opacity >= 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker() -> AlphaTexture {
        AlphaTexture::new(2, 2, vec![0, 255, 255, 0]).unwrap()
    }

    #[test]
    fn texel_centres_are_exact_and_the_middle_is_half() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            assert_eq!(checker().bilinear(Vec2::new(0.25, 0.25), [wrap; 2]), 0.0);
            assert_eq!(checker().bilinear(Vec2::new(0.75, 0.25), [wrap; 2]), 1.0);
            assert_eq!(checker().bilinear(Vec2::new(0.5, 0.5), [wrap; 2]), 0.5);
        }
    }

    #[test]
    fn wrapping_repeats_mirrors_and_clamps() {
        let at = |u: f32, wrap: Wrap| checker().bilinear(Vec2::new(u, 0.25), [wrap; 2]);
        assert_eq!(at(27.75, Wrap::Repeat), at(0.75, Wrap::Repeat));
        assert_eq!(at(-3.25, Wrap::Repeat), at(0.75, Wrap::Repeat));
        assert_eq!(at(1.25, Wrap::Mirror), at(0.75, Wrap::Mirror));
        assert_eq!(at(7.0, Wrap::Clamp), 1.0);
        assert_eq!(at(0.0, Wrap::Repeat), 0.5, "repeat blends across the border");
    }

    #[test]
    fn nonsense_coordinates_do_not_panic() {
        for u in [f32::NAN, f32::INFINITY, 1e30, -1e30, f32::MAX] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                assert!((0.0..=1.0).contains(&checker().bilinear(Vec2::new(u, -u), [wrap; 2])));
            }
        }
    }

    #[test]
    fn cutoff_makes_a_mask_and_its_absence_a_fraction() {
        let mut opacity = TextureOpacity {
            texture: Arc::new(AlphaTexture::new(1, 1, vec![102]).unwrap()),
            uv_set: 0,
            texture_from_uv: Affine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            factor: 1.0,
            cutoff: Some(0.4),
        };
        assert_eq!(opacity.at(Vec2::ZERO), 1.0);
        opacity.cutoff = Some(0.41);
        assert_eq!(opacity.at(Vec2::ZERO), 0.0);
        opacity.cutoff = None;
        assert_eq!(opacity.at(Vec2::ZERO), 0.4);
    }

    #[test]
    fn a_texture_needs_all_its_texels() {
        assert!(AlphaTexture::new(2, 2, vec![0; 3]).is_none());
        assert!(AlphaTexture::new(0, 2, vec![]).is_none());
    }
}
