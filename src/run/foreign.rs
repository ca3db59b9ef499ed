//! What solvers outside the program reach, in the trace of a run.

use std::time::Duration;

use super::{Certificate, Run};
use crate::field::Row;
use crate::operator::Operator;
use crate::problem::Problem;

/// What a solver outside the program reached, and when.
pub struct Reached<'a, const M: usize> {
    /// Its number, by the solver's own count.
    pub iteration: u64,
    /// Time until it was reached, by the solver's own clock, in seconds; not negative.
    pub seconds: f64,
    /// Rows in the simplex.
    pub u: &'a [Row<M>],
    /// A true lower bound of all energies, above B.
    pub dual_bound: f64,
    /// Where the bound comes from.
    pub certificate: Certificate,
    /// E_eps of u, if that is what the solver minimizes.
    pub smoothed_energy: Option<f64>,
}

impl<const M: usize> Run<M> {
    /// An iterate of a solver outside the program takes its place in the trace. Returns the relative gap.
    pub fn record<K: Operator>(
        &mut self,
        problem: &Problem<K, M>,
        reached: &Reached<'_, M>,
    ) -> f64 {
        self.iteration = reached.iteration;
        self.clock = Duration::from_secs_f64(reached.seconds);
        self.see(problem, reached.u);
        self.best_bound = self.best_bound.max(reached.dual_bound);
        let certificate = Some(reached.certificate);
        self.note(problem, None, reached.smoothed_energy, certificate)
    }
}
