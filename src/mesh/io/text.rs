//! The tokens of a text file, line by line.
//!
//! Lines end with LF, CRLF or CR, a leading byte order mark is skipped, and tokens are separated by blanks. Numbers are
//! parsed by the standard library: it rounds correctly (Eisel-Lemire, like the specialized crates), is fast enough here
//! (a third of the reading time of an OBJ file), and saves a dependency.

use std::path::Path;

use super::check_coordinate;
use crate::error::{Error, Result};

/// Written by some editors at the start of a text.
pub const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Whether a byte is a blank or a line end.
const ENDS_TOKEN: [bool; 256] = {
    let mut ends = [false; 256];
    let blanks = b" \t\n\r\x0b\x0c";
    let mut i = 0;
    while i < blanks.len() {
        ends[blanks[i] as usize] = true;
        i += 1;
    }
    ends
};

/// A position in a text. Before the first call of [`Text::next_line`], it is before the first line.
pub struct Text<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    started: bool,
    /// The byte that starts a comment, which extends to the end of the line.
    comment: Option<u8>,
    /// Whether a backslash at the end of a line joins it with the next one.
    continued: bool,
    /// The beginning of comments that are not skipped.
    remark: Option<&'static [u8]>,
}

impl<'a> Text<'a> {
    pub fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Text {
            path,
            bytes: bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes),
            at: 0,
            line: 0,
            started: false,
            comment: None,
            continued: false,
            remark: None,
        }
    }

    /// Continues the line numbers of a text with the given number of lines.
    pub fn behind(mut self, lines: usize) -> Self {
        self.line = lines;
        self
    }

    pub fn with_comments(mut self) -> Self {
        self.comment = Some(b'#');
        self
    }

    pub fn with_continued_lines(mut self) -> Self {
        self.continued = true;
        self
    }

    /// Comments that begin like this are not skipped; see [`Text::remark`].
    pub fn with_remarks(mut self, beginning: &'static [u8]) -> Self {
        self.remark = Some(beginning);
        self
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::malformed_line(self.path, self.line.max(1), message)
    }

    /// The current line, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// An upper bound on the number of unread bytes.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The length of the line end at `at`: 0 if there is none.
    fn newline(&self, at: usize) -> usize {
        match self.bytes.get(at) {
            Some(b'\n') => 1,
            Some(b'\r') if self.bytes.get(at + 1) == Some(&b'\n') => 2,
            Some(b'\r') => 1,
            _ => 0,
        }
    }

    /// Moves to the next token of the current line; false if there is none.
    #[inline]
    fn skip_blanks(&mut self) -> bool {
        while let Some(&b) = self.bytes.get(self.at) {
            match b {
                b' ' | b'\t' | b'\x0b' | b'\x0c' => self.at += 1,
                b'\n' | b'\r' => return false,
                b'\\' if self.continued && self.newline(self.at + 1) > 0 => {
                    self.at += 1 + self.newline(self.at + 1);
                    self.line += 1;
                }
                b => return Some(b) != self.comment,
            }
        }
        false
    }

    /// The next token of the current line.
    #[inline]
    pub fn token(&mut self) -> Option<&'a [u8]> {
        if !self.skip_blanks() {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest
            .iter()
            .position(|&b| ENDS_TOKEN[b as usize] || Some(b) == self.comment)
            .unwrap_or(rest.len());
        let mut token = &rest[..length];
        if self.continued && token.last() == Some(&b'\\') && self.newline(self.at + length) > 0 {
            token = &token[..length - 1];
        }
        self.at += token.len();
        Some(token)
    }

    /// Moves to the next token on any line; false at the end of the text.
    #[inline]
    pub fn seek_token(&mut self) -> bool {
        (self.started && self.skip_blanks()) || self.next_line()
    }

    /// The rest of the current line, including blanks within it. It may contain the comment character, as in the
    /// material name "Material #25".
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        self.at += length;
        rest[..length].trim_ascii()
    }

    fn at_remark(&self) -> bool {
        self.remark.is_some_and(|beginning| self.bytes[self.at..].starts_with(beginning))
    }

    /// The text of a remark after its beginning, if the current line is one and none of its tokens was read.
    pub fn remark(&mut self) -> Option<&'a [u8]> {
        if !self.at_remark() {
            return None;
        }
        self.at += self.remark.map_or(0, <[u8]>::len);
        Some(self.rest_of_line())
    }

    /// Moves to the next line that has a token or is a remark; false at the end of the text.
    #[inline]
    pub fn next_line(&mut self) -> bool {
        if self.started {
            self.finish_line();
        }
        self.started = true;
        self.line += 1;
        while self.at < self.bytes.len() {
            if self.skip_blanks() || self.at_remark() {
                return true;
            }
            self.finish_line();
            self.line += 1;
        }
        false
    }

    /// Moves past the end of the current line.
    fn finish_line(&mut self) {
        if self.continued {
            while self.token().is_some() {}
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n' || b == b'\r');
        self.at += length.unwrap_or(rest.len());
        self.at += self.newline(self.at);
    }

    /// The next token of the line; fails if there is none.
    pub fn expect_token(&mut self, what: &str) -> Result<&'a [u8]> {
        self.token().ok_or_else(|| self.error(format!("{what} is missing")))
    }

    /// Fails if the line has another token.
    pub fn expect_end_of_line(&mut self) -> Result<()> {
        match self.token() {
            None => Ok(()),
            Some(token) => Err(self.error(format!("unexpected {}", quote(token)))),
        }
    }

    pub fn number(&mut self, what: &str) -> Result<f64> {
        let token = self.expect_token(what)?;
        self.number_of(token, what)
    }

    /// A token of this line as a number; it may be NaN or infinite.
    pub fn number_of(&self, token: &[u8], what: &str) -> Result<f64> {
        parse_float(token)
            .ok_or_else(|| self.error(format!("expected {what}, a number, not {}", quote(token))))
    }

    /// A coordinate: finite and not too large, see [`check_coordinate`].
    #[inline]
    pub fn coordinate(&mut self) -> Result<f64> {
        let x = self.number("a coordinate")?;
        check_coordinate(x).map_err(|message| self.error(message))
    }

    pub fn integer(&mut self, what: &str) -> Result<i64> {
        let token = self.expect_token(what)?;
        self.integer_of(token, what)
    }

    /// A token of this line as a whole number.
    #[inline]
    pub fn integer_of(&self, token: &[u8], what: &str) -> Result<i64> {
        parse_integer(token).ok_or_else(|| {
            self.error(format!("expected {what}, a whole number, not {}", quote(token)))
        })
    }
}

/// A decimal number; also NaN and infinity, which the caller must refuse.
#[inline]
pub fn parse_float(token: &[u8]) -> Option<f64> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// A decimal integer, with an optional sign.
#[inline]
pub fn parse_integer(token: &[u8]) -> Option<i64> {
    // Fast path: nearly all numbers are indices of a few digits.
    if token.len() <= 15 && !token.is_empty() && token.iter().all(u8::is_ascii_digit) {
        return Some(token.iter().fold(0, |n, b| 10 * n + i64::from(b - b'0')));
    }
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// A name in a file: UTF-8, or one byte per character as older programs write it.
pub fn decode(name: &[u8]) -> String {
    match std::str::from_utf8(name) {
        Ok(name) => name.to_owned(),
        Err(_) => name.iter().copied().map(char::from).collect(),
    }
}

/// A file name in a file, without quotes and with the path separators of this system.
pub fn file_name(name: &[u8]) -> String {
    let name = name.trim_ascii();
    let unquoted = name.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\""));
    decode(unquoted.unwrap_or(name)).replace('\\', "/")
}

/// A name without a trailing comment.
pub fn without_comment(name: &[u8]) -> &[u8] {
    let comment = name.windows(2).position(|pair| pair[0].is_ascii_whitespace() && pair[1] == b'#');
    name[..comment.unwrap_or(name.len())].trim_ascii_end()
}

/// A quotation from the file for a message: short and on one line.
pub fn quote(token: &[u8]) -> String {
    const LONGEST_QUOTE: usize = 32;
    let shown = String::from_utf8_lossy(&token[..token.len().min(LONGEST_QUOTE)]);
    let ellipsis = if token.len() > LONGEST_QUOTE { "..." } else { "" };
    format!("\"{}{ellipsis}\"", shown.escape_debug())
}
