//! A method by its step, and the solver that makes one step after the other.

use super::{Iterate, Solver};
use crate::field::Row;
use crate::operator::Operator;
use crate::problem::{Problem, Smoothing};
use crate::sweep;

/// A method. It knows neither when its iterates are looked at nor when it ends.
pub trait Step<K, const M: usize> {
    /// One iteration; allocates nothing (but solves with a factorization their workspace).
    fn step(&mut self, problem: &Problem<K, M>);

    /// The iteration after which the iterate is looked at, for a method whose iterates are infeasible or poor on the
    /// way, such as an over-relaxed one: it ends with a feasible pair.
    fn last_step(&mut self, problem: &Problem<K, M>) {
        self.step(problem);
    }

    /// At the start and after a last step: a feasible U, rows in the simplex, and a feasible dual field.
    fn iterate(&self) -> Iterate<'_, M>;

    /// See [`Solver::restart`].
    fn restart(&mut self, _problem: &Problem<K, M>) {}

    /// See [`Solver::smoothing`].
    fn smoothing(&self) -> Option<Smoothing> {
        None
    }
}

/// The solver of a method.
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

    fn smoothing(&self) -> Option<Smoothing> {
        self.method.smoothing()
    }
}
