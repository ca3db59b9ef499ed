//! The progress of a reconstruction, and its interruption.

use std::ops::ControlFlow;
use std::time::Instant;

use crate::evolve::{Plan, Step};

use crate::cli::interrupt;
use crate::cli::progress::Progress;

/// A level takes about this many times as long as the one before: it has four times the faces and pixels.
const GROWTH: f64 = 4.0;

/// The steps so far.
pub struct Steps {
    progress: Progress,
    begin: Instant,
    /// When the level began, its number and its first step.
    level: (Instant, usize, usize),
    steps: usize,
    levels: usize,
    /// The last distance to the truth.
    pub distance: Option<f64>,
}

impl Steps {
    pub fn new(plan: &Plan) -> Self {
        let now = Instant::now();
        Steps {
            progress: Progress::new(0.0),
            begin: now,
            level: (now, 0, 0),
            steps: plan.steps,
            levels: plan.levels,
            distance: None,
        }
    }

    /// Shows a step now and then.
    pub fn observe(&mut self, step: &Step) -> ControlFlow<()> {
        if step.level != self.level.1 {
            self.level = (Instant::now(), step.level, step.step);
        }
        let (begin, level, first) = self.level;
        let made = step.step + 1 - first;
        let per_step = begin.elapsed().as_secs_f64() / made as f64;
        let later: f64 =
            (1..self.levels - level).map(|i| GROWTH.powi(i as i32) * self.steps as f64).sum();
        let left = per_step * ((self.steps - made.min(self.steps)) as f64 + later);
        let distance = self
            .distance
            .map_or(String::new(), |distance| format!(", distance {:.3} %", 100.0 * distance));
        let levels = self.levels;
        self.progress.show(|elapsed| {
            format!(
                "level {} of {levels}, step {made}, energy {:.5e}{distance}, {elapsed:.0} s, at most {left:.0} s left",
                level + 1,
                step.energy
            )
        });
        self.interrupted()
    }

    pub fn interrupted(&self) -> ControlFlow<()> {
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    pub fn seconds(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    pub fn finish(&self) {
        self.progress.finish();
    }
}
