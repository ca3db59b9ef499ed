//! The bytes of arrays in files of XML: within the text in base64, or behind it.
//!
//! ```text
//! plain        n  bytes                                              n: their number
//! compressed   k  size  last  c_1 ... c_k  block_1 ... block_k       blocks of zlib, all of `size` bytes but the last
//! ```
//!
//! Numbers of the heading have 32 or 64 bits. In base64 the heading of compressed data is encoded by itself, so that
//! padding may stand within the text.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

type Said<T> = std::result::Result<T, String>;

/// Zlib makes at most about this many bytes of one.
const LARGEST_RATIO: usize = 1040;

/// How bytes are coded.
pub struct Coding {
    pub little: bool,
    /// Whether numbers of the heading have 64 bits.
    pub wide: bool,
    pub compressed: bool,
}

/// What follows the text of a file.
pub struct Appended<'a> {
    bytes: &'a [u8],
    is_raw: bool,
}

impl<'a> Appended<'a> {
    /// The text of a file, in which the appended data are left out, and these.
    pub fn split(bytes: &'a [u8]) -> Said<(Cow<'a, [u8]>, Option<Self>)> {
        const TAG: &[u8] = b"<AppendedData";
        let utf8 = |bytes: &'a [u8]| str::from_utf8(bytes).map_err(|_| "is not text in UTF-8");
        let Some(tag) = bytes.windows(TAG.len()).position(|window| window == TAG) else {
            return Ok((Cow::Borrowed(bytes), None));
        };
        let cut = || "its AppendedData are cut off".to_owned();
        let end = tag + bytes[tag..].iter().position(|&b| b == b'>').ok_or_else(cut)?;
        let attributes = utf8(&bytes[tag..end])?;
        let is_raw = attributes.contains("\"raw\"") || attributes.contains("'raw'");
        if attributes.ends_with('/') {
            return Ok((Cow::Borrowed(bytes), None));
        }
        let text = [&bytes[..end], b"></AppendedData></VTKFile>"].concat();
        let behind = &bytes[end + 1..];
        let begin = behind.iter().position(|&b| b == b'_').ok_or_else(cut)?;
        let bytes = &behind[begin + 1..];
        let bytes = match is_raw {
            true => bytes,
            false => &bytes[..bytes.iter().position(|&b| b == b'<').unwrap_or(bytes.len())],
        };
        Ok((Cow::Owned(text), Some(Appended { bytes, is_raw })))
    }

    /// The bytes of the array at an offset.
    pub fn at(&self, offset: usize, coding: &Coding) -> Said<Cow<'a, [u8]>> {
        let bytes = self.bytes.get(offset..).ok_or("its offset is behind the end of the file")?;
        match self.is_raw {
            true => coding.raw(bytes),
            false => coding.base64(bytes).map(Cow::Owned),
        }
    }
}

impl Coding {
    fn word(&self) -> usize {
        if self.wide { 8 } else { 4 }
    }

    /// The i-th number of a heading.
    fn heading(&self, bytes: &[u8], i: usize) -> Said<usize> {
        let at = i * self.word();
        let word = bytes.get(at..at + self.word()).ok_or("its bytes are cut off")?;
        let number = match (self.wide, self.little) {
            (false, true) => u64::from(u32::from_le_bytes(word.try_into().expect("4 bytes"))),
            (false, false) => u64::from(u32::from_be_bytes(word.try_into().expect("4 bytes"))),
            (true, true) => u64::from_le_bytes(word.try_into().expect("8 bytes")),
            (true, false) => u64::from_be_bytes(word.try_into().expect("8 bytes")),
        };
        usize::try_from(number).map_err(|_| "has too many bytes".into())
    }

    /// The bytes after a heading, which may be followed by others.
    fn raw<'b>(&self, bytes: &'b [u8]) -> Said<Cow<'b, [u8]>> {
        if !self.compressed {
            let n = self.heading(bytes, 0)?;
            let plain = bytes[self.word()..].get(..n).ok_or("its bytes are cut off")?;
            return Ok(Cow::Borrowed(plain));
        }
        let blocks = self.heading(bytes, 0)?;
        if blocks == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let length = blocks.checked_add(3).and_then(|n| n.checked_mul(self.word()));
        let length = length.filter(|n| *n <= bytes.len()).ok_or("its blocks are cut off")?;
        let (heading, blocks_of) = bytes.split_at(length);
        let (size, last) = (self.heading(heading, 1)?, self.heading(heading, 2)?);
        let (mut at, mut plain) = (0_usize, Vec::new());
        for i in 0..blocks {
            let packed = self.heading(heading, 3 + i)?;
            let end = at.checked_add(packed).filter(|end| *end <= blocks_of.len());
            let block = &blocks_of[at..end.ok_or("its blocks are cut off")?];
            let wanted = if i + 1 == blocks && last > 0 { last } else { size };
            if wanted > block.len().saturating_mul(LARGEST_RATIO) {
                return Err("its blocks claim to be larger than they can be".into());
            }
            let before = plain.len();
            let read = ZlibDecoder::new(block).take(wanted as u64 + 1).read_to_end(&mut plain);
            if read.is_err() || plain.len() - before != wanted {
                return Err(format!("block {i} of its compressed data is damaged"));
            }
            at += packed;
        }
        Ok(Cow::Owned(plain))
    }

    /// The same of base64.
    pub fn base64(&self, text: &[u8]) -> Said<Vec<u8>> {
        let head = decoded(text, self.word() * if self.compressed { 3 } else { 1 })?;
        let wanted = match self.compressed {
            false => self.word().checked_add(self.heading(&head, 0)?),
            true => {
                let blocks = self.heading(&head, 0)?;
                if blocks == 0 {
                    return Ok(Vec::new());
                }
                let length = blocks.checked_add(3).and_then(|n| n.checked_mul(self.word()));
                let heading = decoded(text, length.ok_or("has too many bytes")?)?;
                let sizes = (0..blocks).map(|i| self.heading(&heading, 3 + i));
                let sizes = sizes.collect::<Said<Vec<_>>>()?.into_iter();
                sizes.fold(length, |sum, size| sum?.checked_add(size))
            }
        };
        let bytes = decoded(text, wanted.ok_or("has too many bytes")?)?;
        self.raw(&bytes).map(Cow::into_owned)
    }
}

/// At least the first `wanted` bytes of base64, if there are as many. Padding may stand within the text.
fn decoded(text: &[u8], wanted: usize) -> Said<Vec<u8>> {
    let wrong = || "is not base64".to_owned();
    let text = text.trim_ascii();
    let mut bytes = Vec::new();
    let mut rest = text;
    while bytes.len() < wanted && !rest.is_empty() {
        let groups = (wanted - bytes.len()).div_ceil(3).saturating_mul(4).min(rest.len());
        let part = &rest[..groups];
        // Up to the end of a segment.
        let padding = part.iter().position(|&b| b == b'=');
        let part = match padding {
            Some(at) => rest.get(..at.next_multiple_of(4).max(4)).ok_or_else(wrong)?,
            None => part,
        };
        bytes.extend(STANDARD.decode(part).map_err(|_| wrong())?);
        rest = &rest[part.len()..];
    }
    Ok(bytes)
}
