//! Iterates of external solvers in the trace of a run.

use std::time::Duration;

use super::{Certificate, Run};
use crate::field::Row;
use crate::operator::Operator;
use crate::problem::Problem;

/// An iterate of an external solver, and when it was reached.
pub struct Reached<'a, const M: usize> {
    /// The iteration, by the solver's own count.
    pub iteration: u64,
    /// Elapsed time by the solver's own clock, in seconds; not negative.
    pub seconds: f64,
    /// Rows in the simplex.
    pub u: &'a [Row<M>],
    /// D - B, a true lower bound on all energies.
    pub dual_bound: f64,
    /// The origin of the bound.
    pub certificate: Certificate,
    /// E_eps of u, if the solver minimizes a smoothed energy.
    pub smoothed_energy: Option<f64>,
}

impl<const M: usize> Run<M> {
    /// Adds an iterate of an external solver to the trace; returns the relative gap.
    pub fn record<K: Operator>(
        &mut self,
        problem: &Problem<K, M>,
        reached: &Reached<'_, M>,
    ) -> f64 {
        self.iteration = reached.iteration;
        self.clock = Duration::from_secs_f64(reached.seconds);
        self.update_best(problem, reached.u);
        self.best_bound = self.best_bound.max(reached.dual_bound);
        let certificate = Some(reached.certificate);
        self.push_sample(problem, None, reached.smoothed_energy, certificate)
    }
}
