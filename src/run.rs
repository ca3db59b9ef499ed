//! The only loop and the only clock: runs a solver, evaluates what it reaches, and decides when to stop.
//!
//! Every sample carries the exact energy E(U), a true lower bound D(q), and their gap, which is relative to E - B, see
//! `problem.rs`. The best of each is kept apart: the best U may come from another iteration than the best bound, and
//! no bound is less than B. After [`STEPS_BEFORE_CONSTANT`] steps the best labels that are constant on every component
//! count as seen, on the clock; see `constant.rs`. Metrics are evaluated off the clock.
//!
//! A bound above an energy, by more than rounding allows, proves a fault of the program: it is kept as it is, and the
//! run ends as [`Status::Contradicted`].

mod end;
mod foreign;
mod sample;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

pub use end::{Status, Stop, time_limit};
pub use foreign::Reached;
pub use sample::{Certificate, Sample};

use crate::constant::Constant;
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::{Problem, relative_gap};
use crate::solver::Solver;
use crate::sweep;

/// Steps between the first samples.
pub const FIRST_INTERVAL: u64 = 4;

/// Steps for the same costs after which constant labels are tried, if nothing better was seen.
pub const STEPS_BEFORE_CONSTANT: u64 = 100;

/// Up to so many vertices: a factorization takes about a second for 200,000.
const MOST_VERTICES_FACTORED: usize = 250_000;

/// The state of one run; resumable.
pub struct Run<const M: usize> {
    /// The samples so far, in the order of their iterations.
    pub trace: Vec<Sample>,
    best_u: Vec<Row<M>>,
    /// Above B, as all energies of a problem.
    best_energy: f64,
    best_bound: f64,
    /// The field of the best bound, if it is kept; empty for the bound B, which is that of q = 0.
    best_q: Option<Vec<Tangent<M>>>,
    clock: Duration,
    /// What time it is: a field, so that tests can say.
    now: fn() -> Instant,
    iteration: u64,
    /// When constant labels are tried.
    constant_from: u64,
}

impl<const M: usize> Run<M> {
    /// A run that has not started. `start` is what it returns if nothing better is ever seen.
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
            constant_from: STEPS_BEFORE_CONSTANT,
        }
    }

    /// Keeps the dual field of the best bound from now on, see [`Run::best_q`].
    pub fn keep_dual(&mut self) {
        self.best_q = Some(Vec::new());
    }

    /// The q of [`Run::bound`], if it is kept; empty where that is the bound of q = 0.
    pub fn best_q(&self) -> Option<&[Tangent<M>]> {
        self.best_q.as_deref()
    }

    /// The U with the least energy seen for the current costs.
    pub fn best_u(&self) -> &[Row<M>] {
        &self.best_u
    }

    /// Its energy above B.
    pub fn energy(&self) -> f64 {
        self.best_energy
    }

    /// The greatest lower bound seen for the current costs, above B.
    pub fn bound(&self) -> f64 {
        self.best_bound
    }

    /// Steps so far, over all calls of [`Run::advance`].
    pub fn iterations(&self) -> u64 {
        self.iteration
    }

    /// Wall time in steps, in seconds, and what was [charged](Run::charge).
    pub fn seconds(&self) -> f64 {
        self.clock.as_secs_f64()
    }

    /// Counts time that was spent before the first step.
    pub fn charge(&mut self, spent: Duration) {
        self.clock += spent;
    }

    /// The costs changed: energies and bounds seen so far are those of another problem.
    pub fn forget(&mut self) {
        self.best_energy = f64::INFINITY;
        self.best_bound = 0.0;
        self.best_q.iter_mut().for_each(Vec::clear);
        self.constant_from = self.iteration + STEPS_BEFORE_CONSTANT;
    }

    /// Steps until `stop` says so, or `observe` breaks off. It is asked between the passes of the solver, and with each
    /// sample that does not end the run.
    pub fn advance<K: Operator>(
        &mut self,
        solver: &mut dyn Solver<K, M>,
        problem: &Problem<K, M>,
        stop: &Stop,
        observe: &mut dyn FnMut(Option<&Sample>) -> ControlFlow<()>,
    ) -> Status {
        let begin = (self.now)();
        let end = stop.iterations.map_or(u64::MAX, |n| self.iteration.saturating_add(n));
        if self.best_energy == f64::INFINITY
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
            let mut aside = Duration::ZERO;
            let tick = (self.now)();
            self.iteration += solver.advance(problem, steps, &mut || {
                let asked = (self.now)();
                if stop.time.is_some_and(|limit| asked - begin >= limit) {
                    ended = Some(Status::TimeLimit);
                } else if !first_pass && observe(None).is_break() {
                    ended = Some(Status::Interrupted);
                }
                first_pass = false;
                aside += (self.now)() - asked;
                ended.is_none()
            });
            self.clock += (self.now)() - tick - aside;
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
            let foretold = stop.relative_gap.and_then(|tolerance| self.foretold(tolerance));
            let most = whole(self.iteration / 4).max(2 * FIRST_INTERVAL);
            let wanted = whole(foretold.unwrap_or(0).min(most) + FIRST_INTERVAL / 2);
            wanted.max(whole(self.iteration / 25)).max(FIRST_INTERVAL)
        });
        self.iteration + interval.max(1)
    }

    /// Steps to the tolerance at the rate of the last two samples. Rates fall, so that it is rarely too much.
    fn foretold(&self, tolerance: f64) -> Option<u64> {
        let [.., before, now] = &self.trace[..] else { return None };
        let steps = (now.iteration - before.iteration) as f64;
        let rate = (before.relative_gap / now.relative_gap).ln() / steps;
        let needed = (now.relative_gap / tolerance).ln() / rate;
        (rate > 0.0).then_some(needed as u64)
    }

    /// Labels that are constant on every component, where no better ones were seen.
    fn try_constant<K: Operator>(&mut self, problem: &Problem<K, M>) {
        if problem.k.vertices() > MOST_VERTICES_FACTORED {
            return;
        }
        let constant = Constant::new(problem);
        let labels = constant.labels();
        let energy = problem.energy(&labels);
        if energy <= self.best_energy {
            self.best_energy = energy;
            sweep::copy_over(&mut self.best_u, &labels);
            if let Some(q) = constant.field(problem) {
                self.see_bound(problem.dual_bound(&q), || q);
            }
        }
    }

    /// Evaluates the current iterate; says how the run ends if it does.
    fn sample<K: Operator>(
        &mut self,
        solver: &mut dyn Solver<K, M>,
        problem: &Problem<K, M>,
        change: Option<f64>,
        stop: &Stop,
    ) -> Option<Status> {
        let smoothing = solver.smoothing();
        let bound = solver.dual_bound(problem);
        self.see_bound(bound, || sweep::copy(solver.iterate().q));
        let u = solver.labels();
        let energy = self.see(problem, u);
        if self.iteration >= self.constant_from {
            self.constant_from = u64::MAX;
            let tick = (self.now)();
            self.try_constant(problem);
            self.clock += (self.now)() - tick;
        }
        let smoothed =
            smoothing.map(|smoothing| problem.baseline + problem.smoothed_energy(u, smoothing));
        let relative_gap = self.note(problem, change, smoothed, None);
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
        } else {
            None
        }
    }

    /// Keeps what is better than all before, and returns the energy.
    fn see<K: Operator>(&mut self, problem: &Problem<K, M>, u: &[Row<M>]) -> f64 {
        let energy = problem.energy(u);
        if energy < self.best_energy {
            self.best_energy = energy;
            sweep::copy_over(&mut self.best_u, u);
        }
        energy
    }

    /// The same of a bound, and of its field where that is kept.
    fn see_bound(&mut self, bound: f64, q: impl FnOnce() -> Vec<Tangent<M>>) {
        if bound > self.best_bound {
            self.best_bound = bound;
            if let Some(best_q) = &mut self.best_q {
                *best_q = q();
            }
        }
    }

    /// Whether the best bound exceeds the best energy; what rounding puts between them is taken away before.
    pub fn is_contradicted(&self) -> bool {
        self.best_bound > self.best_energy
    }

    /// Adds to the trace, and returns the relative gap.
    fn note<K: Operator>(
        &mut self,
        problem: &Problem<K, M>,
        change: Option<f64>,
        smoothed_energy: Option<f64>,
        certificate: Option<Certificate>,
    ) -> f64 {
        self.best_bound = problem.settled(self.best_energy, self.best_bound);
        let relative_gap = relative_gap(self.best_energy, self.best_bound);
        let baseline = problem.baseline;
        // The first sample after the costs changed takes the place of the last one before.
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
