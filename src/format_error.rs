//! A format error and its position in the file, so that it can be shown next to the text.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use crate::one_line::one_line;

/// A format error in an experiment file.
#[derive(Debug)]
pub struct FormatError {
    /// The file.
    pub path: PathBuf,
    /// The whole content of the file.
    pub text: String,
    /// The bytes of `text` that are wrong; empty where something is missing.
    pub span: Range<usize>,
    /// What is wrong and what to do.
    pub message: String,
}

impl FormatError {
    /// Line and column, counted from 1.
    pub fn position(&self) -> (usize, usize) {
        let before = &self.text[..self.span.start];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |line| line.chars().count()) + 1;
        (line, column)
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (line, column) = self.position();
        let path = one_line(&self.path.display().to_string());
        write!(f, "{path}, line {line}, column {column}: {}", self.message)
    }
}

impl std::error::Error for FormatError {}
