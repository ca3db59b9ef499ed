//! What can be wrong with the outside world: files, their contents, and requests that do not fit them.
//!
//! A caller's mistake is an `assert!`; what the mathematics did is a [`Status`](crate::run::Status);
//! only outside input that is wrong is an [`Error`]. Each prints as one line that names the file, the
//! place in it and, where there is one, the way out.

use std::io;
use std::path::{Path, PathBuf};

use crate::format_error::FormatError;

pub type Result<T> = std::result::Result<T, Error>;

#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{}: {source}", on_one_line(path))]
    Io { path: PathBuf, source: io::Error },
    /// The file can be read, but not as what it claims to be.
    #[error("{}: {message}", on_one_line(path))]
    Malformed { path: PathBuf, message: String },
    /// The same, with the line (counted from 1) of a text file.
    #[error("{}, line {line}: {message}", on_one_line(path))]
    MalformedLine { path: PathBuf, line: usize, message: String },
    /// Well-formed input that does not fit what was asked.
    #[error("{0}")]
    Unsuitable(String),
    /// An experiment file that asks for what is not there.
    #[error(transparent)]
    Format(#[from] Box<FormatError>),
}

impl Error {
    pub fn io(path: &Path, source: io::Error) -> Self {
        Error::Io { path: path.to_owned(), source }
    }

    pub fn malformed(path: &Path, message: impl Into<String>) -> Self {
        Error::Malformed { path: path.to_owned(), message: message.into() }
    }

    pub fn malformed_line(path: &Path, line: usize, message: impl Into<String>) -> Self {
        Error::MalformedLine { path: path.to_owned(), line, message: message.into() }
    }

    pub fn unsuitable(message: impl Into<String>) -> Self {
        Error::Unsuitable(message.into())
    }

    /// Puts the name of the file in front of what is wrong with its content.
    pub fn of_file(self, path: &Path) -> Self {
        match self {
            Error::Unsuitable(message) => Error::malformed(path, message),
            other => other,
        }
    }
}

/// A path for a message: its control characters, which may be line ends, are escaped.
fn on_one_line(path: &Path) -> String {
    let mut shown = String::new();
    for c in path.to_string_lossy().chars() {
        if c.is_control() {
            shown.extend(c.escape_debug());
        } else {
            shown.push(c);
        }
    }
    shown
}
