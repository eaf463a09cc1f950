//! Fingerprints: short names for everything that a kept result depends on.
//!
//! XXH3 with 128 bits: Collet, "xxHash", 2019, by way of the `twox-hash` crate. Values go in as little-endian bytes of
//! fixed width behind a mark of their kind, lists behind their length, so that a fingerprint is the same on every machine
//! and no two different sequences of values run together.

use crate::{Geometry, Opacity, SurfacePoint, TextureOpacity, Vec3, Wrap};
use std::fmt;
use twox_hash::XxHash3_128;

/// 128 bits that stand for what a result depends on; shown as 32 hex digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fingerprint(u128);

impl Fingerprint {
    /// The fingerprint of the values that `describe` feeds.
    pub fn of(describe: impl FnOnce(&mut Feed)) -> Self {
        let mut feed = Feed { hasher: XxHash3_128::new(), pending: Vec::with_capacity(FLUSH_BYTES + 64) };
        describe(&mut feed);
        feed.flush();
        Self(feed.hasher.finish_128())
    }

    /// As bytes, the least significant first.
    #[must_use]
    pub fn to_le_bytes(self) -> [u8; 16] {
        self.0.to_le_bytes()
    }

    /// From [`Fingerprint::to_le_bytes`].
    #[must_use]
    pub fn from_le_bytes(bytes: [u8; 16]) -> Self {
        Self(u128::from_le_bytes(bytes))
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// Bytes handed to the hash at a time: it is slow with a few bytes at once.
const FLUSH_BYTES: usize = 1 << 14;

/// Takes the values that make a fingerprint.
pub struct Feed {
    hasher: XxHash3_128,
    pending: Vec<u8>,
}

impl Feed {
    /// A number of 32 bits.
    pub fn u32(&mut self, value: u32) {
        self.put(b'u', &value.to_le_bytes());
    }

    /// A number of 64 bits.
    pub fn u64(&mut self, value: u64) {
        self.put(b'U', &value.to_le_bytes());
    }

    /// A single-precision number, by its bits.
    pub fn f32(&mut self, value: f32) {
        self.put(b'f', &value.to_le_bytes());
    }

    /// A double-precision number, by its bits.
    pub fn f64(&mut self, value: f64) {
        self.put(b'F', &value.to_le_bytes());
    }

    /// A point or direction.
    pub fn vector(&mut self, value: Vec3) {
        value.to_array().into_iter().for_each(|v| self.f32(v));
    }

    /// Text.
    pub fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    /// Bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.put(b'b', &(bytes.len() as u64).to_le_bytes());
        self.flush();
        self.hasher.write(bytes);
    }

    /// How many items follow.
    pub fn length(&mut self, length: usize) {
        self.put(b'n', &(length as u64).to_le_bytes());
    }

    /// Another fingerprint.
    pub fn fingerprint(&mut self, fingerprint: Fingerprint) {
        self.put(b'p', &fingerprint.to_le_bytes());
    }

    /// All that occludes. Names, vertex normals and UVs that no opacity reads make no difference to a ray.
    pub fn geometry(&mut self, all: &Geometry) {
        geometry(self, all);
    }

    /// How many points, and of each all that an estimate by rays depends on.
    pub fn points(&mut self, points: &[SurfacePoint]) {
        self.length(points.len());
        for point in points {
            self.vector(point.position);
            self.vector(point.geometric_normal);
            self.vector(point.shading_normal);
            self.f32(point.position_error);
            self.u32(point.id);
        }
    }

    fn put(&mut self, kind: u8, bytes: &[u8]) {
        self.pending.push(kind);
        self.pending.extend_from_slice(bytes);
        if self.pending.len() >= FLUSH_BYTES {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.hasher.write(&self.pending);
        self.pending.clear();
    }
}

fn geometry(feed: &mut Feed, geometry: &Geometry) {
    feed.length(geometry.meshes().len());
    for (m, mesh) in geometry.meshes().iter().enumerate() {
        feed.length(mesh.positions().len());
        mesh.positions().iter().for_each(|&p| feed.vector(p));
        feed.length(mesh.triangles().len());
        mesh.triangles().iter().flatten().for_each(|&v| feed.u32(v));
        if geometry.is_one_sided(m) {
            feed.text("one-sided");
        }
        match geometry.opacity(m) {
            Opacity::Constant(opacity) => {
                feed.text("constant");
                feed.f32(*opacity);
            }
            Opacity::Texture(opacity) => {
                feed.text("texture");
                texture(feed, opacity);
                let uvs = mesh.uv_sets().get(opacity.uv_set).map_or(&[][..], Vec::as_slice);
                feed.length(uvs.len());
                uvs.iter().flat_map(|uv| uv.to_array()).for_each(|v| feed.f32(v));
            }
        }
    }
    feed.length(geometry.instances().len());
    for instance in geometry.instances() {
        feed.u32(instance.mesh);
        instance.world_from_mesh.to_cols_array().into_iter().for_each(|v| feed.f32(v));
    }
}

fn texture(feed: &mut Feed, opacity: &TextureOpacity) {
    let TextureOpacity { texture, uv_set, texture_from_uv, wrap, factor, cutoff } = opacity;
    feed.u32(texture.width());
    feed.bytes(texture.texels());
    feed.length(*uv_set);
    texture_from_uv.to_cols_array().into_iter().for_each(|v| feed.f32(v));
    for wrap in wrap {
        feed.text(match wrap {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        });
    }
    feed.f32(*factor);
    // No cutoff is NaN.
    feed.f32(cutoff.unwrap_or(f32::NAN));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        // The value that the xxHash specification's reference implementation gives for no input at all:
        // XXH3_128bits(NULL, 0), https://github.com/Cyan4973/xxHash.
        assert_eq!(Fingerprint::of(|_| {}).to_string(), "99aa06d3014798d86001c324468d497f");
    }

    #[test]
    fn how_values_are_gathered_makes_no_difference() {
        // More than is handed to the hash at once.
        let count = 3 * FLUSH_BYTES as u32;
        let whole = Fingerprint::of(|feed| (0..count).for_each(|v| feed.u32(v)));
        let in_pieces = Fingerprint::of(|feed| {
            for v in 0..count {
                feed.u32(v);
                feed.flush();
            }
        });
        assert_eq!(whole, in_pieces);
        assert_ne!(
            whole,
            Fingerprint::of(|feed| (1..=count).for_each(|v| feed.u32(v))),
            "the oracle can fail"
        );
    }
}
