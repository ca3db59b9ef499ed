//! What a reader leaves out or guesses: counted, so that a million odd lines give one sentence.

use std::path::Path;

use crate::error::Error;

/// How often something happened, and where first.
#[derive(Default)]
pub struct Occurrences {
    count: usize,
    first: String,
}

impl Occurrences {
    /// One more, at that place ("line 7").
    #[inline]
    pub fn add(&mut self, place: impl FnOnce() -> String) {
        if self.count == 0 {
            self.first = place();
        }
        self.count += 1;
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub fn count(&self) -> usize {
        self.count
    }

    /// Says so, if it happened.
    pub fn warn(&self, path: &Path, what: &str) {
        if self.count > 0 {
            warn(path, &format!("{what} ({}, the first: {})", self.count, self.first));
        }
    }
}

/// One sentence about a file, on one line.
pub fn warn(path: &Path, message: &str) {
    tracing::warn!("{}", Error::malformed(path, message));
}
