//! Lines, words and numbers of text formats.

use std::borrow::Cow;

/// Lines of a text with their numbers from 1. Ends with LF, CR LF, or CR alone where the text has no LF.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    line: u64,
    end: u8,
    joins: bool,
}

impl<'a> Lines<'a> {
    /// Plain lines.
    pub(super) fn new(text: &'a [u8]) -> Self {
        let end = if !text.contains(&b'\n') && text.contains(&b'\r') { b'\r' } else { b'\n' };
        let rest = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        Self { rest, line: 0, end, joins: false }
    }

    /// Lines where a `\` at the end joins the next one, except in comments, where it ends a path more often.
    pub(super) fn joined(text: &'a [u8]) -> Self {
        Self { joins: true, ..Self::new(text) }
    }

    fn next_plain(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let length = self.rest.iter().position(|&b| b == self.end).unwrap_or(self.rest.len());
        let line = &self.rest[..length];
        self.rest = self.rest.get(length + 1..).unwrap_or(&[]);
        self.line += 1;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let line = self.next_plain()?;
        let number = self.line;
        if !(self.joins && line.ends_with(b"\\")) || line.trim_ascii_start().starts_with(b"#") {
            return Some((number, Cow::Borrowed(line)));
        }
        let mut whole = line[..line.len() - 1].to_vec();
        while let Some(next) = self.next_plain() {
            whole.push(b' ');
            match next.strip_suffix(b"\\") {
                Some(part) => whole.extend_from_slice(part),
                None => {
                    whole.extend_from_slice(next);
                    break;
                }
            }
        }
        Some((number, Cow::Owned(whole)))
    }
}

/// Takes the next word off the front of a line; empty at its end.
#[inline]
pub(super) fn word<'a>(rest: &mut &'a [u8]) -> &'a [u8] {
    let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
    let from = &rest[start..];
    let length = from.iter().position(u8::is_ascii_whitespace).unwrap_or(from.len());
    *rest = &from[length..];
    &from[..length]
}

/// A decimal number as the nearest `f32`; `None` where the word is no number. NaN and infinities are numbers here.
#[inline]
pub(super) fn float(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A whole number with an optional sign; `None` where the word is none or does not fit.
#[inline]
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] | digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}

/// The rest of a line as a name: trimmed, without a pair of quotation marks around it.
pub(super) fn name(rest: &[u8]) -> String {
    let trimmed = rest.trim_ascii();
    let bare = match trimmed {
        [b'"', inner @ .., b'"'] => inner,
        _ => trimmed,
    };
    String::from_utf8_lossy(bare).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(u64, String)> {
        Lines::joined(text.as_bytes()).map(|(n, l)| (n, String::from_utf8_lossy(&l).into_owned())).collect()
    }

    #[test]
    fn lines_end_in_every_usual_way_and_keep_their_numbers() {
        let expected = vec![(1, "a".to_string()), (2, String::new()), (3, "b".to_string())];
        for text in ["a\n\nb", "a\r\n\r\nb\r\n", "a\r\rb\r", "\u{feff}a\n\nb\n"] {
            assert_eq!(lines(text), expected, "{text:?}");
        }
    }

    #[test]
    fn a_backslash_joins_lines_but_not_after_a_comment() {
        assert_eq!(lines("f 1 2\\\r\n 3\r\nv"), [(1, "f 1 2  3".into()), (3, "v".into())]);
        assert_eq!(lines("# C:\\\nv"), [(1, "# C:\\".into()), (2, "v".into())]);
        assert_eq!(lines("f 1 \\"), [(1, "f 1 ".into())]);
    }

    #[test]
    fn numbers_are_read_to_the_nearest() {
        assert_eq!(float(b"0.1"), Some(0.1));
        assert_eq!(float(b"16777217.000000001"), Some(16_777_218.0), "not by way of a double");
        assert_eq!(float(b"1.#QNAN"), None);
        assert_eq!(integer(b"-12"), Some(-12));
        assert_eq!(integer(b"+3"), Some(3));
        for bad in ["", "-", "1.5", "99999999999999999999", "1a"] {
            assert_eq!(integer(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn names_keep_inner_spaces_and_lose_quotation_marks() {
        assert_eq!(name(b"  a b.png \r"), "a b.png");
        assert_eq!(name(b" \"my file.mtl\""), "my file.mtl");
    }
}
