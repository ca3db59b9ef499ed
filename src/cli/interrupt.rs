//! Ctrl-C and other signals to terminate.
//!
//! The program ends at once with exit code 130 and leaves no incomplete files. During a run that can keep its results
//! so far, the first signal ends the run and only a second one the program.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::file;

/// Whether a run polls [`requested`].
static KEEPS_RESULTS: AtomicBool = AtomicBool::new(false);
static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler; to be called before any verb runs.
pub fn listen() {
    let listening = ctrlc::set_handler(|| {
        let again = REQUESTED.swap(true, Ordering::Relaxed);
        if again || !KEEPS_RESULTS.load(Ordering::Relaxed) {
            file::abandon();
            process::exit(130);
        }
    });
    if let Err(error) = listening {
        tracing::warn!("Ctrl-C will end the program without saving results: {error}");
    }
}

/// From now on a run polls [`requested`] regularly.
pub fn keep_results() {
    KEEPS_RESULTS.store(true, Ordering::Relaxed);
}

/// Whether a signal has arrived.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
