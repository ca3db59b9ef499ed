//! What is wrong with a file, and the span of it that is, so that it can be shown where it stands.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use crate::one_line::one_line;

/// What is wrong with an experiment file, and where.
#[derive(Debug)]
pub struct Misfit {
    pub path: PathBuf,
    pub text: String,
    /// Bytes of `text`.
    pub span: Range<usize>,
    pub message: String,
}

impl Misfit {
    /// Line and column, counted from 1.
    pub fn position(&self) -> (usize, usize) {
        let before = &self.text[..self.span.start];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |line| line.chars().count()) + 1;
        (line, column)
    }
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (line, column) = self.position();
        let path = one_line(&self.path.display().to_string());
        write!(f, "{path}, line {line}, column {column}: {}", self.message)
    }
}

impl std::error::Error for Misfit {}
