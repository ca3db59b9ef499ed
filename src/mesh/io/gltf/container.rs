//! The container of binary glTF, GLB.
//!
//! ```text
//! "glTF"  version = 2  length of all        as u32, little endian
//! length  "JSON"   text                     the chunks
//! length  "BIN\0"  bytes                    perhaps; the first buffer
//! length  ...                               others are skipped
//! ```
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 4, "GLB File Format Specification".

use std::path::Path;

use crate::error::{Error, Result};
use crate::mesh::io::text::{BYTE_ORDER_MARK, quote};

pub const MAGIC: &[u8] = b"glTF";

const VERSION: u32 = 2;
const JSON: [u8; 4] = *b"JSON";
const BINARY: [u8; 4] = *b"BIN\0";

/// The parts of a file.
pub struct Content<'a> {
    pub json: &'a [u8],
    /// The buffer within the file.
    pub binary: Option<&'a [u8]>,
}

/// The parts of a binary file or of a JSON file.
pub fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<Content<'a>> {
    if !bytes.starts_with(MAGIC) {
        let json = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        return Ok(Content { json, binary: None });
    }
    chunks(bytes).map_err(|message| Error::malformed(path, message))
}

fn chunks(bytes: &[u8]) -> std::result::Result<Content<'_>, String> {
    let truncated = || "the header is truncated".to_owned();
    let (version, rest) = number(&bytes[MAGIC.len()..]).ok_or_else(truncated)?;
    if version != VERSION {
        return Err(format!("is binary glTF of version {version}; convert it to version 2"));
    }
    let (length, rest) = number(rest).ok_or_else(truncated)?;
    let header = bytes.len() - rest.len();
    let end = usize::try_from(length).unwrap_or(usize::MAX);
    if end > bytes.len() {
        return Err(format!("declares {end} bytes but has {}; it is truncated", bytes.len()));
    }
    if !bytes[end..].iter().all(|&b| b == 0 || b.is_ascii_whitespace()) {
        return Err(format!("continues after the {end} bytes that it declares"));
    }
    let mut rest = bytes.get(header..end).ok_or_else(truncated)?;
    let (kind, json) = chunk(&mut rest)?.ok_or("has no chunks")?;
    if kind != JSON {
        return Err(format!("the first chunk is {}, not \"JSON\"", quote(&kind)));
    }
    let mut binary = None;
    while let Some((kind, data)) = chunk(&mut rest)? {
        if kind == BINARY && binary.is_none() {
            binary = Some(data);
        }
    }
    Ok(Content { json, binary })
}

/// The kind and the data of the next chunk; none at the end.
#[expect(clippy::type_complexity)]
fn chunk<'a>(rest: &mut &'a [u8]) -> std::result::Result<Option<([u8; 4], &'a [u8])>, String> {
    if rest.is_empty() {
        return Ok(None);
    }
    let parts = number(rest).and_then(|(length, rest)| {
        let (kind, rest) = rest.split_first_chunk::<4>()?;
        let (data, rest) = rest.split_at_checked(usize::try_from(length).ok()?)?;
        Some((*kind, data, rest))
    });
    let (kind, data, behind) = parts.ok_or("a chunk reaches beyond the end of the file")?;
    *rest = behind;
    Ok(Some((kind, data)))
}

fn number(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (number, rest) = bytes.split_first_chunk::<4>()?;
    Some((u32::from_le_bytes(*number), rest))
}
