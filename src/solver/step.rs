//! A method, given by its step, and the solver that makes one step after another.

use super::{Iterate, Solver};
use crate::field::Row;
use crate::operator::Operator;
use crate::problem::{Problem, Smoothing};
use crate::sweep;

/// A method. It knows neither when its iterates are sampled nor when the run ends.
pub trait Step<K, const M: usize> {
    /// One iteration; allocates nothing (except the workspace of solves with a factorization).
    fn step(&mut self, problem: &Problem<K, M>);

    /// The iteration before a sample, which ends with a feasible pair. It differs from `step` if iterates are
    /// infeasible or poor in between, as those of an over-relaxed method are.
    fn last_step(&mut self, problem: &Problem<K, M>) {
        self.step(problem);
    }

    /// The pair at the start and after a last step: a feasible U, with rows in the simplex, and a feasible dual field.
    fn iterate(&self) -> Iterate<'_, M>;

    /// See [`Solver::restart`].
    fn restart(&mut self, _problem: &Problem<K, M>) {}

    /// See [`Solver::follow`].
    fn follow(&mut self, problem: &Problem<K, M>) {
        self.restart(problem);
    }

    /// See [`Solver::is_settled`].
    fn is_settled(&self) -> bool {
        false
    }

    /// See [`Solver::smoothing`].
    fn smoothing(&self) -> Option<Smoothing> {
        None
    }
}

/// The solver that makes the steps of a method one by one.
pub struct OneByOne<S, const M: usize> {
    method: S,
    /// u^{n-1}, for the last step n; empty before the first.
    previous: Vec<Row<M>>,
}

impl<S, const M: usize> OneByOne<S, M> {
    /// A solver that has made no step yet.
    pub fn new(method: S) -> Self {
        OneByOne { method, previous: Vec::new() }
    }
}

impl<K: Operator, S: Step<K, M>, const M: usize> Solver<K, M> for OneByOne<S, M> {
    fn advance(
        &mut self,
        problem: &Problem<K, M>,
        steps: u64,
        go_on: &mut dyn FnMut() -> bool,
    ) -> u64 {
        let Self { method, previous } = self;
        let mut made = 1;
        while go_on() && made < steps {
            method.step(problem);
            made += 1;
        }
        let u = method.iterate().u;
        match previous.is_empty() {
            true => *previous = sweep::copy(u),
            false => sweep::copy_over(previous, u),
        }
        method.last_step(problem);
        made
    }

    fn iterate(&mut self) -> Iterate<'_, M> {
        self.method.iterate()
    }

    fn change(&mut self) -> f64 {
        let (u, previous) = (self.method.iterate().u, &self.previous);
        sweep::max(
            previous.len(),
            #[inline(always)]
            |v| (u[v] - previous[v]).max_abs(),
        )
    }

    fn restart(&mut self, problem: &Problem<K, M>) {
        self.method.restart(problem);
    }

    fn follow(&mut self, problem: &Problem<K, M>) {
        self.method.follow(problem);
    }

    fn is_settled(&self) -> bool {
        self.method.is_settled()
    }

    fn smoothing(&self) -> Option<Smoothing> {
        self.method.smoothing()
    }
}
