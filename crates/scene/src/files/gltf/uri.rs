//! The URIs of a glTF: inline data or files beside it.

use crate::files::error::{Fault, shown};
use crate::files::intake::Intake;
use crate::files::source::network_scheme;
use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::io;

/// Base64 with or without the padding at the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Bytes of a URI. The inner result tells whether the file could be had, which not every asker minds.
pub(super) fn read_uri(uri: &str, asker: &str, intake: &Intake) -> Result<io::Result<Vec<u8>>, Fault> {
    if let Some(inline) = uri.strip_prefix("data:") {
        return decode_data(inline).map(Ok).map_err(|reason| Fault::element(asker, reason));
    }
    if network_scheme(uri).is_some() {
        return Err(Fault::unsupported(format!("reading over a network (`{}`)", shown(uri.as_bytes()))));
    }
    let path = percent_decoded(uri);
    Ok(match (intake.resolve)(&String::from_utf8_lossy(&path)) {
        // Exporters that do not encode may have a per cent sign in the name itself.
        Err(error) if error.kind() == io::ErrorKind::NotFound && path != uri.as_bytes() => {
            (intake.resolve)(uri)
        }
        result => result,
    })
}

/// What follows `data:`: a media type, perhaps `;base64`, a comma and the data.
fn decode_data(inline: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = inline.split_once(',').ok_or("its data URI has no comma")?;
    if kind.ends_with(";base64") {
        BASE64.decode(data.trim_ascii()).map_err(|e| format!("its data URI is no base64: {e}"))
    } else {
        Ok(percent_decoded(data))
    }
}

/// Replaces `%xx` by the byte of that value (RFC 3986, section 2.1).
pub(crate) fn percent_decoded(text: &str) -> Vec<u8> {
    let digit = |b: Option<&u8>| b.and_then(|b| char::from(*b).to_digit(16)).map(|d| d as u8);
    let bytes = text.as_bytes();
    let (mut out, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while at < bytes.len() {
        match (bytes[at], digit(bytes.get(at + 1)), digit(bytes.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push(16 * high + low);
                at += 3;
            }
            (byte, _, _) => {
                out.push(byte);
                at += 1;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_signs_are_decoded_where_they_mean_something() {
        assert_eq!(percent_decoded("a%20b%C3%a9.bin"), "a bé.bin".as_bytes());
        assert_eq!(percent_decoded("100%.bin%2"), b"100%.bin%2");
    }

    #[test]
    fn data_uris_come_in_two_kinds() {
        assert_eq!(decode_data("application/octet-stream;base64,AAEC/w==").unwrap(), [0, 1, 2, 255]);
        assert_eq!(decode_data(";base64,AAEC/w").unwrap(), [0, 1, 2, 255]);
        assert_eq!(decode_data("text/plain,a%20b").unwrap(), b"a b");
        assert!(decode_data(";base64").is_err());
        assert!(decode_data(";base64,*").unwrap_err().contains("base64"));
    }
}
