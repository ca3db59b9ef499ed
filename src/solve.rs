//! One convex problem from mesh and costs to certified labels.

mod checks;
mod solution;

use std::time::Duration;

use ndarray::{Array1, Array2};

pub(crate) use checks::{check_finite, check_range, check_rows};
pub use checks::{check_mesh, model_mesh};
pub(crate) use solution::conclude;
pub use solution::{Solution, Summary};

use crate::coarse::{self, Pair};
use crate::costs;
use crate::error::Result;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::order::Order;
use crate::operator::{Quadrature, Stencil};
use crate::problem::{FORBIDDEN, Problem};
use crate::regions::{self, with_regions};
use crate::remarks::{empty_regions, named};
pub use crate::request::{Observer, Request};
use crate::run::{Run, Status};
use crate::solver::Setup;
use crate::start::Start;
use crate::sweep;
use crate::unreached::unreached;

/// Minimizes E for pointwise costs s (V x m, see [`costs`]) on a mesh as it is: no scaling.
pub fn solve(
    mesh: &Mesh,
    s: &Array2<f64>,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    request.check()?;
    regions::check(s.ncols())?;
    check_rows("costs", s.nrows(), mesh)?;
    start.check(s.dim())?;
    let (known, mut warnings) = costs::checked(s, request.mass)?;
    let (model, left_out) = model_mesh(mesh)?;
    warnings.extend(left_out);
    warnings.extend(unreached(&model, |k| !s[[k, 0]].is_nan()));
    let order = Order::of(&model);
    let model = order.mesh(model);
    let solved = with_regions!(
        s.ncols(),
        solve_compiled(&model, &order, warnings, &known, start, request, observe)
    );
    solved.map(|solution| solution.of(mesh, &order))
}

fn solve_compiled<const M: usize>(
    model: &Mesh,
    order: &Order,
    warnings: Vec<String>,
    s: &Array2<f64>,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    let m = s.ncols();
    let s = order.applied(regions::rows(s.view()));
    let problem = problem_of::<M>(model, m, s, request)?;
    let beginning = match request.coarse_to_fine && !coarse::is_certified(&problem, request) {
        true => Some(coarse::start(model, &problem, request, observe)?),
        false => None,
    };
    let (pair, record) = beginning.map(|begin| (begin.pair, begin.record)).unzip();
    let (start, dual_start) = match pair.flatten() {
        Some(Pair { u, q }) => (u, Some(q)),
        None => (start.rows(m, &problem.f, order), None),
    };
    let mut run = Run::new(&start);
    if request.keep_dual {
        run.keep_dual();
    }
    let setup = Setup { mesh: model, problem: &problem, start, dual_start };
    let mut solver = request.method.build(setup)?;
    let spent = record.as_ref().map_or(Duration::ZERO, |record| record.spent);
    run.charge(spent);
    let stop = request.stop.after(spent);
    let status = run.advance(&mut *solver, &problem, &stop, observe);
    let mut solution = conclude(model, &problem, m, request, run, status, warnings);
    solution.summary.coarse_to_fine = record;
    // Who breaks off does not want to wait for advice.
    if status != Status::Interrupted {
        let done = !matches!(status, Status::IterationLimit | Status::TimeLimit);
        let remark =
            remark(model, &problem, m, &solution.summary.empty_regions, done, request, observe)?;
        solution.summary.warnings.extend(remark);
    }
    Ok(solution)
}

/// What must be said where some regions are empty. A lambda that saves those that are somewhere the cheapest is looked
/// for on a coarse mesh.
fn remark<const M: usize>(
    mesh: &Mesh,
    problem: &Problem<Stencil, M>,
    m: usize,
    empty: &[usize],
    done: bool,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<String>> {
    if empty.is_empty() {
        return Ok(None);
    }
    let cheapest: Array1<i32> = problem.f.iter().map(|f| f.argmin() as i32).collect();
    let hopeless = empty_regions(&cheapest, m);
    let (hopeless, lost): (Vec<usize>, Vec<usize>) =
        empty.iter().partition(|p| hopeless.contains(p));
    let mut sentences = Vec::new();
    if !hopeless.is_empty() {
        sentences.push(format!("{}: nowhere do they cost the least", named(&hopeless)));
    }
    if !lost.is_empty() && !done {
        sentences
            .push(format!("{} so far: the run ended before its gap was reached", named(&lost)));
    } else if !lost.is_empty() {
        let advice = match coarse::separating(mesh, problem, &lost, request, observe)? {
            // The coarse mesh may keep a region a little longer than the fine one.
            Some(lambda) => format!("try --lambda {:.1e}", 0.5 * lambda),
            None => "try a much smaller --lambda".into(),
        };
        let few = "lambda is too large for these costs";
        sentences.push(format!("{}: {few}; {advice}", named(&lost)));
    }
    Ok(Some(sentences.join("; ")))
}

/// The problem with costs integrated and unused regions closed.
pub(crate) fn problem_of<const M: usize>(
    model: &Mesh,
    m: usize,
    s: Vec<Row<M>>,
    request: &Request,
) -> Result<Problem<Stencil, M>> {
    let (f, k) = sweep::join(|| integrate(&request.mass.on(model), m, &s), || Stencil::new(model));
    let problem = Problem::new(k, f, request.lambda);
    check_range(&problem)?;
    Ok(problem)
}

/// f = M s; what s forbids, f forbids, also where a vertex has no area.
pub(crate) fn integrate<const M: usize>(
    mass: &Quadrature<'_>,
    m: usize,
    s: &[Row<M>],
) -> Vec<Row<M>> {
    let mut f = mass.integrate(s);
    sweep::sweep(
        (&mut f[..], s),
        #[inline(always)]
        |_, (f, s)| {
            *f = Row::from_fn(|p| if p < m && s.0[p] < f64::INFINITY { f.0[p] } else { FORBIDDEN });
        },
    );
    f
}

#[cfg(test)]
mod tests;
