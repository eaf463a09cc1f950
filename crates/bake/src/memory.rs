//! How much memory a bake takes, before it takes it.

use crate::{BentSpace, PORTION, Places, bent::TexelPlaces};

/// Bytes that a place of a portion takes while it is estimated: its point, tallies, guesses, answers. Measured by
/// `conray bake` on a map of 2048 x 2048 of which three quarters are read, as peak memory over places.
const BYTES_PER_PLACE: u64 = 352;
/// Bytes of a texel of a map: visibility, error, direction, whether it is read, and its file while it is written.
const BYTES_PER_TEXEL: u64 = 32;
/// Bytes of a triangle that a map is read by: its UVs, and its edges while seams are found.
const BYTES_PER_TRIANGLE: u64 = 600;
/// Fewer places than this are no portion.
const LEAST_PORTION: u64 = 1 << 16;

/// Bytes of a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// The scene, what was built for it, and the maps.
    pub always: u64,
    /// A portion.
    pub portion: u64,
    /// Places in a portion.
    pub places: u64,
}

impl Memory {
    /// Bytes of estimating so many points together, within a limit where there is one.
    ///
    /// # Errors
    /// The bytes that are needed.
    pub fn of_points(points: u64, structures: u64, limit: Option<u64>) -> Result<u64, u64> {
        let needed = structures + points * BYTES_PER_PLACE;
        if limit.is_none_or(|limit| needed <= limit) { Ok(needed) } else { Err(needed) }
    }

    /// What a bake of some places takes within `limit` bytes, where there is one; `structures` are the bytes of the scene and what was built for it.
    ///
    /// # Errors
    /// The bytes that are needed at least.
    pub fn within(
        places: &Places,
        bent: BentSpace,
        structures: u64,
        limit: Option<u64>,
    ) -> Result<Self, u64> {
        let texels: u64 =
            places.atlas.sizes.iter().map(|size| u64::from(size.width) * u64::from(size.height)).sum();
        let triangles: u64 = places.atlas.surfaces.iter().map(|surface| surface.uvs.len() as u64).sum();
        let turning = if bent == BentSpace::Tangent { TexelPlaces::BYTES } else { 0 };
        let always = structures + texels * (BYTES_PER_TEXEL + turning) + triangles * BYTES_PER_TRIANGLE;
        let parts = u64::from(places.atlas.supersample).pow(2);
        let most = PORTION.min(texels * parts);
        let least = most.min(LEAST_PORTION);
        let room = limit.map_or(most, |limit| limit.saturating_sub(always) / BYTES_PER_PLACE);
        if room < least {
            return Err(always + least * BYTES_PER_PLACE);
        }
        let portion = room.min(most);
        Ok(Self { always, portion: portion * BYTES_PER_PLACE, places: portion })
    }
}
