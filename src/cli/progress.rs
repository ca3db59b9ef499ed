//! The progress of a run on stderr, which Ctrl-C breaks off.
//!
//! On a terminal one line that renews itself; elsewhere a line now and then.

use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use meshseg::run::Sample;

use super::{interrupt, note, table};

/// Between renewals of the line on a terminal.
const RENEWAL_INTERVAL: Duration = Duration::from_millis(100);
/// Between lines elsewhere.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

pub struct Progress {
    line: Option<ProgressBar>,
    begin: Instant,
    shown: Instant,
    tolerance: f64,
    /// What the lines begin with.
    title: String,
    /// Time and gap of the first sample of the current costs: where the remaining time is judged from.
    origin: Option<(f64, f64)>,
}

impl Progress {
    /// Starts to listen for Ctrl-C. `tolerance` is the gap that is aimed at.
    pub fn new(tolerance: f64) -> Self {
        interrupt::keep_results();
        let line = stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}").expect("a valid template");
            ProgressBar::new_spinner().with_style(style)
        });
        let now = Instant::now();
        Progress { line, begin: now, shown: now, tolerance, title: String::new(), origin: None }
    }

    /// Another run begins.
    pub fn title(&mut self, title: String) {
        (self.begin, self.origin) = (Instant::now(), None);
        if let Some(line) = &self.line {
            line.set_message(title.clone());
            line.tick();
        }
        self.title = title + ": ";
    }

    /// For [`meshseg::run::Run::advance`].
    pub fn observe(&mut self, sample: Option<&Sample>) -> ControlFlow<()> {
        if let Some(sample) = sample {
            let interval = if self.line.is_some() { RENEWAL_INTERVAL } else { LINE_INTERVAL };
            if self.shown.elapsed() >= interval {
                self.shown = Instant::now();
                let message = self.message(sample);
                match &self.line {
                    Some(line) => {
                        line.set_message(message);
                        line.tick();
                    }
                    None => note(&message),
                }
            }
        }
        if interrupt::came() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
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
        // The gap falls by a constant factor per second, more or less.
        let rate = (first / gap).ln() / (elapsed - from);
        let left = (gap / self.tolerance).ln() / rate;
        let left = if left.is_finite() && left >= 0.0 {
            format!(", about {left:.0} s left")
        } else {
            String::new()
        };
        format!(
            "{}iteration {}, energy {}, gap {gap:.1e} (to {:.0e}), {elapsed:.0} s{left}",
            self.title,
            sample.iteration,
            table::number(sample.energy),
            self.tolerance
        )
    }
}
