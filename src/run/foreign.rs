//! What solvers outside the program reach, in the trace of a run.

use std::time::Duration;

use super::{Certificate, Run};
use crate::field::Row;
use crate::operator::Operator;
use crate::problem::Problem;

/// What a solver outside the program reached, and when.
pub struct Reached<'a, const M: usize> {
    pub iteration: u64,
    pub seconds: f64,
    /// Rows in the simplex.
    pub u: &'a [Row<M>],
    /// A true bound, and where it comes from.
    pub dual_bound: f64,
    pub certificate: Certificate,
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
