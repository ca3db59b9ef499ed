//! URIs of buffers and images.
//!
//! ```text
//! data:[type][;base64],DATA     inside the file
//! a%20b.bin                     a file, relative to the folder of the glTF file
//! https://host/a.bin            elsewhere: never read
//! ```
//!
//! Reference: RFC 2397, *The "data" URL scheme*, and RFC 3986, *Uniform Resource Identifier*.

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use crate::mesh::io::text::decode;

/// Some programs leave out the `=` at the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// What a URI refers to.
#[derive(Debug, PartialEq)]
pub enum Target<'a> {
    /// What follows `data:`.
    Inside(&'a str),
    /// The name of a file with slashes.
    File(String),
    Elsewhere,
}

impl<'a> Target<'a> {
    pub fn of(uri: &'a str) -> Self {
        let scheme = uri.split_once(':').filter(|(scheme, _)| {
            // A single letter is a drive.
            scheme.len() > 1
                && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b))
        });
        match scheme {
            Some((scheme, data)) if scheme.eq_ignore_ascii_case("data") => Target::Inside(data),
            Some(_) => Target::Elsewhere,
            None => Target::File(decode(&percent_decoded(uri)).replace('\\', "/")),
        }
    }
}

/// The bytes of a data URI without `data:`, if they are valid.
pub fn bytes(data: &str) -> Option<Vec<u8>> {
    let (kind, text) = data.split_once(',')?;
    let base64 = kind.rsplit(';').next().is_some_and(|word| word.eq_ignore_ascii_case("base64"));
    match base64 {
        true if text.contains('%') => BASE64.decode(percent_decoded(text)).ok(),
        true => BASE64.decode(text).ok(),
        false => Some(percent_decoded(text)),
    }
}

/// A `%` that two hexadecimal digits do not follow stays.
fn percent_decoded(text: &str) -> Vec<u8> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&byte, behind)) = rest.split_first() {
        let escaped = (byte == b'%').then(|| hexadecimal(behind)).flatten();
        decoded.push(escaped.unwrap_or(byte));
        rest = if escaped.is_some() { &behind[2..] } else { behind };
    }
    decoded
}

/// The value of the first two digits.
fn hexadecimal(text: &[u8]) -> Option<u8> {
    let digits = std::str::from_utf8(text.get(..2)?).ok()?;
    let are_digits = digits.bytes().all(|b| b.is_ascii_hexdigit());
    are_digits.then(|| u8::from_str_radix(digits, 16).ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_of_every_kind() {
        let file = |name: &str| Target::File(name.into());
        for (uri, target) in [
            ("a.bin", file("a.bin")),
            ("a%20b%2Fc%zz%4.bin", file("a b/c%zz%4.bin")),
            ("%C3%BC.png", file("\u{fc}.png")),
            ("..\\a.png", file("../a.png")),
            ("C:/a.png", file("C:/a.png")),
            ("a/b:c.png", file("a/b:c.png")),
            ("https://a/b.png", Target::Elsewhere),
            ("file:///a.png", Target::Elsewhere),
            ("DATA:,x", Target::Inside(",x")),
        ] {
            assert_eq!(Target::of(uri), target, "{uri}");
        }
    }

    #[test]
    fn data_of_every_kind() {
        for (data, expected) in [
            (",a%00b", Some(&b"a\0b"[..])),
            (";base64,AAEC", Some(&[0, 1, 2])),
            ("application/octet-stream;base64,AAE=", Some(&[0, 1])),
            (";base64,AAE", Some(&[0, 1])),
            (";base64,AAE%3D", Some(&[0, 1])),
            (";BASE64,", Some(&[])),
            (";base64,A", None),
            (";base64,AA E", None),
            (";base64", None),
        ] {
            assert_eq!(bytes(data).as_deref(), expected, "{data}");
        }
    }
}
