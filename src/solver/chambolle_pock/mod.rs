//! Over-relaxed Chambolle-Pock with local steps, the default:
//!
//! ```text
//! x = Proj_simplex( u - tau (f + K^T q) )        u <- u + rho (x - u)
//! y = Proj_{|.|<=lambda}( q + sigma K (2x - u) )  q <- q + rho (y - q)
//! ```
//!
//! A. Chambolle, T. Pock, *A first-order primal-dual algorithm for convex problems with applications to
//! imaging*, J. Math. Imaging Vis. 40, 2011; relaxation: L. Condat, *A primal-dual splitting method for
//! convex optimization*, J. Optim. Theory Appl. 158, 2013. Relaxed iterates are infeasible and poor; a landing
//! step has rho = 1, after which u = x and q = y.
//!
//! `rows` is the text of the method, for any operator. `fused` computes the same iterates from the stencil's
//! numbers, several in one pass over memory. They share the step lengths (`steps`) and their weight
//! (`../balance.rs`).

mod fused;
mod rows;
mod steps;

use pulp::Arch;

use fused::{Fused, Plan};
use rows::Rows;
use steps::Steps;

use super::balance::Balance;
use super::{Description, Iterate, OptionDescription, Setup, Solver};
use crate::error::{Error, Result};
use crate::field::Tangent;
use crate::operator::Operator;
use crate::problem::Problem;
use crate::sweep::join;

pub const DESCRIPTION: Description = Description {
    name: "chambolle-pock",
    summary: "over-relaxed primal-dual method with steps fitted face by face; exact energy, no smoothing",
    reference: "Chambolle, Pock 2011; relaxation: Condat 2013; diagonal steps: Pock, Chambolle 2011",
    steps: "closed form, no power iteration; balanced by the primal and dual moves after 100, 300, 700, ... steps",
    options: &[
        OptionDescription {
            key: "steps",
            values: "local|diagonal|plain",
            default: "local",
            help: "face by face; row and column sums of |K|; one number from ||K||",
        },
        OptionDescription {
            key: "rho",
            values: "NUMBER",
            default: "1.9",
            help: "relaxation, above 0 and below 2",
        },
        OptionDescription {
            key: "step-ratio",
            values: "NUMBER",
            default: "1.5",
            help: "omega to begin with, in units of lambda (or of what the costs need, if that is less)",
        },
        OptionDescription {
            key: "balance",
            values: "adaptive|fixed",
            default: "adaptive",
            help: "whether omega follows the lengths of the primal and dual moves, or stays",
        },
        OptionDescription {
            key: "engine",
            values: "auto|fused|rows",
            default: "auto",
            help: "one blocked pass over memory (what auto takes where it can), or the readable text",
        },
        OptionDescription {
            key: "precision",
            values: "f64|f32",
            default: "f64",
            help: "of the iterates; f32 moves half the bytes and reaches gaps down to about 1e-5; certificates are f64",
        },
    ],
};

#[derive(Clone, Copy, PartialEq)]
enum Engine {
    Auto,
    Fused,
    Rows,
}

#[derive(Clone, Copy, PartialEq)]
enum Precision {
    Double,
    Single,
}

/// The solver in the engine and the precision that the options ask for.
pub(super) fn build<'a, K: Operator + 'a, const M: usize>(
    setup: Setup<'_, K, M>,
) -> Result<Box<dyn Solver<K, M> + 'a>> {
    let Setup { problem, options, start: u, dual_start, .. } = setup;
    let engine = options.choice(
        "engine",
        &[("auto", Engine::Auto), ("fused", Engine::Fused), ("rows", Engine::Rows)],
    )?;
    let precision =
        options.choice("precision", &[("f64", Precision::Double), ("f32", Precision::Single)])?;
    let rho = options.number("rho", f64::MIN_POSITIVE..2.0)?.unwrap_or(1.9);
    let method = || -> Result<Method<M>> {
        let steps = Steps::new(problem, options)?;
        let balance = Balance::new(options, &u, dual_start.as_ref())?;
        Ok(Method { steps, balance, rho })
    };
    match (engine, precision, problem.k.stencil()) {
        (Engine::Fused | Engine::Auto, Precision::Double, Some(stencil)) => {
            let (method, plan) = join(method, || Plan::new::<f64, M>(stencil, Arch::new()));
            Ok(Box::new(Fused::<f64, M>::new(problem, stencil, u, dual_start, method?, plan)))
        }
        (Engine::Fused | Engine::Auto, Precision::Single, Some(stencil)) => {
            let (method, plan) = join(method, || Plan::new::<f32, M>(stencil, Arch::new()));
            Ok(Box::new(Fused::<f32, M>::new(problem, stencil, u, dual_start, method?, plan)))
        }
        (Engine::Auto | Engine::Rows, Precision::Double, _) => {
            let method = method()?;
            problem.k.prepare_adjoint();
            let q = dual_start.unwrap_or_else(|| vec![Tangent::ZERO; problem.k.faces()]);
            Ok(Box::new(Rows { u_bar: u.clone(), u, q, method }))
        }
        (Engine::Rows, Precision::Single, _) => Err(Error::unsuitable(
            "solver options engine=rows and precision=f32 exclude each other: rows are in double precision",
        )),
        (_, _, None) => Err(Error::unsuitable(
            "solver option engine=fused needs the gradient as a stencil, not as a matrix",
        )),
    }
}

/// What both engines need beside their fields.
struct Method<const M: usize> {
    steps: Steps,
    balance: Option<Balance<M>>,
    rho: f64,
}

impl<const M: usize> Method<M> {
    /// To be called after every step; says whether `rebalance` is due.
    fn due(&mut self, land: bool) -> bool {
        self.balance.as_mut().is_some_and(|balance| balance.due(land))
    }

    /// Looks at omega, and says whether the steps changed.
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
