//! The bytes of a file, taken from the front. Counts are compared with the bytes there are before they are believed.

use std::path::Path;

use crate::counted::counted;
use crate::error::{Error, Result};

/// The rest of a file.
pub struct Bytes<'a> {
    path: &'a Path,
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Bytes { path, rest: bytes }
    }

    /// The bytes behind a beginning, or `None` if the file does not begin like this.
    pub fn behind(path: &'a Path, bytes: &'a [u8], beginning: &[u8]) -> Option<Self> {
        Some(Bytes::new(path, bytes.strip_prefix(beginning)?))
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::malformed(self.path, message)
    }

    /// The next n bytes.
    pub fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8]> {
        match self.rest.split_at_checked(n) {
            Some((taken, rest)) => {
                self.rest = rest;
                Ok(taken)
            }
            None => Err(self.error(format!("ends within {what}"))),
        }
    }

    /// n records of N bytes each.
    pub fn records<const N: usize>(&mut self, n: usize, what: &str) -> Result<&'a [[u8; N]]> {
        let length = n.checked_mul(N).filter(|&length| length <= self.rest.len());
        let length = length.ok_or_else(|| {
            let there = self.rest.len() / N;
            self.error(format!("is truncated: it declares {n} {what}, and has room for {there}"))
        })?;
        Ok(self.take(length, what)?.as_chunks().0)
    }

    pub fn int(&mut self, what: &str) -> Result<i32> {
        let bytes = self.take(4, what)?;
        Ok(bytes.iter().fold(0, |number, &byte| number << 8 | i32::from(byte)))
    }

    /// A number that is not negative.
    pub fn count(&mut self, what: &str) -> Result<usize> {
        let n = self.int(what)?;
        usize::try_from(n).map_err(|_| self.error(format!("{n} is not a number of {what}")))
    }

    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Fails if anything but zeros and blanks is left: otherwise a count that is too low would pass for a smaller mesh.
    pub fn finish(&self) -> Result<()> {
        match self.rest.iter().all(|&b| b == 0 || b.is_ascii_whitespace()) {
            true => Ok(()),
            false => {
                let left = counted(self.rest.len(), "byte follows", "bytes follow");
                Err(self.error(format!("{left} the declared content; its counts are wrong")))
            }
        }
    }

    /// Skips a line.
    pub fn line(&mut self) -> Result<()> {
        match self.rest.iter().position(|&b| b == b'\n') {
            Some(length) => self.take(length + 1, "its comment").map(drop),
            None => Err(self.error("ends within its comment")),
        }
    }
}
