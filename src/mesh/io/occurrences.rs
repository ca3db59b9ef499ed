//! Counts of what a reader leaves out or guesses, so that a million such lines cause one warning.

use std::path::Path;

use crate::error::Error;

/// The number of occurrences of a problem, and the location of the first.
#[derive(Default)]
pub struct Occurrences {
    count: usize,
    first: String,
}

impl Occurrences {
    /// Counts one more, at a location such as "line 7".
    #[inline]
    pub fn add(&mut self, location: impl FnOnce() -> String) {
        if self.count == 0 {
            self.first = location();
        }
        self.count += 1;
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub fn count(&self) -> usize {
        self.count
    }

    /// Warns if there are any; `what` describes the problem.
    pub fn warn(&self, path: &Path, what: &str) {
        if self.count > 0 {
            warn(path, &format!("{what} ({}, the first: {})", self.count, self.first));
        }
    }
}

/// A warning about a file, on one line.
pub fn warn(path: &Path, message: &str) {
    tracing::warn!("{}", Error::malformed(path, message));
}
