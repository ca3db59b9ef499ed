//! Foreign iterates under our own measures: E(U), and a true lower bound from the best dual field at hand, as
//! `certificate.rs` has them: that of the solver, else that of the smoothing which the trace names, else steps of our
//! own. U is projected onto the simplex first: its energy would bound nothing otherwise.

use std::collections::BTreeMap;
use std::path::Path;

use ndarray::Array2;

use super::iterates::{Iterate, Iterates};
use super::problem::Exchanged;
use crate::certificate;
use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::order::Order;
use crate::npy;
use crate::operator::{Operator, Stencil};
use crate::problem::Problem;
use crate::regions::{self, with_regions};
use crate::run::{Certificate, Reached, Run, Status};
use crate::solve::{Observer, Request, Solution, check_range, conclude};
use crate::start::Start;
use crate::sweep::max;

/// Entries that the projection onto the simplex moves farther are worth a warning.
const LARGEST_ROUNDING: f64 = 1e-6;

/// Entries from here on count as infinite.
const FIRST_INFINITE: f64 = 1e100;

/// Which solver ended, and how, as its caller judges.
#[derive(Clone, Debug)]
pub struct End {
    /// The name of the solver, for the summary.
    pub solver: String,
    /// What it was told, by key.
    pub options: BTreeMap<String, String>,
    /// How it ended, unless its iterates converge or fail.
    pub status: Status,
    /// More about it.
    pub warnings: Vec<String>,
}

/// Scores all iterates. Of the request only the gap counts, which makes a run converge. `observe` is told
/// of every sample and of steps in between, and may break off. An iterate that cannot be read ends the run as failed,
/// one that is not finite as diverged; those before count.
///
/// # Errors
/// A problem beyond double precision.
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
    let judge = Judge::<M>::new(exchanged, dual_steps)?;
    let start = judge.on_simplex(&exchanged.u0);
    let mut run = Run::new(&start);
    let End { solver, options, mut status, mut warnings } = end;
    let (mut farthest, mut converged, mut interrupted) = (0.0, false, false);
    if iterates.all.first().is_none_or(|first| first.iteration > 0) {
        judge.record_start(&mut run, &start, observe)?;
    }
    for iterate in &iterates.all {
        let scored = match judge.scored(iterate, observe) {
            Ok(Some(scored)) => scored,
            Ok(None) => {
                status = Status::Diverged;
                break;
            }
            Err(error) => {
                warnings.push(error.to_string());
                status = Status::Failed;
                break;
            }
        };
        farthest = f64::max(farthest, scored.off_simplex);
        let gap = run.record(&judge.problem, &scored.reached(iterate));
        // Of the best so far, which only improve.
        converged = request.stop.relative_gap.is_some_and(|tolerance| gap <= tolerance);
        if observe(run.trace.last()).is_break() {
            interrupted = true;
            break;
        }
    }
    // Without any iterate that counts, there is at least the start.
    if run.trace.is_empty() {
        judge.record_start(&mut run, &start, observe)?;
    }
    let status = judged(&run, status, interrupted, converged);
    if farthest > LARGEST_ROUNDING {
        warnings.push(format!(
            "rows of U were up to {farthest:.1e} off the simplex, and were projected onto it"
        ));
    }
    let m = exchanged.f.ncols();
    let mut solution = conclude(&exchanged.mesh, &judge.problem, m, request, run, status, warnings);
    (solution.summary.solver, solution.summary.solver_options) = (solver, options);
    Ok(solution)
}

/// How a run ended: a contradiction in its numbers counts more than any other status.
fn judged<const M: usize>(run: &Run<M>, end: Status, interrupted: bool, converged: bool) -> Status {
    if run.is_contradicted() {
        Status::Contradicted
    } else if interrupted {
        Status::Interrupted
    } else if converged && end != Status::Failed {
        Status::Converged
    } else {
        end
    }
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
    problem: Problem<Stencil, M>,
    dual_steps: u64,
}

/// What is certain of one iterate.
struct Scored<const M: usize> {
    /// On the simplex.
    u: Vec<Row<M>>,
    /// The largest distance of an entry from where it was.
    off_simplex: f64,
    dual_bound: f64,
    certificate: Certificate,
    smoothed_energy: Option<f64>,
}

impl<const M: usize> Scored<M> {
    fn reached(&self, iterate: &Iterate) -> Reached<'_, M> {
        Reached {
            iteration: iterate.iteration,
            seconds: iterate.seconds,
            u: &self.u,
            dual_bound: self.dual_bound,
            certificate: self.certificate,
            smoothed_energy: self.smoothed_energy,
        }
    }
}

impl<'a, const M: usize> Judge<'a, M> {
    fn new(exchanged: &'a Exchanged, dual_steps: u64) -> Result<Self> {
        let Exchanged { mesh, f, lambda, .. } = exchanged;
        let m = f.ncols();
        let mut f = regions::rows::<M>(f.view());
        regions::pad_costs(m, &mut f);
        let problem = Problem::new(Stencil::new(mesh), f, *lambda);
        check_range(&problem)?;
        Ok(Judge { exchanged, problem, dual_steps })
    }

    fn on_simplex(&self, u: &Array2<f64>) -> Vec<Row<M>> {
        Start::Given(u.clone()).rows(u.ncols(), &self.problem.f, &Order::as_it_is())
    }

    /// The start as the first sample of a run.
    fn record_start(&self, run: &mut Run<M>, u: &[Row<M>], observe: Observer<'_>) -> Result<()> {
        let start = Reached {
            iteration: 0,
            seconds: 0.0,
            u,
            dual_bound: self.steps(u, observe)?,
            certificate: Certificate::Steps,
            smoothed_energy: None,
        };
        run.record(&self.problem, &start);
        Ok(())
    }

    /// `None` if it is not finite.
    fn scored(&self, iterate: &Iterate, observe: Observer<'_>) -> Result<Option<Scored<M>>> {
        let shape = (self.exchanged.mesh.vertices.len(), self.exchanged.f.ncols());
        let array = read(&iterate.u, shape)?;
        if !array.iter().all(|x| x.abs() < FIRST_INFINITE) {
            return Ok(None);
        }
        let u = self.on_simplex(&array);
        let (dual_bound, certificate) = self.bound(iterate, &u, observe)?;
        let given = regions::rows::<M>(array.view());
        let off_simplex = max(u.len(), |v| (u[v] - given[v]).max_abs());
        let energy =
            |smoothing| self.problem.baseline + self.problem.smoothed_energy(&u, smoothing);
        let smoothed_energy = iterate.smoothing.map(energy);
        Ok(Some(Scored { u, off_simplex, dual_bound, certificate, smoothed_energy }))
    }

    fn bound(
        &self,
        iterate: &Iterate,
        u: &[Row<M>],
        observe: Observer<'_>,
    ) -> Result<(f64, Certificate)> {
        if let Some(path) = &iterate.q {
            let (m, faces) = (self.exchanged.f.ncols(), self.problem.k.faces());
            let array = read(path, (2 * faces, m))?;
            // What is not finite bounds nothing.
            if array.iter().all(|x| x.is_finite()) {
                let q = regions::tangents(array.view());
                return Ok((certificate::offered(&self.problem, q), Certificate::Offered));
            }
        }
        if let Some(smoothing) = iterate.smoothing {
            let dual_bound = certificate::smoothed(&self.problem, u, smoothing);
            // The square of a tiny eps is zero, and what it divides may be so too.
            if dual_bound.is_finite() {
                return Ok((dual_bound, Certificate::Smoothed));
            }
        }
        Ok((self.steps(u, observe)?, Certificate::Steps))
    }

    /// They are no part of the run.
    fn steps(&self, u: &[Row<M>], observe: Observer<'_>) -> Result<f64> {
        certificate::steps(&self.exchanged.mesh, &self.problem, u, self.dual_steps, observe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{random_problem, shape};

    /// A bound above the energy is a contradiction however the solver ended, and whoever broke it off; else a reached
    /// gap is, unless it failed.
    #[test]
    fn a_contradiction_counts_more_than_any_end() {
        let mesh = shape("torus:12x8");
        let problem = random_problem::<3>(&mesh, 0.02, 883);
        let u = vec![Row([0.25, 0.25, 0.5]); mesh.vertices.len()];
        let run = |share: f64| {
            let mut run = Run::new(&u);
            let dual_bound = share * problem.energy(&u);
            let certificate = Certificate::Offered;
            let (iteration, seconds, smoothed_energy) = (1, 0.0, None);
            let reached =
                Reached { iteration, seconds, u: &u, dual_bound, certificate, smoothed_energy };
            run.record(&problem, &reached);
            run
        };
        let (wrong, right) = (run(1.0 + 1e-9), run(1.0 - 1e-9));
        for end in [Status::Ended, Status::TimeLimit, Status::Failed, Status::Diverged] {
            for (interrupted, converged) in
                [(false, false), (false, true), (true, false), (true, true)]
            {
                let of = |run| judged(run, end, interrupted, converged);
                assert_eq!(of(&wrong), Status::Contradicted);
                let expected = match (interrupted, converged) {
                    (true, _) => Status::Interrupted,
                    (false, true) if end != Status::Failed => Status::Converged,
                    _ => end,
                };
                assert_eq!(of(&right), expected);
            }
        }
    }
}
