//! Certifies the iterates of an external solver: E(U), and a true lower bound from the best available dual field, see
//! `certificate.rs`: that of the solver, otherwise that of the smoothing in the trace, otherwise that of steps of the
//! default solver. U is first projected onto the simplex, since otherwise its energy is no upper bound.

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
use crate::run::{Certificate, Reached, Run, Sample, Status};
use crate::solve::{Ended, Observer, Request, Solution, check_range, conclude};
use crate::start::Start;
use crate::sweep::max;
use crate::units::Unit;

/// A warning reports entries that the projection onto the simplex moves farther.
const LARGEST_ROUNDING: f64 = 1e-6;

/// Entries of at least this magnitude count as infinite.
const FIRST_INFINITE: f64 = 1e100;

/// Which solver ended, and how, according to its caller.
#[derive(Clone, Debug)]
pub struct End {
    /// The name of the solver, for the summary.
    pub solver: String,
    /// Its options by key.
    pub options: BTreeMap<String, String>,
    /// How it ended, unless its iterates converge or fail.
    pub status: Status,
    /// Further messages about it.
    pub warnings: Vec<String>,
}

/// Evaluates and certifies all iterates. Of the stopping rule only the gap applies, at which a run converges. `observe`
/// is called with every sample and during the steps in between, and may break. An iterate that cannot be read ends the
/// run as failed, one that is not finite as diverged; earlier ones are kept.
///
/// # Errors
/// The problem leaves the range of double precision.
pub fn certify(
    problem: &Exchanged,
    iterates: &Iterates,
    dual_steps: u64,
    request: &Request,
    end: End,
    observe: Observer<'_>,
) -> Result<Solution> {
    let m = problem.f.ncols();
    let size = problem.domain().area();
    let Some(unit) = Unit::of(&problem.f, problem.lambda * size.sqrt(), 1.0) else {
        return with_regions!(
            m,
            certify_compiled(problem, iterates, dual_steps, None, request, end, observe)
        );
    };
    let (f, lambda) = (unit.of_array(&problem.f), unit.of_number(problem.lambda));
    let problem = &Exchanged { f, lambda, ..problem.clone() };
    let mut observe =
        |sample: Option<&Sample>| observe(sample.map(|sample| sample.given(unit)).as_ref());
    let observe = &mut observe;
    with_regions!(
        m,
        certify_compiled(problem, iterates, dual_steps, Some(unit), request, end, observe)
    )?
    .given(unit)
}

fn certify_compiled<const M: usize>(
    exchanged: &Exchanged,
    iterates: &Iterates,
    dual_steps: u64,
    unit: Option<Unit>,
    request: &Request,
    end: End,
    observe: Observer<'_>,
) -> Result<Solution> {
    let certifier = Certifier::<M>::new(exchanged, dual_steps, unit)?;
    let start = certifier.on_simplex(&exchanged.u0);
    let mut run = Run::new(&start);
    let End { solver, options, mut status, mut warnings } = end;
    let (mut farthest, mut converged, mut interrupted) = (0.0, false, false);
    if iterates.all.first().is_none_or(|first| first.iteration > 0) {
        certifier.record_start(&mut run, &start, observe)?;
    }
    for iterate in &iterates.all {
        let scored = match certifier.scored(iterate, observe) {
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
        let gap = run.record(&certifier.problem, &scored.reached(iterate));
        // The gap of the best energy and bound so far, which never increases.
        converged = request.stop.relative_gap.is_some_and(|tolerance| gap <= tolerance);
        if observe(run.trace.last()).is_break() {
            interrupted = true;
            break;
        }
    }
    // Without any valid iterate, the start is the only sample.
    if run.trace.is_empty() {
        certifier.record_start(&mut run, &start, observe)?;
    }
    let status = final_status(&run, status, interrupted, converged);
    if farthest > LARGEST_ROUNDING {
        warnings.push(format!(
            "rows of U were up to {farthest:.1e} off the simplex and were projected onto it"
        ));
    }
    let m = exchanged.f.ncols();
    let mut solution = conclude(
        exchanged.domain(),
        &certifier.problem,
        m,
        request,
        Ended { run, status, warnings },
        observe,
    );
    (solution.summary.solver, solution.summary.solver_options) = (solver, options);
    Ok(solution)
}

/// How a run ended: a contradiction in its numbers takes precedence over any other status.
fn final_status<const M: usize>(
    run: &Run<M>,
    end: Status,
    interrupted: bool,
    converged: bool,
) -> Status {
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
    Err(Error::malformed(path, format!("has {rows} x {columns} entries, not {needed} x {regions}")))
}

struct Certifier<'a, const M: usize> {
    exchanged: &'a Exchanged,
    problem: Problem<Stencil, M>,
    dual_steps: u64,
    /// That of the problem, if it is not 1; files of q have none.
    unit: Option<Unit>,
}

/// An iterate with its certified bound.
struct Scored<const M: usize> {
    /// Projected onto the simplex.
    u: Vec<Row<M>>,
    /// The largest change of an entry by the projection.
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

impl<'a, const M: usize> Certifier<'a, M> {
    fn new(exchanged: &'a Exchanged, dual_steps: u64, unit: Option<Unit>) -> Result<Self> {
        let Exchanged { f, lambda, relaxation, .. } = exchanged;
        let m = f.ncols();
        let mut f = regions::rows::<M>(f.view());
        regions::pad_costs(m, &mut f);
        let k = exchanged.domain().stencil();
        let problem = Problem::new(k, f, *lambda).in_relaxation(*relaxation);
        check_range(&problem)?;
        Ok(Certifier { exchanged, problem, dual_steps, unit })
    }

    fn on_simplex(&self, u: &Array2<f64>) -> Vec<Row<M>> {
        Start::Given(u.clone()).rows(u.ncols(), &self.problem.f, &Order::as_it_is())
    }

    /// Records the start as the first sample of a run.
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

    /// `None` if the iterate is not finite.
    fn scored(&self, iterate: &Iterate, observe: Observer<'_>) -> Result<Option<Scored<M>>> {
        let shape = self.exchanged.f.dim();
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
            let (m, terms) = (self.exchanged.f.ncols(), self.problem.k.faces());
            let array = read(path, (2 * terms, m))?;
            // A field that is not finite gives no bound.
            if array.iter().all(|x| x.is_finite()) {
                let q = match self.unit {
                    None => regions::tangents(array.view()),
                    Some(unit) => regions::tangents(unit.of_array(&array).view()),
                };
                return Ok((certificate::offered(&self.problem, q), Certificate::Offered));
            }
        }
        if let Some(smoothing) = iterate.smoothing {
            let dual_bound = certificate::smoothed(&self.problem, u, smoothing);
            // The square of a tiny eps underflows to zero, which may give 0 / 0.
            if dual_bound.is_finite() {
                return Ok((dual_bound, Certificate::Smoothed));
            }
        }
        Ok((self.steps(u, observe)?, Certificate::Steps))
    }

    /// A bound by steps of the default solver; they are not part of the run.
    fn steps(&self, u: &[Row<M>], observe: Observer<'_>) -> Result<f64> {
        certificate::steps(self.exchanged.domain(), &self.problem, u, self.dual_steps, observe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{random_problem, shape};

    /// A bound above the energy is a contradiction however the solver ended; otherwise an interruption takes
    /// precedence, then a reached gap unless the solver failed.
    #[test]
    fn a_contradiction_takes_precedence_over_any_other_status() {
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
                let of = |run| final_status(run, end, interrupted, converged);
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
