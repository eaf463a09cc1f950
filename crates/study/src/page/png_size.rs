//! The size of a picture, read from its first bytes.

/// Width and height of a PNG (ISO/IEC 15948, section 11.2.2: the header follows the signature); `None` for anything else.
pub(super) fn of(bytes: &[u8]) -> Option<(u32, u32)> {
    let rest = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n")?;
    let number = |at: usize| Some(u32::from_be_bytes(rest.get(at..at + 4)?.try_into().ok()?));
    (rest.get(4..8)? == b"IHDR").then_some((number(8)?, number(12)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;

    #[test]
    fn the_size_is_that_of_the_picture() {
        let png = Picture::plain(321, 7, [1, 2, 3]).to_png();
        assert_eq!(of(&png), Some((321, 7)));
        assert!((0..24).all(|end| of(&png[..end]).is_none()));
        assert_eq!(of(&png[1..]), None);
    }
}
