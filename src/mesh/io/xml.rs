//! The part of XML that GIFTI and VTK use, read piece by piece: elements, attributes, text.
//!
//! ```text
//! <?xml ...?> <!DOCTYPE GIFTI ...> <!-- ... -->      skipped
//! <name key="value" ...> ... </name>   <name .../>   elements
//! text &lt; &#60; &#x3c; <![CDATA[text]]>            text, with references to characters
//! ```
//!
//! We use our own reader: roxmltree 0.20 calls itself for every level of nesting, so that a file of a few kilobytes
//! exhausts the stack, takes quadratic time for many attributes or pieces of text, and expands entities. This one takes
//! linear time and keeps only the names of open elements. It knows no entities but the five of XML, and refuses
//! files that declare others. Texts are bytes, since some programs write names in Latin-1.
//!
//! Reference: W3C, *Extensible Markup Language (XML) 1.0*, fifth edition, 2008.

use std::borrow::Cow;
use std::path::Path;

use crate::error::{Error, Result};
use crate::mesh::io::text::{BYTE_ORDER_MARK, decode, quote};

/// A position in a file.
pub struct Xml<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    /// The names of the elements around this position.
    open: Vec<&'a [u8]>,
    /// Whether the innermost element was written as `<name/>`, so that it ends here.
    ends: bool,
}

/// The start of an element.
pub struct Tag<'a> {
    pub name: &'a [u8],
    attributes: &'a [u8],
}

/// What may follow a position.
enum Piece<'a> {
    Start(Tag<'a>),
    End,
    /// With references.
    Text(&'a [u8]),
    /// As it is.
    Literal(&'a [u8]),
}

impl<'a> Xml<'a> {
    pub fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        Xml { path, bytes, at: 0, open: Vec::new(), ends: false }
    }

    /// An error at this position.
    pub fn error(&self, message: impl Into<String>) -> Error {
        let line = 1 + self.bytes[..self.at].iter().filter(|&&b| b == b'\n').count();
        Error::malformed_line(self.path, line, message)
    }

    /// Enters the next element within the current one, or returns `None` and leaves the current one at its end.
    pub fn child(&mut self) -> Result<Option<Tag<'a>>> {
        loop {
            match self.next()? {
                Piece::Start(tag) => return Ok(Some(tag)),
                Piece::End => return Ok(None),
                Piece::Text(_) | Piece::Literal(_) => {}
            }
        }
    }

    /// The text of the current element, which is left; that of elements within it is skipped.
    pub fn text(&mut self) -> Result<Cow<'a, [u8]>> {
        let mut all = Cow::Borrowed(&b""[..]);
        loop {
            let piece = match self.next()? {
                Piece::Start(_) => {
                    self.skip()?;
                    continue;
                }
                Piece::End => return Ok(all),
                Piece::Text(raw) => resolved(raw),
                Piece::Literal(text) => Cow::Borrowed(text),
            };
            match all.is_empty() {
                true => all = piece,
                false => all.to_mut().extend_from_slice(&piece),
            }
        }
    }

    /// Leaves the current element.
    pub fn skip(&mut self) -> Result<()> {
        let outside = self.open.len().saturating_sub(1);
        while self.open.len() > outside {
            self.next()?;
        }
        Ok(())
    }

    /// Fails if anything but blanks, zeros and comments follows the outermost element.
    pub fn finish(&mut self) -> Result<()> {
        loop {
            let rest = &self.bytes[self.at..];
            let blank = rest.iter().take_while(|&&b| b == 0 || b.is_ascii_whitespace()).count();
            self.at += blank;
            if blank == rest.len() {
                return Ok(());
            }
            if !rest[blank..].starts_with(b"<!--") {
                return Err(self.error("the file continues after its outermost element"));
            }
            self.pass(b"-->")?;
        }
    }

    fn next(&mut self) -> Result<Piece<'a>> {
        if std::mem::take(&mut self.ends) {
            self.open.pop();
            return Ok(Piece::End);
        }
        loop {
            let rest = &self.bytes[self.at..];
            if rest.is_empty() {
                return Err(self.error(match self.open.last() {
                    Some(name) => format!("the file ends within the element {}", quote(name)),
                    None => "the file ends before its first element".to_owned(),
                }));
            }
            if rest[0] != b'<' {
                let length = rest.iter().position(|&b| b == b'<').unwrap_or(rest.len());
                self.at += length;
                return Ok(Piece::Text(&rest[..length]));
            }
            if rest.starts_with(b"<!--") {
                self.pass(b"-->")?;
            } else if rest.starts_with(b"<![CDATA[") {
                return Ok(Piece::Literal(&self.pass(b"]]>")?[b"<![CDATA[".len()..]));
            } else if rest.starts_with(b"<?") {
                self.pass(b"?>")?;
            } else if rest.starts_with(b"<!") {
                if self.pass(b">")?.contains(&b'[') {
                    return Err(self.error("declarations within the file are not supported"));
                }
            } else if rest.starts_with(b"</") {
                return self.end();
            } else {
                return self.start().map(Piece::Start);
            }
        }
    }

    /// Moves behind the next occurrence of an end, and returns what is before it.
    fn pass(&mut self, end: &[u8]) -> Result<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        // The beginning `<!--` must not count as an end `-->`.
        let skipped = rest.len().min(4);
        match rest[skipped..].windows(end.len()).position(|window| window == end) {
            Some(length) => {
                self.at += skipped + length + end.len();
                Ok(&rest[..skipped + length])
            }
            None => Err(self.error(format!("{} does not end", quote(rest)))),
        }
    }

    fn end(&mut self) -> Result<Piece<'a>> {
        let rest = &self.bytes[self.at + 2..];
        let Some(length) = rest.iter().position(|&b| b == b'>') else {
            return Err(self.error("the file ends within a tag"));
        };
        let name = rest[..length].trim_ascii_end();
        match self.open.last() {
            Some(&open) if open == name => {
                self.open.pop();
                self.at += 2 + length + 1;
                Ok(Piece::End)
            }
            Some(open) => {
                Err(self.error(format!("the element {} ends as {}", quote(open), quote(name))))
            }
            None => Err(self.error(format!("the element {} ends but never began", quote(name)))),
        }
    }

    fn start(&mut self) -> Result<Tag<'a>> {
        let rest = &self.bytes[self.at + 1..];
        let mut inside = None;
        let end = rest.iter().position(|&b| {
            match inside {
                Some(mark) if b == mark => inside = None,
                None if matches!(b, b'"' | b'\'') => inside = Some(b),
                _ => {}
            }
            // No value contains the start of a tag.
            b == b'<' || (b == b'>' && inside.is_none())
        });
        let Some(end) = end.filter(|&end| rest[end] == b'>') else {
            return Err(
                self.error(format!("the tag {} does not end", quote(&self.bytes[self.at..])))
            );
        };
        let (tag, ends) = match rest[..end].strip_suffix(b"/") {
            Some(tag) => (tag, true),
            None => (&rest[..end], false),
        };
        let length = tag.iter().position(u8::is_ascii_whitespace).unwrap_or(tag.len());
        let (name, attributes) = tag.split_at(length);
        if name.is_empty() {
            return Err(self.error("a tag has no name"));
        }
        self.at += 1 + end + 1;
        self.ends = ends;
        self.open.push(name);
        Ok(Tag { name, attributes })
    }
}

impl<'a> Tag<'a> {
    /// The value of an attribute, if there is one.
    pub fn get(&self, name: &str) -> Option<String> {
        let mut rest = self.attributes;
        loop {
            let at = rest.iter().position(|&b| b == b'=')?;
            let (key, value) = (rest[..at].trim_ascii(), rest[at + 1..].trim_ascii_start());
            let (&mark, value) = value.split_first()?;
            let length = value.iter().position(|&b| b == mark)?;
            if key == name.as_bytes() {
                return Some(decode(resolved(&value[..length]).trim_ascii()));
            }
            rest = &value[length + 1..];
        }
    }
}

/// A text with the characters that its references stand for. Unknown references stay.
fn resolved(text: &[u8]) -> Cow<'_, [u8]> {
    /// The longest one is `&#1114111;`.
    const LONGEST: usize = 10;
    let Some(first) = text.iter().position(|&b| b == b'&') else { return Cow::Borrowed(text) };
    let (mut all, mut rest) = (text[..first].to_vec(), &text[first..]);
    while let Some(&b) = rest.first() {
        let end = if b == b'&' { rest.iter().take(LONGEST).position(|&b| b == b';') } else { None };
        match end.and_then(|end| Some((end, character(&rest[1..end])?))) {
            Some((end, c)) => {
                all.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
                rest = &rest[end + 1..];
            }
            None => {
                all.push(b);
                rest = &rest[1..];
            }
        }
    }
    Cow::Owned(all)
}

/// The character of a reference, without its `&` and `;`.
fn character(name: &[u8]) -> Option<char> {
    let number = |digits: &str, radix| u32::from_str_radix(digits, radix).ok();
    match std::str::from_utf8(name).ok()? {
        "lt" => Some('<'),
        "gt" => Some('>'),
        "amp" => Some('&'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        name => {
            let digits = name.strip_prefix('#')?;
            let code = match digits.strip_prefix('x') {
                Some(digits) => number(digits, 16),
                None => number(digits, 10),
            };
            char::from_u32(code?)
        }
    }
}
