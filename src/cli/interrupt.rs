//! Ctrl-C, and whatever else asks the program to end.
//!
//! It ends at once, with exit code 130, and leaves nothing half-written. Where a run could keep what it reached, the
//! first signal is for the run and the second ends the program.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use meshseg::file;

/// Whether a run looks at [`came`].
static KEEPS_RESULTS: AtomicBool = AtomicBool::new(false);
static CAME: AtomicBool = AtomicBool::new(false);

/// To be called first of all.
pub fn listen() {
    let listening = ctrlc::set_handler(|| {
        let again = CAME.swap(true, Ordering::Relaxed);
        if again || !KEEPS_RESULTS.load(Ordering::Relaxed) {
            file::abandon();
            process::exit(130);
        }
    });
    if let Err(error) = listening {
        tracing::warn!("Ctrl-C will end the program without results: {error}");
    }
}

/// From now on somebody looks, again and again, whether a signal [`came`].
pub fn keep_results() {
    KEEPS_RESULTS.store(true, Ordering::Relaxed);
}

pub fn came() -> bool {
    CAME.load(Ordering::Relaxed)
}
