//! Errors of outside input: files, their contents, and requests that do not fit them.
//!
//! A caller's mistake is an `assert!`, a failure of the mathematics is a [`Status`](crate::run::Status), and only bad
//! outside input is an [`Error`]. Each prints as one line that names the file, the position in it and, if there is one,
//! the remedy.

use std::io;
use std::path::{Path, PathBuf};

use crate::format_error::FormatError;

/// A result whose error is an [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// What is wrong with a file or a request. It prints as one line for the user.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system reported an error.
    #[error("{}: {source}", on_one_line(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The file can be read, but not as what it claims to be.
    #[error("{}: {message}", on_one_line(path))]
    Malformed {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it and what to do, without its name.
        message: String,
    },
    /// The same, with the line (counted from 1) of a text file.
    #[error("{}, line {line}: {message}", on_one_line(path))]
    MalformedLine {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong with the line and what to do.
        message: String,
    },
    /// Well-formed input that does not fit the request.
    #[error("{0}")]
    Unsuitable(String),
    /// An experiment file with a wrong key or value.
    #[error(transparent)]
    Format(#[from] Box<FormatError>),
}

impl Error {
    /// The system failed to read or write `path`.
    pub fn io(path: &Path, source: io::Error) -> Self {
        Error::Io { path: path.to_owned(), source }
    }

    /// `path` can be read, but not as what it should be; `message` follows its name.
    pub fn malformed(path: &Path, message: impl Into<String>) -> Self {
        Error::Malformed { path: path.to_owned(), message: message.into() }
    }

    /// The same for one line of a text file, counted from 1.
    pub fn malformed_line(path: &Path, line: usize, message: impl Into<String>) -> Self {
        Error::MalformedLine { path: path.to_owned(), line, message: message.into() }
    }

    /// Input that does not fit the request; `message` is the whole line.
    pub fn unsuitable(message: impl Into<String>) -> Self {
        Error::Unsuitable(message.into())
    }

    /// Prefixes a message about the content of a file with its name.
    pub fn of_file(self, path: &Path) -> Self {
        match self {
            Error::Unsuitable(message) => Error::malformed(path, message),
            other => other,
        }
    }
}

/// A path for a message, its control characters escaped, since they may end the line.
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
