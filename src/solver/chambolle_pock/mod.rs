//! Over-relaxed Chambolle-Pock with local steps, the default:
//!
//! ```text
//! x = Proj_simplex( u - tau (f + K^T q) )        u <- u + rho (x - u)
//! y = Proj_{|.|<=lambda}( q + sigma K (2x - u) )  q <- q + rho (y - q)
//! ```
//!
//! A. Chambolle, T. Pock, *A first-order primal-dual algorithm for convex problems with applications to
//! imaging*, J. Math. Imaging Vis. 40, 2011; relaxation: L. Condat, *A primal-dual splitting method for
//! convex optimization*, J. Optim. Theory Appl. 158, 2013. Relaxed iterates are infeasible and poor; the last step before
//! one is looked at has rho = 1, after which u = x and q = y.
//!
//! `rows` is the text of the method, for any operator. `fused` computes the same iterates from the stencil's
//! numbers, several in one pass over memory. They share the step lengths (`steps`) and their weight
//! (`../balance.rs`).

mod engine;
mod fused;
mod rows;
mod steps;

pub use engine::{Engine, Engines, Precision, build};
pub use steps::Rule;
use steps::Steps;

use super::balance::Balance;
pub use super::balance::Balancing;
use super::{Adjustable, Description, Iterate, Setting};
use crate::operator::Operator;
use crate::problem::Problem;

/// What `meshseg solvers` prints of the method.
pub const DESCRIPTION: Description = Description {
    name: "chambolle-pock",
    summary: "over-relaxed primal-dual method with steps fitted face by face; exact energy, no smoothing",
    reference: "Chambolle, Pock 2011; relaxation: Condat 2013; diagonal steps: Pock, Chambolle 2011",
    steps: "closed form, no power iteration; balanced by the primal and dual moves after 100, 300, 700, ... steps",
};

/// The settings of Chambolle-Pock: `steps`, `rho`, `step-ratio`, `balance`, `engine`, `precision`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The rule of the step lengths; local by default.
    pub steps: Rule,
    /// Relaxation, above 0 and below 2; 1.9 by default.
    pub rho: f64,
    /// omega at the start, in units of lambda, or of what the costs need, if that is less; 1.5 by default.
    pub step_ratio: f64,
    /// Whether omega is balanced; adaptive by default.
    pub balance: Balancing,
    /// What iterates; auto by default.
    pub engine: Engine,
    /// Of the iterates; double by default.
    pub precision: Precision,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            steps: Rule::Local,
            rho: 1.9,
            step_ratio: 1.5,
            balance: Balancing::Adaptive,
            engine: Engine::Auto,
            precision: Precision::Double,
        }
    }
}

impl Adjustable for Settings {
    fn settings(&mut self) -> Vec<Setting<'_>> {
        vec![
            Setting::choice(
                "steps",
                &mut self.steps,
                "face by face; row and column sums of |K|; one number from ||K||",
            ),
            Setting::number(
                "rho",
                &mut self.rho,
                f64::MIN_POSITIVE..2.0,
                "relaxation, above 0 and below 2",
            ),
            Setting::number(
                "step-ratio",
                &mut self.step_ratio,
                f64::MIN_POSITIVE..,
                "omega to begin with, in units of lambda (or of what the costs need, if that is less)",
            ),
            self.balance.setting(),
            Setting::choice(
                "engine",
                &mut self.engine,
                "one blocked pass over memory (what auto takes where it can), or the readable text",
            ),
            Setting::choice(
                "precision",
                &mut self.precision,
                "of the iterates; f32 moves half the bytes and reaches gaps down to about 1e-5; certificates are f64",
            ),
        ]
    }
}

/// What the engines need beside their fields.
pub struct Method<const M: usize> {
    steps: Steps,
    balance: Option<Balance<M>>,
    rho: f64,
}

impl<const M: usize> Method<M> {
    /// So many steps were made.
    fn count(&mut self, steps: u64) {
        self.balance.iter_mut().for_each(|balance| balance.count(steps));
    }

    /// Whether `rebalance` is due.
    fn is_due(&self) -> bool {
        self.balance.as_ref().is_some_and(Balance::is_due)
    }

    /// Balances omega for a feasible pair, and says whether the steps changed.
    fn rebalance<K: Operator>(&mut self, problem: &Problem<K, M>, now: Iterate<'_, M>) -> bool {
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

    fn restart<K: Operator>(&mut self, problem: &Problem<K, M>, now: Iterate<'_, M>) {
        self.steps.restart(problem);
        if let Some(balance) = &mut self.balance {
            balance.restart(now);
        }
    }
}
