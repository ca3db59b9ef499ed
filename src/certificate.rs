//! A true lower bound of all energies, for a U that somebody else computed: from the best dual field at hand.
//!
//! ```text
//! offered    a given q, each q_j cut off at |q_j| = lambda
//! smoothed   q_j = lambda (K U)_j / sqrt( |(K U)_j|^2 + eps_j^2 )
//! steps      D after a number of our own steps from (U, 0), that of `constant.rs` included; their U does not count
//! ```
//!
//! Bounds are D - B, as all bounds of a problem.

use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::{Operator, Stencil};
use crate::problem::{Problem, Smoothing};
use crate::prox::project_ball;
use crate::run::{Run, Stop};
use crate::solve::Observer;
use crate::solver::{self, Options, Setup};
use crate::sweep::sweep;

/// Steps of our own, where nothing else is at hand.
pub const DUAL_STEPS: u64 = 100;

/// D of a given field, of which nothing is believed.
pub fn offered<const M: usize>(problem: &Problem<Stencil, M>, mut q: Vec<Tangent<M>>) -> f64 {
    sweep(&mut q[..], |_, q| *q = project_ball(*q, problem.lambda));
    problem.dual_bound(&q)
}

/// D of the gradient of the smoothed total variation at U.
pub fn smoothed<const M: usize>(
    problem: &Problem<Stencil, M>,
    u: &[Row<M>],
    smoothing: Smoothing,
) -> f64 {
    let Problem { k, lambda, .. } = problem;
    let mut q = vec![Tangent::ZERO; k.faces()];
    sweep(&mut q[..], |j, q| *q = smoothing.dual(k.at(u, j), k.area(j), *lambda));
    problem.dual_bound(&q)
}

/// D after steps of the default solver from rows of the simplex. `observe` is told of steps alone.
pub fn steps<const M: usize>(
    mesh: &Mesh,
    problem: &Problem<Stencil, M>,
    u: &[Row<M>],
    steps: u64,
    observe: Observer<'_>,
) -> Result<f64> {
    let setup =
        Setup { mesh, problem, start: u.to_vec(), dual_start: None, options: &Options::default() };
    let mut solver = solver::build(solver::DEFAULT, setup)?;
    let mut run = Run::new(u);
    let stop = Stop { iterations: Some(steps), ..Stop::default() };
    run.advance(&mut *solver, problem, &stop, &mut |_| observe(None));
    Ok(run.bound())
}
