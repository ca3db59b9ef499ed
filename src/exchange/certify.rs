//! Foreign iterates under our own measures: E(U), and a true lower bound from the best dual field at hand.
//!
//! ```text
//! offered    q of the solver, each q_j cut off at |q_j| = lambda
//! smoothed   q_j = lambda (K U)_j / sqrt( |(K U)_j|^2 + eps_j^2 ),  where the trace names an eps
//! steps      D after DUAL_STEPS steps of our own from (U, 0); their U does not count
//! ```
//!
//! U is projected onto the simplex first: its energy would bound nothing otherwise.

use std::ops::ControlFlow;
use std::path::Path;

use ndarray::Array2;

use super::iterates::{Iterate, Iterates};
use super::problem::Exchanged;
use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::mesh::order::Order;
use crate::npy;
use crate::operator::{Operator, Stencil};
use crate::problem::Problem;
use crate::prox::project_ball;
use crate::regions::{self, with_regions};
use crate::run::{Certificate, Reached, Run, Status, Stop};
use crate::solve::{Observer, Request, Solution, check_range, conclude};
use crate::solver::{self, Options, Setup};
use crate::start::Start;
use crate::sweep::{max, sweep};

/// Steps of our own, where a solver brings neither q nor an eps.
pub const DUAL_STEPS: u64 = 100;

/// An entry or a sum of a row may be off by this much before a warning says so.
const OFF: f64 = 1e-6;

/// How a solver ended, by the judgment of whoever ran it.
#[derive(Clone, Debug)]
pub struct End {
    pub status: Status,
    /// More about it.
    pub warnings: Vec<String>,
}

/// Scores all iterates. `request` is what the run is remembered by; its gap makes a run converge. `observe` is told
/// of every sample, and may break off.
///
/// # Errors
/// Iterates that cannot be read or have the wrong shape.
pub fn certify(
    problem: &Exchanged,
    iterates: &Iterates,
    dual_steps: u64,
    request: &Request,
    end: End,
    observe: Observer<'_>,
) -> Result<Solution> {
    with_regions!(
        problem.f.ncols(),
        certify_compiled(problem, iterates, dual_steps, request, end, observe)
    )
}

fn certify_compiled<const M: usize>(
    exchanged: &Exchanged,
    iterates: &Iterates,
    dual_steps: u64,
    request: &Request,
    end: End,
    observe: Observer<'_>,
) -> Result<Solution> {
    let Exchanged { mesh, f, lambda, u0, .. } = exchanged;
    let m = f.ncols();
    let mut f = regions::rows::<M>(f.view());
    regions::close_from(m, &mut f);
    let problem = Problem::new(Stencil::new(mesh), f, *lambda);
    check_range(&problem)?;
    let on_simplex =
        |u: &Array2<f64>| Start::Given(u.clone()).rows::<M>(m, &problem.f, &Order::as_it_is());
    let start = on_simplex(u0);
    let mut run = Run::new(&start);
    let End { mut status, mut warnings } = end;
    let judge = Judge { exchanged, problem: &problem, dual_steps };
    let mut farthest = 0.0;
    // Whoever brings nothing has at least the start.
    if iterates.0.first().is_none_or(|first| first.iteration > 0) {
        let (dual_bound, certificate) = judge.steps(&start)?;
        let reached = Reached {
            iteration: 0,
            seconds: 0.0,
            u: &start,
            dual_bound,
            certificate,
            smoothed_energy: None,
        };
        run.record(&problem, &reached);
    }
    for iterate in &iterates.0 {
        let array = read(&iterate.u, (mesh.vertices.len(), m))?;
        if array.iter().any(|x| !x.is_finite()) {
            status = Status::Diverged;
            break;
        }
        let u = on_simplex(&array);
        let given = regions::rows::<M>(array.view());
        farthest = f64::max(farthest, max(u.len(), |v| (u[v] - given[v]).max_abs()));
        let (dual_bound, certificate) = judge.bound(iterate, &u)?;
        let smoothed_energy =
            iterate.smoothing.map(|smoothing| problem.smoothed_energy(&u, smoothing));
        let Iterate { iteration, seconds, .. } = *iterate;
        let reached =
            Reached { iteration, seconds, u: &u, dual_bound, certificate, smoothed_energy };
        let gap = run.record(&problem, &reached);
        if request.stop.relative_gap.is_some_and(|tolerance| gap <= tolerance) {
            status = Status::Converged;
        }
        if observe(run.trace.last()).is_break() {
            status = Status::Interrupted;
            break;
        }
    }
    if farthest > OFF {
        warnings.push(format!(
            "rows of U were up to {farthest:.1e} off the simplex, and were projected onto it"
        ));
    }
    Ok(conclude(mesh, &problem, m, request, run, status, warnings))
}

fn read(path: &Path, shape: (usize, usize)) -> Result<Array2<f64>> {
    let array = npy::read_rows(path)?;
    if array.dim() == shape {
        return Ok(array);
    }
    let ((rows, columns), (needed, regions)) = (array.dim(), shape);
    Err(Error::malformed(path, format!("is {rows} x {columns}, not {needed} x {regions}")))
}

struct Judge<'a, const M: usize> {
    exchanged: &'a Exchanged,
    problem: &'a Problem<Stencil, M>,
    dual_steps: u64,
}

impl<const M: usize> Judge<'_, M> {
    fn bound(&self, iterate: &Iterate, u: &[Row<M>]) -> Result<(f64, Certificate)> {
        let Problem { k, lambda, .. } = self.problem;
        if let Some(path) = &iterate.q {
            let m = self.exchanged.f.ncols();
            let array = read(path, (2 * k.faces(), m))?;
            // What is not finite bounds nothing.
            if array.iter().all(|x| x.is_finite()) {
                let rows = regions::rows::<M>(array.view());
                let mut q = vec![Tangent::ZERO; k.faces()];
                sweep(&mut q, |j, q| {
                    *q = project_ball(Tangent([rows[2 * j], rows[2 * j + 1]]), *lambda);
                });
                return Ok((self.problem.dual_bound(&q), Certificate::Offered));
            }
        }
        match iterate.smoothing {
            Some(smoothing) => {
                let mut q = vec![Tangent::ZERO; k.faces()];
                sweep(&mut q, |j, q| *q = smoothing.dual(k.at(u, j), k.area(j), *lambda));
                Ok((self.problem.dual_bound(&q), Certificate::Smoothed))
            }
            None => self.steps(u),
        }
    }

    /// D after steps of our own; they are no part of the run.
    fn steps(&self, u: &[Row<M>]) -> Result<(f64, Certificate)> {
        let setup = Setup {
            mesh: &self.exchanged.mesh,
            problem: self.problem,
            start: u.to_vec(),
            dual_start: None,
            options: &Options::default(),
        };
        let mut solver = solver::build(solver::DEFAULT, setup)?;
        let mut run = Run::new(u);
        let stop = Stop { iterations: Some(self.dual_steps), ..Stop::default() };
        run.advance(&mut *solver, self.problem, &stop, &mut |_| ControlFlow::Continue(()));
        Ok((run.bound(), Certificate::Steps))
    }
}
