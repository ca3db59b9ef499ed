//! The only loop and the only clock: runs a solver, evaluates its iterates, and decides when to stop.
//!
//! Every sample has the exact energy E(U), a true lower bound D(q), and their gap, relative to E - B; see `problem.rs`.
//! The best U and the best bound are kept separately: they may come from different iterations, and no bound is below B.
//! After [`STEPS_BEFORE_CONSTANT`] steps the best labels that are constant on every component are tried as well, on the
//! clock; see `constant.rs`. Metrics are evaluated off the clock.
//!
//! A bound that exceeds an energy by more than rounding allows proves a fault of the program: it is kept as it is, and
//! the run ends as [`Status::Contradicted`].

mod end;
mod foreign;
mod sample;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

pub use end::{Status, Stop, time_limit};
pub use foreign::Reached;
pub use sample::{Certificate, Sample};

use crate::constant::ConstantLabels;
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::{Problem, relative_gap};
use crate::solver::Solver;
use crate::sweep;

/// Steps between the first samples.
pub const FIRST_INTERVAL: u64 = 4;

/// Number of steps with the same costs after which constant labels are tried.
pub const STEPS_BEFORE_CONSTANT: u64 = 100;

/// Constant labels are tried up to this number of vertices: the factorization takes about a second for 200,000.
const MAX_FACTORED_VERTICES: usize = 250_000;

/// The state of one run; resumable.
pub struct Run<const M: usize> {
    /// The samples so far, by increasing iteration.
    pub trace: Vec<Sample>,
    best_u: Vec<Row<M>>,
    /// E - B of the best U.
    best_energy: f64,
    best_bound: f64,
    /// The dual field of the best bound, if it is kept; empty if the bound is B, that of q = 0.
    best_q: Option<Vec<Tangent<M>>>,
    clock: Duration,
    /// The current time; tests replace it.
    now: fn() -> Instant,
    iteration: u64,
    /// The iteration from which on constant labels are tried.
    try_constant_at: u64,
}

impl<const M: usize> Run<M> {
    /// A run that has not started. `start` is its best U until a better one is found.
    pub fn new(start: &[Row<M>]) -> Self {
        Run {
            trace: Vec::new(),
            best_u: sweep::copy(start),
            best_energy: f64::INFINITY,
            best_bound: 0.0,
            best_q: None,
            clock: Duration::ZERO,
            now: Instant::now,
            iteration: 0,
            try_constant_at: STEPS_BEFORE_CONSTANT,
        }
    }

    /// From now on keeps the dual field of the best bound, see [`Run::best_q`].
    pub fn keep_dual(&mut self) {
        self.best_q = Some(Vec::new());
    }

    /// The dual field of [`Run::bound`], if it is kept; empty if that is the bound of q = 0.
    pub fn best_q(&self) -> Option<&[Tangent<M>]> {
        self.best_q.as_deref()
    }

    /// The U of minimum energy found for the current costs.
    pub fn best_u(&self) -> &[Row<M>] {
        &self.best_u
    }

    /// E - B of [`Run::best_u`].
    pub fn energy(&self) -> f64 {
        self.best_energy
    }

    /// D - B, the largest lower bound found for the current costs.
    pub fn bound(&self) -> f64 {
        self.best_bound
    }

    /// Number of steps so far, over all calls of [`Run::advance`].
    pub fn iterations(&self) -> u64 {
        self.iteration
    }

    /// Wall time of the steps in seconds, including [charged](Run::charge) time.
    pub fn seconds(&self) -> f64 {
        self.clock.as_secs_f64()
    }

    /// Adds time that was spent before the first step.
    pub fn charge(&mut self, spent: Duration) {
        self.clock += spent;
    }

    /// Drops the energies and bounds found so far; to be called when the costs have changed.
    pub fn forget(&mut self) {
        self.best_energy = f64::INFINITY;
        self.best_bound = 0.0;
        self.best_q.iter_mut().for_each(Vec::clear);
        self.try_constant_at = self.iteration + STEPS_BEFORE_CONSTANT;
    }

    /// Advances the solver until `stop` is met or `observe` breaks. `observe` is called between the passes of the
    /// solver, and with each sample that does not end the run.
    pub fn advance<K: Operator>(
        &mut self,
        solver: &mut dyn Solver<K, M>,
        problem: &Problem<K, M>,
        stop: &Stop,
        observe: &mut dyn FnMut(Option<&Sample>) -> ControlFlow<()>,
    ) -> Status {
        let begin = (self.now)();
        let end = stop.iterations.map_or(u64::MAX, |n| self.iteration.saturating_add(n));
        // After the costs have changed, the iterate is a sample only if it may already be good enough, or is the last.
        let at_once = self.trace.is_empty() || stop.relative_gap.is_some() || self.iteration >= end;
        if at_once
            && self.best_energy == f64::INFINITY
            && let Some(status) = self.sample(solver, problem, None, stop)
        {
            return status;
        }
        loop {
            if self.iteration >= end {
                return Status::IterationLimit;
            }
            let steps = self.next_sample(stop).min(end) - self.iteration;
            let (mut ended, mut first_pass) = (None, true);
            let mut off_clock = Duration::ZERO;
            let tick = (self.now)();
            self.iteration += solver.advance(problem, steps, &mut || {
                let paused = (self.now)();
                if stop.time.is_some_and(|limit| paused - begin >= limit) {
                    ended = Some(Status::TimeLimit);
                } else if !first_pass && observe(None).is_break() {
                    ended = Some(Status::Interrupted);
                }
                first_pass = false;
                off_clock += (self.now)() - paused;
                ended.is_none()
            });
            self.clock += (self.now)() - tick - off_clock;
            let change = solver.change();
            if let Some(status) = self.sample(solver, problem, Some(change), stop) {
                return status;
            }
            let flow = observe(self.trace.last());
            match ended {
                Some(status) => return status,
                None if flow.is_break() => return Status::Interrupted,
                None => {}
            }
        }
    }

    fn next_sample(&self, stop: &Stop) -> u64 {
        let interval = stop.interval.unwrap_or_else(|| {
            let whole = |steps: u64| steps / FIRST_INTERVAL * FIRST_INTERVAL;
            let steps_to_gap = stop.relative_gap.and_then(|tolerance| self.steps_to_gap(tolerance));
            let longest = whole(self.iteration / 4).max(2 * FIRST_INTERVAL);
            let wanted = whole(steps_to_gap.unwrap_or(0).min(longest) + FIRST_INTERVAL / 2);
            wanted.max(whole(self.iteration / 25)).max(FIRST_INTERVAL)
        });
        self.iteration + interval.max(1)
    }

    /// Number of steps to the tolerance at the rate of the last two samples. Rates decrease, so it is rarely too large.
    fn steps_to_gap(&self, tolerance: f64) -> Option<u64> {
        let [.., before, now] = &self.trace[..] else { return None };
        let steps = (now.iteration - before.iteration) as f64;
        let rate = (before.relative_gap / now.relative_gap).ln() / steps;
        let needed = (now.relative_gap / tolerance).ln() / rate;
        (rate > 0.0).then_some(needed as u64)
    }

    /// Takes the best constant labels, and their bound, unless better labels are known.
    fn try_constant<K: Operator>(&mut self, problem: &Problem<K, M>) {
        if problem.k.vertices() > MAX_FACTORED_VERTICES {
            return;
        }
        let constant = ConstantLabels::new(problem);
        let labels = constant.labels();
        let energy = problem.energy(&labels);
        if energy <= self.best_energy {
            self.best_energy = energy;
            sweep::copy_over(&mut self.best_u, &labels);
            if let Some(q) = constant.field(problem) {
                self.update_bound(problem.dual_bound(&q), || q);
            }
        }
    }

    /// Evaluates the current iterate; returns the status if the run ends.
    fn sample<K: Operator>(
        &mut self,
        solver: &mut dyn Solver<K, M>,
        problem: &Problem<K, M>,
        change: Option<f64>,
        stop: &Stop,
    ) -> Option<Status> {
        let smoothing = solver.smoothing();
        let bound = solver.dual_bound(problem);
        self.update_bound(bound, || sweep::copy(solver.iterate().q));
        let u = solver.labels();
        let energy = self.update_best(problem, u);
        if self.iteration >= self.try_constant_at {
            self.try_constant_at = u64::MAX;
            let tick = (self.now)();
            self.try_constant(problem);
            self.clock += (self.now)() - tick;
        }
        let smoothed =
            smoothing.map(|smoothing| problem.baseline + problem.smoothed_energy(u, smoothing));
        let relative_gap = self.push_sample(problem, change, smoothed, None);
        if energy.is_nan() || bound.is_nan() {
            Some(Status::Diverged)
        } else if self.is_contradicted() {
            Some(Status::Contradicted)
        } else if stop.relative_gap.is_some_and(|tolerance| relative_gap <= tolerance) {
            Some(Status::Converged)
        } else if let (Some(delta), Some(change)) = (stop.change, change)
            && change <= delta
        {
            Some(Status::Stalled)
        } else if change.is_some() && solver.is_settled() {
            Some(Status::Settled)
        } else {
            None
        }
    }

    /// Keeps U if it is the best so far; returns its energy.
    fn update_best<K: Operator>(&mut self, problem: &Problem<K, M>, u: &[Row<M>]) -> f64 {
        let energy = problem.energy(u);
        if energy < self.best_energy {
            self.best_energy = energy;
            sweep::copy_over(&mut self.best_u, u);
        }
        energy
    }

    /// Keeps a bound, and its field if fields are kept, if it is the best so far.
    fn update_bound(&mut self, bound: f64, q: impl FnOnce() -> Vec<Tangent<M>>) {
        if bound > self.best_bound {
            self.best_bound = bound;
            if let Some(best_q) = &mut self.best_q {
                *best_q = q();
            }
        }
    }

    /// Whether the best bound exceeds the best energy by more than rounding can cause.
    pub fn is_contradicted(&self) -> bool {
        self.best_bound > self.best_energy
    }

    /// Adds a sample to the trace; returns the relative gap.
    fn push_sample<K: Operator>(
        &mut self,
        problem: &Problem<K, M>,
        change: Option<f64>,
        smoothed_energy: Option<f64>,
        certificate: Option<Certificate>,
    ) -> f64 {
        self.best_bound = problem.clamped_bound(self.best_energy, self.best_bound);
        let relative_gap = relative_gap(self.best_energy, self.best_bound);
        let baseline = problem.baseline;
        // The first sample after a change of the costs replaces the last one before it.
        self.trace.pop_if(|last| last.iteration == self.iteration);
        self.trace.push(Sample {
            iteration: self.iteration,
            seconds: self.seconds(),
            energy: baseline + self.best_energy,
            dual_bound: baseline + self.best_bound,
            gap: self.best_energy - self.best_bound,
            relative_gap,
            change,
            smoothed_energy,
            certificate,
        });
        relative_gap
    }
}

#[cfg(test)]
mod tests;
