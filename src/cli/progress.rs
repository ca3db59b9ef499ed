//! The progress of a run on stderr, and its interruption by Ctrl-C.
//!
//! On a terminal this is one line that is updated in place; otherwise a line every few seconds.

use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::run::Sample;

use super::listener::listening;
use super::{interrupt, note, table};

/// Time between updates of the line on a terminal.
const UPDATE_INTERVAL: Duration = Duration::from_millis(100);
/// Time between lines otherwise.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

pub struct Progress {
    line: Option<ProgressBar>,
    begin: Instant,
    shown: Instant,
    tolerance: f64,
    /// Prefix of the lines.
    title: String,
    /// Time and gap of the first sample for the current costs, from which the remaining time is estimated.
    origin: Option<(f64, f64)>,
}

impl Progress {
    /// Also makes Ctrl-C end the run rather than the program. `tolerance` is the target gap.
    pub fn new(tolerance: f64) -> Self {
        let is_listening = || listening(|_| ()).is_some();
        if !is_listening() {
            interrupt::keep_results();
        }
        let line = (stderr().is_terminal() && !is_listening()).then(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}").expect("a valid template");
            ProgressBar::new_spinner().with_style(style)
        });
        let now = Instant::now();
        Progress { line, begin: now, shown: now, tolerance, title: String::new(), origin: None }
    }

    /// Starts the display of another run.
    pub fn title(&mut self, title: String) {
        (self.begin, self.origin) = (Instant::now(), None);
        if let Some(line) = &self.line {
            line.set_message(title.clone());
            line.tick();
        }
        self.title = title + ": ";
    }

    /// The observer for [`crate::run::Run::advance`].
    pub fn observe(&mut self, sample: Option<&Sample>) -> ControlFlow<()> {
        if let Some(flow) = listening(|listener| (listener.observe)(sample)) {
            return flow;
        }
        if let Some(sample) = sample {
            let message = self.is_due().then(|| self.message(sample));
            self.update(message);
        }
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Shows a message now and then; it is made of the seconds so far.
    pub fn show(&mut self, message: impl FnOnce(f64) -> String) {
        let elapsed = self.begin.elapsed().as_secs_f64();
        let message = self.is_due().then(|| message(elapsed));
        self.update(message);
    }

    /// Whether the line is to be updated.
    fn is_due(&self) -> bool {
        let interval = if self.line.is_some() { UPDATE_INTERVAL } else { LINE_INTERVAL };
        self.shown.elapsed() >= interval
    }

    fn update(&mut self, message: Option<String>) {
        let Some(message) = message else { return };
        self.shown = Instant::now();
        match &self.line {
            Some(line) => {
                line.set_message(message);
                line.tick();
            }
            // A program that listens has the samples.
            None if listening(|_| ()).is_some() => {}
            None => note(&message),
        }
    }

    /// Clears the line.
    pub fn finish(&self) {
        if let Some(line) = &self.line {
            line.finish_and_clear();
        }
    }

    fn message(&mut self, sample: &Sample) -> String {
        let elapsed = self.begin.elapsed().as_secs_f64();
        let gap = sample.relative_gap;
        let (from, first) = match self.origin {
            // The gap jumps up when the costs change.
            Some((from, first)) if gap <= first => (from, first),
            _ => *self.origin.insert((elapsed, gap)),
        };
        // The gap decreases by a roughly constant factor per second.
        let rate = (first / gap).ln() / (elapsed - from);
        let left = (gap / self.tolerance).ln() / rate;
        let left = if left.is_finite() && left >= 0.0 {
            format!(", about {left:.0} s left")
        } else {
            String::new()
        };
        format!(
            "{}iteration {}, energy {}, gap {gap:.1e} (target {:.0e}), {elapsed:.0} s{left}",
            self.title,
            sample.iteration,
            table::number(sample.energy),
            self.tolerance
        )
    }
}
