//! One convex problem, from mesh and costs to certified labels.
//!
//! Costs are integrated and the problem is solved, coarse to fine if requested; `solve/solution.rs` has the
//! certificate. The formulas are those of `problem.rs`.

mod checks;
mod solution;

use std::time::Duration;

use ndarray::{Array1, Array2};

pub(crate) use checks::{check_finite, check_range, check_rows, check_rows_of_faces};
pub use checks::{check_mesh, model_mesh};
pub(crate) use solution::{Ended, conclude};
pub use solution::{RoundingRecord, Solution, Summary};

use crate::coarse::{self, Pair};
use crate::costs;
use crate::counted::counted;
use crate::domain::Domain;
use crate::empty_regions;
use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::mesh::dual::Dual;
use crate::mesh::order::Order;
use crate::operator::{Mass, Quadrature, Stencil};
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::regions::{self, with_regions};
pub use crate::request::{Observer, Request};
use crate::run::{Run, Sample, Status};
use crate::seeds::Seeds;
use crate::solver::Setup;
use crate::start::Start;
use crate::sweep;
use crate::units::Unit;
use crate::unreached;

/// Minimizes E for pointwise costs s (V x m, see [`costs`]) on a mesh as it is, without scaling. For `observe` see
/// [`Observer`].
///
/// Fails if the number of regions is not from 2 to 64, s does not have V rows or is refused by [`costs::checked`], a
/// given start is not V x m with rows in the simplex, lambda or a setting of the solver is out of range, no face has an
/// area, or the integrated costs leave the range of double precision.
pub fn solve(
    mesh: &Mesh,
    s: &Array2<f64>,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    solve_seeded(mesh, s, &Seeds::default(), start, request, observe)
}

/// The same with [`Seeds`], whose labels are given: energies, bounds and certificates are those of the constrained
/// problem.
///
/// Also fails if the seeds are not those of V vertices and m regions, or the costs forbid the region of a seed.
pub fn solve_seeded(
    mesh: &Mesh,
    s: &Array2<f64>,
    seeds: &Seeds,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    solve_weighted(mesh, None, s, seeds, start, request, observe)
}

/// The same with a factor for each face, by which cuts through it cost more or less: lambda varies over the surface.
///
/// Also fails unless there is a positive, finite factor for each face.
pub fn solve_weighted(
    mesh: &Mesh,
    factors: Option<&[f64]>,
    s: &Array2<f64>,
    seeds: &Seeds,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    request.check()?;
    regions::check(s.ncols())?;
    request.relaxation.check(s.ncols())?;
    check_rows("costs", s.nrows(), mesh)?;
    check_factors(factors, mesh.faces.len())?;
    seeds.check(s.nrows(), s.ncols())?;
    start.check(s.dim())?;
    let (known, mut warnings) = costs::checked(s, request.mass)?;
    let (model, left_out) = model_mesh(mesh)?;
    warnings.extend(left_out);
    let order = Order::of(&model);
    warnings.extend(unreached::warning((&*model).into(), |k| {
        !s[[k, 0]].is_nan() || seeds.region(k).is_some()
    }));
    let model = order.mesh(model);
    let factors = factors.map(|factors| {
        let kept: Vec<usize> = (0..mesh.faces.len()).filter(|&j| !mesh.is_degenerate(j)).collect();
        let moved = order.faces(kept.len()).into_iter().map(|j| factors[kept[j]]);
        moved.collect::<Vec<f64>>()
    });
    let domain = match &factors {
        None => Domain::Vertices(&model),
        Some(factors) => Domain::Weighted(&model, factors),
    };
    let given = Given { s: &known, seeds: &seeds.in_order(&order), start, unit: None };
    let solution = solve_given(domain, &order, warnings, given, request, observe)?;
    Ok(solution.in_file_order(mesh, &order))
}

/// Minimizes E over labels of the faces of a mesh, see [`crate::domain`], for pointwise costs s (F x m). The costs of a
/// face count with its area, cuts with their length, times what the contrast says; NaN in a whole row marks it as
/// unknown. `seeds` are faces whose labels are given.
///
/// Fails as [`solve_seeded`] does, for rows of faces in place of vertices, and if the request asks for what there is on
/// vertices only: coarse to fine, and the dual field.
pub fn solve_on_faces(
    mesh: &Mesh,
    contrast: Option<&Contrast>,
    s: &Array2<f64>,
    seeds: &Seeds,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    request.check()?;
    let only_on_vertices = [
        (request.coarse_to_fine, "solving from coarse to fine"),
        (request.keep_dual, "saving the dual field"),
        (request.mass != Mass::Barycentric, "another mass than barycentric"),
    ];
    if let Some((_, what)) = only_on_vertices.iter().find(|(wanted, _)| *wanted) {
        return Err(Error::unsuitable(format!(
            "{what} is for labels of vertices only: leave it out, or label the vertices"
        )));
    }
    regions::check(s.ncols())?;
    request.relaxation.check(s.ncols())?;
    check_rows_of_faces("costs", s.nrows(), mesh)?;
    seeds.check(s.nrows(), s.ncols())?;
    start.check(s.dim())?;
    let (known, mut warnings) = costs::checked(s, Mass::Barycentric)?;
    let dual = dual_of(mesh, contrast)?;
    warnings.extend(unreached::warning((&dual).into(), |j| {
        !s[[j, 0]].is_nan() || seeds.region(j).is_some()
    }));
    let (order, dual) = dual.ordered();
    let given = Given { s: &known, seeds: &seeds.in_order(&order), start, unit: None };
    let solution = solve_given((&dual).into(), &order, warnings, given, request, observe)?;
    Ok(solution.of_faces(mesh, &order))
}

/// The faces of a mesh and the pairs of them, with weights of the contrast.
///
/// Fails if no face has an area, or a weight of a face is not positive and finite.
pub(crate) fn dual_of(mesh: &Mesh, contrast: Option<&Contrast>) -> Result<Dual> {
    check_mesh(mesh)?;
    if let Some(Contrast::Faces(factors)) = contrast {
        check_factors(Some(factors), mesh.faces.len())?;
    }
    Ok(contrast.map_or_else(|| Dual::new(mesh), |contrast| contrast.dual(mesh)))
}

fn check_factors(factors: Option<&[f64]>, faces: usize) -> Result<()> {
    let Some(factors) = factors else { return Ok(()) };
    if factors.len() != faces {
        return Err(Error::unsuitable(format!(
            "there are {}, but the mesh has {}; supply one weight per face",
            counted(factors.len(), "weight", "weights"),
            counted(faces, "face", "faces")
        )));
    }
    match factors.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
        None => Ok(()),
        Some(j) => Err(Error::unsuitable(format!(
            "the weight of face {j} is {:?}: weights must be positive and finite, so that no cut is free",
            factors[j]
        ))),
    }
}

/// Costs and start in the order of the caller, seeds in that of the domain.
struct Given<'a> {
    s: &'a Array2<f64>,
    seeds: &'a Seeds,
    start: &'a Start,
    /// The unit of the costs and of lambda, if it is not 1.
    unit: Option<Unit>,
}

/// The solution in the order of the domain, found in a unit of cost that suits it. Not generic, so that it is compiled
/// once.
fn solve_given(
    domain: Domain<'_>,
    order: &Order,
    warnings: Vec<String>,
    given: Given<'_>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    let m = given.s.ncols();
    let Some(unit) = Unit::of(given.s, request.lambda, domain.area().sqrt()) else {
        return with_regions!(m, solve_compiled(domain, order, warnings, given, request, observe));
    };
    let request = &Request { lambda: unit.of_number(request.lambda), ..request.clone() };
    let given = Given { s: &unit.of_array(given.s), unit: Some(unit), ..given };
    let mut observe =
        |sample: Option<&Sample>| observe(sample.map(|sample| sample.given(unit)).as_ref());
    let observe = &mut observe;
    with_regions!(m, solve_compiled(domain, order, warnings, given, request, observe))?.given(unit)
}

fn solve_compiled<const M: usize>(
    domain: Domain<'_>,
    order: &Order,
    warnings: Vec<String>,
    given: Given<'_>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    let Given { s, seeds, start, unit } = given;
    let m = s.ncols();
    let s = order.applied(regions::rows(s.view()));
    let problem = seeded_problem::<M>(domain, m, s, seeds, request)?;
    let beginning = match domain {
        Domain::Vertices(mesh) | Domain::Weighted(mesh, _)
            if request.coarse_to_fine && !coarse::is_certified(&problem, request) =>
        {
            Some(coarse::start(mesh, &problem, request, observe)?)
        }
        _ => None,
    };
    let (pair, record) = beginning.map(|begin| (begin.pair, begin.record)).unzip();
    let (start, dual_start) = match pair.flatten() {
        Some(Pair { u, q }) => (u, Some(q)),
        None => (start.rows(m, &problem.f, order), None),
    };
    let mut run = Run::new(&start);
    if request.needs_dual() {
        run.keep_dual();
    }
    let setup = Setup { domain, problem: &problem, start, dual_start };
    let mut solver = request.method.build(setup)?;
    let spent = record.as_ref().map_or(Duration::ZERO, |record| record.spent);
    run.charge(spent);
    let stop = request.stop.after(spent);
    let status = run.advance(&mut *solver, &problem, &stop, observe);
    let mut solution =
        conclude(domain, &problem, m, request, Ended { run, status, warnings }, observe);
    solution.summary.coarse_to_fine = record;
    // A user who interrupts a run, or the search for labels after it, does not want to wait for advice.
    let status = solution.summary.status;
    if status != Status::Interrupted {
        let done = !matches!(status, Status::IterationLimit | Status::TimeLimit);
        let warning = empty_warning(
            domain,
            &problem,
            m,
            (&solution.summary.empty_regions, done),
            unit,
            request,
            observe,
        )?;
        solution.summary.warnings.extend(warning);
    }
    Ok(solution)
}

/// A warning about empty regions. For those that are the cheapest at some vertex, a smaller lambda is searched on a
/// coarse mesh.
fn empty_warning<const M: usize>(
    domain: Domain<'_>,
    problem: &Problem<Stencil, M>,
    m: usize,
    (empty, done): (&[usize], bool),
    unit: Option<Unit>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<String>> {
    if empty.is_empty() {
        return Ok(None);
    }
    let cheapest: Array1<i32> = problem.f.iter().map(|f| f.argmin() as i32).collect();
    let never_cheapest = empty_regions::of_labels(&cheapest, m);
    let (never_cheapest, lost): (Vec<usize>, Vec<usize>) =
        empty.iter().partition(|p| never_cheapest.contains(p));
    let mut sentences = Vec::new();
    if !never_cheapest.is_empty() {
        sentences.push(format!(
            "{}: no {} has its smallest cost there; check the costs",
            empty_regions::sentence(&never_cheapest),
            domain.element().nouns()[0]
        ));
    }
    if !lost.is_empty() && !done {
        sentences.push(format!(
            "{} so far: the run ended before the gap was reached; raise its limit",
            empty_regions::sentence(&lost)
        ));
    } else if !lost.is_empty() {
        let found = match domain {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => {
                coarse::separating_lambda(mesh, problem, &lost, request, observe)?
            }
            Domain::Faces(_) => None,
        };
        let advice = match found {
            // The coarse mesh may keep a region up to a slightly larger lambda than the fine one.
            Some(lambda) => {
                let lambda = unit.map_or(0.5 * lambda, |unit| unit.given(0.5 * lambda));
                format!("try --lambda {lambda:.1e}")
            }
            None => "try a much smaller --lambda".into(),
        };
        sentences.push(format!(
            "{}: lambda is too large for these costs; {advice}",
            empty_regions::sentence(&lost)
        ));
    }
    Ok(Some(sentences.join("; ")))
}

/// The problem of pointwise costs s for m regions: costs are integrated, padding regions forbidden.
pub(crate) fn problem_of<const M: usize>(
    model: &Mesh,
    m: usize,
    s: Vec<Row<M>>,
    request: &Request,
) -> Result<Problem<Stencil, M>> {
    seeded_problem(model.into(), m, s, &Seeds::default(), request)
}

/// The same with seeds, in the order of the domain.
fn seeded_problem<const M: usize>(
    domain: Domain<'_>,
    m: usize,
    s: Vec<Row<M>>,
    seeds: &Seeds,
    request: &Request,
) -> Result<Problem<Stencil, M>> {
    let (mut f, k) =
        sweep::join(|| integrate(&domain.quadrature(request.mass), m, &s), || domain.stencil());
    seeds.constrain(&mut f)?;
    let problem = Problem::new(k, f, request.lambda).in_relaxation(request.relaxation);
    check_range(&problem)?;
    Ok(problem)
}

/// f = M s. A label that s forbids is forbidden by f, also where a vertex has no area.
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
            *f =
                Row::from_fn(
                    |p| if p < m && s.0[p] < f64::INFINITY { f.0[p] } else { FORBIDDEN_COST },
                );
        },
    );
    f
}

#[cfg(test)]
mod tests;
