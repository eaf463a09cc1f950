//! Places in textures: what lies outside the unit square, and which texels a place lies between.

/// What happens to texture coordinates outside the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// It repeats, every second time mirrored.
    Mirror,
    /// The outermost texels go on.
    Clamp,
}

/// The two texels either side of a coordinate and the weight of the second.
pub(crate) fn taps(coordinate: f32, size: u32, wrap: Wrap) -> (usize, usize, f32) {
    // Wrapped before scaling, so that coordinates far from the unit square keep their fraction.
    let wrapped = match wrap {
        Wrap::Repeat => coordinate - coordinate.floor(),
        Wrap::Mirror => 1.0 - (coordinate.rem_euclid(2.0) - 1.0).abs(),
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
    };
    let position = wrapped * size as f32 - 0.5;
    let low = position.floor();
    // Wrapped coordinates are at most half a texel outside, so one step back is enough where a division would be.
    let (low_texel, size) = (low as i64, i64::from(size));
    let inside = |texel: i64| match wrap {
        Wrap::Repeat if texel < 0 => texel + size,
        Wrap::Repeat if texel >= size => texel - size,
        Wrap::Repeat => texel,
        Wrap::Mirror | Wrap::Clamp => texel.clamp(0, size - 1),
    } as usize;
    (inside(low_texel), inside(low_texel + 1), position - low)
}
