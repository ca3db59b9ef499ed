//! The parameters that all engines share: step lengths, their weight omega and the relaxation.

use super::steps::Steps;
use crate::operator::Operator;
use crate::problem::Problem;
use crate::solver::Iterate;
use crate::solver::balance::Balance;

/// The parameters of an engine.
pub struct Stepping<const M: usize> {
    pub steps: Steps,
    pub(super) balance: Option<Balance<M>>,
    pub rho: f64,
}

impl<const M: usize> Stepping<M> {
    /// Counts steps that were made.
    pub fn count(&mut self, steps: u64) {
        self.balance.iter_mut().for_each(|balance| balance.count(steps));
    }

    /// Whether `rebalance` is due.
    pub fn is_due(&self) -> bool {
        self.balance.as_ref().is_some_and(Balance::is_due)
    }

    /// Balances omega for a feasible pair. Returns whether the steps changed.
    pub fn rebalance<K: Operator>(&mut self, problem: &Problem<K, M>, now: Iterate<'_, M>) -> bool {
        let Self { steps, balance, .. } = self;
        let omega = balance.as_mut().and_then(|balance| {
            let Steps { sigma, tau, .. } = &*steps;
            balance.omega(problem, now, |v| 1.0 / tau[v], |j| 1.0 / sigma[j], steps.omega())
        });
        if let Some(omega) = omega {
            self.steps.set_omega(omega);
        }
        omega.is_some()
    }

    /// See [`Solver::follow`](crate::solver::Solver::follow). Returns whether the steps changed.
    pub fn follow<K: Operator>(&mut self, problem: &Problem<K, M>) -> bool {
        self.steps.follow(problem)
    }

    pub fn restart<K: Operator>(&mut self, problem: &Problem<K, M>, now: Iterate<'_, M>) {
        self.steps.restart(problem);
        if let Some(balance) = &mut self.balance {
            balance.restart(now);
        }
    }
}
