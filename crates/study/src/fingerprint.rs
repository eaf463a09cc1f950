//! Fingerprints: short names for everything that a kept result depends on.
//!
//! XXH3 with 128 bits: Collet, "xxHash", 2019, by way of the `twox-hash` crate. Values go in as little-endian bytes of
//! fixed width behind a mark of their kind, lists behind their length, so that a fingerprint is the same on every machine
//! and no two different sequences of values run together.

use crate::{Case, StudyError};
use conray::{Geometry, Method, Opacity, TextureOpacity, Vec3, Wrap};
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

    /// The fingerprint of all that the truth of a case depends on: what occludes, the surface points, the AO distance
    /// in world units, the falloff, what opacity means, and the seed. Names, views and methods do not count.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn of_case(case: &Case) -> Result<Self, StudyError> {
        let plan =
            case.session.plan_for(&conray::AoSettings { method: Method::Rays, ..case.settings.clone() })?;
        Ok(Self::of(|feed| {
            feed.text("case 1");
            geometry(feed, case.session.geometry());
            feed.length(case.points().len());
            for point in case.points() {
                feed.vector(point.position);
                feed.vector(point.geometric_normal);
                feed.vector(point.shading_normal);
                feed.f32(point.position_error);
                feed.u32(point.id);
            }
            feed.f32(plan.distance);
            feed.text(&plan.falloff.to_string());
            feed.text(match case.settings.alpha {
                conray::Alpha::Material => "material",
                conray::Alpha::Opaque => "opaque",
            });
            feed.u32(plan.seed);
        }))
    }

    /// As bytes, the least significant first.
    pub(crate) fn to_le_bytes(self) -> [u8; 16] {
        self.0.to_le_bytes()
    }

    /// From [`Fingerprint::to_le_bytes`].
    pub(crate) fn from_le_bytes(bytes: [u8; 16]) -> Self {
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

/// All that occludes. Names, vertex normals and UVs that no opacity reads make no difference to a ray.
fn geometry(feed: &mut Feed, geometry: &Geometry) {
    feed.length(geometry.meshes().len());
    for (m, mesh) in geometry.meshes().iter().enumerate() {
        feed.length(mesh.positions().len());
        mesh.positions().iter().for_each(|&p| feed.vector(p));
        feed.length(mesh.triangles().len());
        mesh.triangles().iter().flatten().for_each(|&v| feed.u32(v));
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
mod tests;
