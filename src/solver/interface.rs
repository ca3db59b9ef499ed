//! What a solver is: it starts from a [`Setup`], advances, and shows a feasible pair that certifies itself.
//!
//! ```text
//! D(q) <= E* <= E(u),   rows of u in the simplex, |q_j| <= lambda
//! ```

use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::Operator;
use crate::problem::{Problem, Smoothing};

/// What runs a method. Most methods implement [`Step`](super::Step), of which [`OneByOne`](super::OneByOne) makes a solver; what makes several steps in
/// one pass implements this.
pub trait Solver<K, const M: usize> {
    /// Makes so many steps, at least one, and ends with a feasible pair. `go_on` is asked before every pass of one or
    /// several steps; where it says no, one step more is the last. Returns how many were made.
    fn advance(
        &mut self,
        problem: &Problem<K, M>,
        steps: u64,
        go_on: &mut dyn FnMut() -> bool,
    ) -> u64;

    /// A feasible U, rows in the simplex, and a feasible dual field.
    fn iterate(&mut self) -> Iterate<'_, M>;

    /// U alone, where that is cheaper.
    fn labels(&mut self) -> &[Row<M>] {
        self.iterate().u
    }

    /// D of the dual field, where that is known more cheaply than from the field.
    fn dual_bound(&mut self, problem: &Problem<K, M>) -> f64
    where
        K: Operator,
    {
        problem.dual_bound(self.iterate().q)
    }

    /// max |u^n - u^{n-1}| of the last step; zero before the first.
    fn change(&mut self) -> f64;

    /// f or lambda changed to those of `problem`, and no step may come before this: drop momentum, fit the
    /// steps, keep the iterate.
    fn restart(&mut self, _problem: &Problem<K, M>) {}

    /// The smoothing of the energy that is minimized in place of E, if there is one.
    fn smoothing(&self) -> Option<Smoothing> {
        None
    }
}

/// What certifies itself: E(u) is an upper, D(q) a lower bound of the least energy.
#[derive(Clone, Copy)]
pub struct Iterate<'a, const M: usize> {
    /// U, V rows in the simplex.
    pub u: &'a [Row<M>],
    /// The dual field, F tangents with |q_j| <= lambda.
    pub q: &'a [Tangent<M>],
}

/// What a solver is built from, beside its settings.
pub struct Setup<'a, K, const M: usize> {
    /// The mesh that K is of; every face has an area.
    pub mesh: &'a Mesh,
    /// What is minimized.
    pub problem: &'a Problem<K, M>,
    /// U at the start: rows in the simplex.
    pub start: Vec<Row<M>>,
    /// q at the start, |q_j| <= lambda; zero if there is none. Methods without a dual field ignore it.
    pub dual_start: Option<Vec<Tangent<M>>>,
}

/// What `meshseg solvers` prints of a method, beside its settings.
pub struct Description {
    /// Its name in `--solver NAME`.
    pub name: &'static str,
    /// One line on how it works.
    pub summary: &'static str,
    /// Authors and year of what it is taken from.
    pub reference: &'static str,
    /// How the step lengths are chosen.
    pub steps: &'static str,
}

/// A solver, or why there is none.
pub type Built<'a, K, const M: usize> = Result<Box<dyn Solver<K, M> + 'a>>;
