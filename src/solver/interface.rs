//! The interface of a solver: it starts from a [`Setup`], advances, and returns a feasible pair that certifies itself.
//!
//! ```text
//! D(q) <= E* <= E(u),   rows of u in the simplex, |q_j| <= lambda
//! ```

use crate::domain::Domain;
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::{Problem, Smoothing};

/// A running method. Most methods implement [`Step`](super::Step), and [`OneByOne`](super::OneByOne) makes a solver of
/// them; a method that makes several steps in one pass implements this trait itself.
pub trait Solver<K, const M: usize> {
    /// Makes the given number of steps, at least one, and ends with a feasible pair. `go_on` is called before every
    /// pass of one or several steps; once it returns false, one more step is made as the last. Returns the number of
    /// steps made.
    fn advance(
        &mut self,
        problem: &Problem<K, M>,
        steps: u64,
        go_on: &mut dyn FnMut() -> bool,
    ) -> u64;

    /// The current pair: a feasible U, with rows in the simplex, and a feasible dual field.
    fn iterate(&mut self) -> Iterate<'_, M>;

    /// U alone, which may be cheaper than the pair.
    fn labels(&mut self) -> &[Row<M>] {
        self.iterate().u
    }

    /// D of the dual field, which the solver may know at lower cost than by computing it from the field.
    fn dual_bound(&mut self, problem: &Problem<K, M>) -> f64
    where
        K: Operator,
    {
        problem.dual_bound(self.iterate().q)
    }

    /// max |u^n - u^{n-1}| of the last step; zero before the first.
    fn change(&mut self) -> f64;

    /// This or [`Solver::follow`] must be called before the next step when f or lambda have changed to those of
    /// `problem`: drops momentum, fits the steps and keeps the iterate.
    fn restart(&mut self, _problem: &Problem<K, M>) {}

    /// The same for small changes of f, as after a re-estimation: keeps what was learned about the steps.
    fn follow(&mut self, problem: &Problem<K, M>) {
        self.restart(problem);
    }

    /// Whether no further step changes the iterate, unless the costs change.
    fn is_settled(&self) -> bool {
        false
    }

    /// The smoothing of the energy, if a smoothed energy is minimized instead of E.
    fn smoothing(&self) -> Option<Smoothing> {
        None
    }
}

/// A pair that certifies itself: E(u) is an upper bound and D(q) a lower bound of the minimum energy.
#[derive(Clone, Copy)]
pub struct Iterate<'a, const M: usize> {
    /// U, V rows in the simplex.
    pub u: &'a [Row<M>],
    /// The dual field, F tangents with |q_j| <= lambda.
    pub q: &'a [Tangent<M>],
}

/// What a solver is built from, in addition to its settings.
pub struct Setup<'a, K, const M: usize> {
    /// What the operator acts on; every face of a mesh has positive area.
    pub domain: Domain<'a>,
    /// The problem to solve.
    pub problem: &'a Problem<K, M>,
    /// The initial U, with rows in the simplex.
    pub start: Vec<Row<M>>,
    /// The initial q, |q_j| <= lambda; zero if none is given. Methods without a dual field ignore it.
    pub dual_start: Option<Vec<Tangent<M>>>,
}

/// What `meshseg solvers` prints about a method, in addition to its settings.
pub struct Description {
    /// Its name in `--solver NAME`.
    pub name: &'static str,
    /// One line on how it works.
    pub summary: &'static str,
    /// Authors and years of the publications that it follows.
    pub reference: &'static str,
    /// How the step lengths are chosen.
    pub steps: &'static str,
}

/// A solver, or the reason why it cannot be built.
pub type Built<'a, K, const M: usize> = Result<Box<dyn Solver<K, M> + 'a>>;
