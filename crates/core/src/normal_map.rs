//! Normal maps: how a texture bends the normals of a surface.

use crate::{Affine2, Vec2, Vec3, Wrap, wrap::taps};
use std::sync::Arc;

/// Normals in the tangent space of a surface, 8 bits a component, with ever smaller copies of themselves; the first row is at v = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalTexture {
    /// The texture, then each of half the sides of the one before.
    levels: Vec<Level>,
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    width: u32,
    height: u32,
    /// Components from -1 to 1 as 0 to 255.
    texels: Vec<[u8; 3]>,
}

impl NormalTexture {
    /// A texture from `width * height` texels in rows, components from -1 to 1 as 0 to 255; `None` where the count differs or is zero.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; 3]>) -> Option<Self> {
        let count = u64::from(width) * u64::from(height);
        if count == 0 || texels.len() as u64 != count {
            return None;
        }
        let mut levels = vec![Level { width, height, texels }];
        while let Some(last) = levels.last().filter(|last| last.width.max(last.height) > 1) {
            levels.push(last.halved());
        }
        Some(Self { levels })
    }

    /// Texels per row.
    pub fn width(&self) -> u32 {
        self.levels[0].width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.levels[0].height
    }

    /// The texels, row by row.
    pub fn texels(&self) -> &[[u8; 3]] {
        &self.levels[0].texels
    }

    /// Bytes of all levels.
    pub fn memory_bytes(&self) -> u64 {
        self.levels.iter().map(|level| 3 * level.texels.len() as u64).sum()
    }

    /// Bilinear look-up of the mean normal over `spread` texels, not a unit vector; texel centres lie at half-integers. The means are
    /// those of the level whose texels are at most as large. Non-finite coordinates give straight up.
    pub fn at(&self, uv: Vec2, wrap: [Wrap; 2], spread: f32) -> Vec3 {
        if !uv.is_finite() {
            return Vec3::Z;
        }
        // Not a number counts as 1.
        let level = spread.max(1.0).log2() as usize;
        self.levels[level.min(self.levels.len() - 1)].bilinear(uv, wrap)
    }
}

impl Level {
    fn texel(&self, x: usize, y: usize) -> Vec3 {
        let [x, y, z] = self.texels[y * self.width as usize + x].map(f32::from);
        Vec3::new(x, y, z) * (2.0 / 255.0) - 1.0
    }

    fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2]) -> Vec3 {
        let (x0, x1, fx) = taps(uv.x, self.width, wrap[0]);
        let (y0, y1, fy) = taps(uv.y, self.height, wrap[1]);
        let top = self.texel(x0, y0).lerp(self.texel(x1, y0), fx);
        let bottom = self.texel(x0, y1).lerp(self.texel(x1, y1), fx);
        top.lerp(bottom, fy)
    }

    /// Half the sides, rounded up: the last texel of an odd side stands for itself.
    fn halved(&self) -> Self {
        let [width, height] = [self.width, self.height].map(|side| side.div_ceil(2));
        let last = [self.width - 1, self.height - 1];
        let mean = |at: u32| {
            let [x, y] = [2 * (at % width), 2 * (at / width)];
            let mut sum = [0u32; 3];
            for [dx, dy] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let [x, y] = [(x + dx).min(last[0]), (y + dy).min(last[1])];
                let texel = self.texels[(y * self.width + x) as usize];
                (0..3).for_each(|k| sum[k] += u32::from(texel[k]));
            }
            sum.map(|sum| ((sum + 2) / 4) as u8)
        };
        Self { width, height, texels: (0..width * height).map(mean).collect() }
    }
}

/// How a material's normal map is read.
#[derive(Clone, Debug)]
pub struct NormalMap {
    /// The normals.
    pub texture: Arc<NormalTexture>,
    /// Which UV set of the mesh reads it.
    pub uv_set: usize,
    /// From mesh UVs to texture coordinates: flips, offsets, scales, rotations.
    pub texture_from_uv: Affine2,
    /// Outside the unit square, in u and v.
    pub wrap: [Wrap; 2],
    /// Multiplies what of a normal lies along the surface.
    pub scale: f32,
}

impl NormalMap {
    /// The unit normal at a mesh's UV in tangent space, as the mean over `spread` texels: along u, up in the picture, away from the surface. Straight up where the
    /// texture says nothing.
    pub fn at(&self, uv: Vec2, spread: f32) -> Vec3 {
        let normal = self.texture.at(self.texture_from_uv.transform_point2(uv), self.wrap, spread);
        (normal * Vec3::new(self.scale, self.scale, 1.0)).normalize_or(Vec3::Z)
    }

    /// Area of a triangle, by the UVs of its corners, in texels.
    pub fn texels(&self, corners: [Vec2; 3]) -> f32 {
        let size = Vec2::new(self.texture.width() as f32, self.texture.height() as f32);
        let [a, b, c] = corners.map(|uv| self.texture_from_uv.transform_point2(uv) * size);
        0.5 * (b - a).perp_dot(c - a).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One texel leans to the right, the one beside it to the left.
    fn texture() -> NormalTexture {
        NormalTexture::new(2, 1, vec![[255, 128, 128], [0, 128, 128]]).unwrap()
    }

    fn map(scale: f32) -> NormalMap {
        let texture = Arc::new(texture());
        NormalMap { texture, uv_set: 0, texture_from_uv: Affine2::IDENTITY, wrap: [Wrap::Clamp; 2], scale }
    }

    #[test]
    fn texels_are_read_between_and_over_their_spread() {
        let at = |u: f32, spread: f32| texture().at(Vec2::new(u, 0.5), [Wrap::Clamp; 2], spread).x;
        assert_eq!([at(0.25, 1.0), at(0.75, 1.0)], [1.0, -1.0]);
        assert_eq!([at(0.5, 1.0), at(0.25, 1.9)], [0.0, 1.0]);
        for spread in [2.0, 1e9, f32::INFINITY] {
            assert!(at(0.25, spread).abs() < 0.01, "{spread}");
        }
        assert_eq!(at(0.25, f32::NAN), 1.0);
        assert_eq!(texture().at(Vec2::NAN, [Wrap::Repeat; 2], 1.0), Vec3::Z);
        assert_eq!(texture().memory_bytes(), 9);
    }

    #[test]
    fn the_scale_bends_normals_and_leaves_them_unit_vectors() {
        let [plain, half] = [1.0, 0.5].map(|scale| map(scale).at(Vec2::new(0.25, 0.5), 1.0));
        assert!((plain.length() - 1.0).abs() < 1e-6 && (half.length() - 1.0).abs() < 1e-6);
        assert!((half.x / half.z - 0.5 * plain.x / plain.z).abs() < 1e-3 * plain.x / plain.z);
        let flat = NormalTexture::new(1, 1, vec![[128, 128, 255]]).unwrap();
        let flat = NormalMap { texture: Arc::new(flat), ..map(0.0) };
        assert_eq!(flat.at(Vec2::ZERO, 1.0), Vec3::Z);
    }

    #[test]
    fn triangles_are_measured_in_texels() {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::Y];
        assert_eq!(map(1.0).texels(corners), 1.0);
        let doubled = NormalMap { texture_from_uv: Affine2::from_scale(Vec2::splat(2.0)), ..map(1.0) };
        assert_eq!(doubled.texels(corners), 4.0);
    }

    #[test]
    fn odd_sides_and_wrong_counts() {
        let texels = vec![[10, 20, 30]; 15];
        let texture = NormalTexture::new(5, 3, texels).unwrap();
        let sides: Vec<(u32, u32)> = texture.levels.iter().map(|l| (l.width, l.height)).collect();
        assert_eq!(sides, [(5, 3), (3, 2), (2, 1), (1, 1)]);
        assert!(texture.levels.iter().flat_map(|l| &l.texels).all(|texel| *texel == [10, 20, 30]));
        assert!(NormalTexture::new(2, 2, vec![[0; 3]; 3]).is_none());
        assert!(NormalTexture::new(0, 2, vec![]).is_none());
    }
}
