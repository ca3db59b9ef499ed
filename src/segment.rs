//! Segmentation of data: the alternation of the labels U and the region parameters, then a certificate.
//!
//! The parameters are re-estimated every r steps of U (r = 10 in the paper) until they settle. A bound holds for fixed
//! costs only, so each re-estimation voids it; after the last one the problem is solved to the requested gap, and that
//! gap is a certificate for the parameters found. Delaunoy et al., ICCV 2009, section 3.2.
//!
//! A [`DataModel`] defines the parameters, their costs and their fit.
//!
//! Two regions with the same parameters are merged, and one of them is left empty: `segment/merging.rs`.
//!
//! Coarse to fine, each coarser mesh is segmented first and passes on U, q and the parameters. `segment/lambda.rs`
//! chooses lambda if none is given.

mod alternation;
mod coarse;
pub mod count;
mod estimate;
pub mod lambda;
mod merging;

use std::time::Duration;

use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::coarse::{Pair, is_certified};
use crate::counted::counted;
use crate::data::{DataModel, Scale, Weights};
use crate::empty_regions;
use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::order::Order;
use crate::regions::{self, with_regions};
use crate::run::{Sample, Status};
use crate::solve::{Ended, Observer, Request, Solution, check_rows, conclude, model_mesh};
use crate::units::Unit;
use crate::unreached;

pub use alternation::Alternation;
use alternation::{AlternationOutcome, JointProblem, MAX_ESTIMATES};
use estimate::{Estimate, ModelEstimate};

/// The result of a segmentation; P are the region parameters of its model.
pub struct Segmentation<P> {
    /// Labels, energies and bounds, for the final parameters.
    pub solution: Solution,
    /// mu, one per region; the final gap is a certificate for them.
    pub parameters: Vec<P>,
    /// Number of re-estimations.
    pub estimates: usize,
}

/// Segments data on a mesh as it is, without scaling. The model has a datum for each vertex of the mesh. For `observe`
/// see [`Observer`]. Panics if `every` is 0.
///
/// Fails if lambda, a setting of the solver or the number of regions is out of range, the model or the initial labels
/// have another number of vertices than the mesh, an initial label is none of a region, no face has an area, the integrated costs leave the range of double precision, or a fit of
/// the model fails.
pub fn segment<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Segmentation<D::Parameters>> {
    request.check()?;
    regions::check(alternation.regions)?;
    request.relaxation.check(alternation.regions)?;
    assert!(alternation.every > 0);
    check_rows("data", model.vertices(), mesh)?;
    let (usable, mut warnings) = model_mesh(mesh)?;
    warnings.extend(unreached::warning((&*usable).into(), |k| {
        model.is_known(k) || alternation.seeds.region(k).is_some()
    }));
    let mut rng = Pcg64::seed_from_u64(alternation.seed);
    let weights = request.mass.weights(&usable);
    let m = alternation.regions;
    let mut mu = model.start(alternation.initial, m, &weights, &mut rng)?;
    if let Some(labels) = &alternation.labels {
        check_rows("initial labels", labels.len(), mesh)?;
        check_labels(labels, m)?;
        fit_labels(model, labels, &weights, &mut mu)?;
    }
    alternation.seeds.check(mesh.vertices.len(), m)?;
    let order = Order::of(&usable);
    let usable = order.mesh(usable);
    let labels = alternation.labels.clone().map(|labels| order.applied(labels));
    let seeds = alternation.seeds.in_order(&order);
    let alternation = &Alternation { labels, seeds, ..alternation.clone() };
    let mut estimate = ModelEstimate::new(model.in_order(&order), mu);
    let (solution, estimates) =
        segment_estimate(&usable, warnings, &mut estimate, alternation, request, observe)?;
    let solution = solution.in_file_order(mesh, &order);
    Ok(Segmentation { solution, parameters: estimate.into_parameters(), estimates })
}

fn check_labels(labels: &[usize], m: usize) -> Result<()> {
    match labels.iter().position(|&label| label >= m) {
        None => Ok(()),
        Some(k) => Err(Error::unsuitable(format!(
            "the initial label of vertex {k} is {}; labels must be from 0 to {}",
            labels[k],
            m - 1
        ))),
    }
}

/// Fits the parameters to labels; `weights` are int phi_k.
fn fit_labels<D: DataModel>(
    model: &D,
    labels: &[usize],
    weights: &[f64],
    mu: &mut [D::Parameters],
) -> Result<()> {
    let m = mu.len();
    let mut numbers = vec![0.0; m * labels.len()];
    for ((row, &p), &w) in numbers.chunks_mut(m).zip(labels).zip(weights) {
        row[p] = w;
    }
    model.fit(Weights::new(&numbers, m), mu).map(drop)
}

/// The solution, found in a unit of cost that suits it, and the number of re-estimations. Not generic, so that it is
/// compiled here and not where it is called.
fn segment_estimate(
    mesh: &Mesh,
    warnings: Vec<String>,
    estimate: &mut dyn Estimate,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<(Solution, usize)> {
    let m = alternation.regions;
    let scale = estimate.scale(&request.mass.weights(mesh));
    let size = f64::max(scale.cost, request.lambda / mesh.area().sqrt());
    let Some(unit) = Unit::of_size(size) else {
        return with_regions!(
            m,
            segment_compiled(
                mesh,
                warnings,
                (estimate, scale),
                alternation,
                None,
                request,
                observe
            )
        );
    };
    estimate.set_unit(unit);
    let request = &Request { lambda: unit.of_number(request.lambda), ..request.clone() };
    let mut observe =
        |sample: Option<&Sample>| observe(sample.map(|sample| sample.given(unit)).as_ref());
    let (observe, unit_of_costs) = (&mut observe, Some(unit));
    let (solution, estimates) = with_regions!(
        m,
        segment_compiled(
            mesh,
            warnings,
            (estimate, scale),
            alternation,
            unit_of_costs,
            request,
            observe
        )
    )?;
    Ok((solution.given(unit)?, estimates))
}

fn segment_compiled<const M: usize>(
    mesh: &Mesh,
    mut warnings: Vec<String>,
    (estimate, scale): (&mut dyn Estimate, Scale),
    alternation: &Alternation,
    unit: Option<Unit>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<(Solution, usize)> {
    let m = alternation.regions;
    let mass = request.mass.on(mesh);
    let joint = JointProblem {
        mesh,
        mass: &mass,
        scale,
        seeds: &alternation.seeds,
        alternation,
        request,
        is_finest: true,
    };
    let mut problem = joint.problem::<M>(estimate)?;
    let start = |labels: &Vec<usize>| Pair {
        u: labels.iter().map(|&p| Row::one_hot(p)).collect(),
        q: vec![Tangent::ZERO; mesh.faces.len()],
    };
    let (mut pair, mut record) = (alternation.labels.as_ref().map(start), None);
    if request.coarse_to_fine && !is_certified(&problem, request) {
        let spent;
        (pair, spent) = coarse::start(&joint, estimate, observe)?;
        problem.set_costs(joint.costs(estimate, &vec![true; m])?);
        record = Some(spent);
    }
    let spent = record.as_ref().map_or(Duration::ZERO, |record| record.spent);
    let stop = request.stop.after(spent);
    let AlternationOutcome { problem, run, status, estimates, settled, active, .. } =
        joint.alternate(estimate, problem, pair, spent, &stop, observe)?;

    if !settled || estimates == MAX_ESTIMATES {
        // A contradicted bound certifies nothing.
        let certificate = match status {
            Status::Contradicted => "",
            _ => "; the certificate holds for the last estimate",
        };
        // The limit that ended the run, if there is one that can be raised.
        let advice = match status {
            Status::IterationLimit => "; raise --max-iterations",
            Status::TimeLimit => "; raise --time-limit",
            _ => "",
        };
        warnings.push(format!(
            "the region parameters still changed after {}{certificate}{advice}",
            counted(estimates, "re-estimation", "re-estimations")
        ));
    }
    let mut solution =
        conclude(mesh.into(), &problem, m, request, Ended { run, status, warnings }, observe);
    solution.summary.coarse_to_fine = record;
    let empty = &solution.summary.empty_regions;
    let warning = match solution.summary.status {
        // A user who interrupts a run, or the search for labels after it, does not want to wait for advice.
        Status::Interrupted => None,
        _ if empty.is_empty() => None,
        Status::IterationLimit | Status::TimeLimit => Some(format!(
            "{} so far: the run ended before the gap was reached; raise its limit",
            empty_regions::sentence(empty)
        )),
        _ => empty_warning(&joint, estimate, unit, empty, &active, observe)?,
    };
    solution.summary.warnings.extend(warning);
    Ok((solution, estimates))
}

/// A warning about empty regions, with a remedy. That all data are equal is reported, with their name, where they are
/// read: `data/input.rs`, `data/curved.rs`.
fn empty_warning(
    joint: &JointProblem<'_>,
    estimate: &dyn Estimate,
    unit: Option<Unit>,
    empty: &[usize],
    active: &[bool],
    observe: Observer<'_>,
) -> Result<Option<String>> {
    let &JointProblem { mesh, alternation, request, .. } = joint;
    let different = estimate.different(alternation.regions);
    if different == 1 {
        return Ok(None);
    }
    if different < alternation.regions {
        return Ok(Some(format!(
            "{}: the data have only {different} different values; use --regions {different}",
            empty_regions::sentence(empty)
        )));
    }
    let half = 0.5 * request.lambda;
    let fewer = alternation.regions - empty.len();
    let found = match half > 0.0 {
        true => {
            let request = Request { lambda: half, ..request.clone() };
            let found = lambda::find_separating(mesh, estimate, alternation, &request, observe)?;
            // No lambda creates regions that the data do not have.
            found.lambda.filter(|_| found.regions == alternation.regions)
        }
        false => None,
    };
    let advice = match found {
        // The coarse mesh may keep a region up to a slightly larger lambda than the fine one.
        Some(lambda) => {
            let lambda = unit.map_or(0.5 * lambda, |unit| unit.given(0.5 * lambda));
            format!("lambda is too large for these data; try --lambda {lambda:.1e}")
        }
        None if fewer > 1 => format!(
            "the data do not separate into {} regions; use --regions {fewer}",
            alternation.regions
        ),
        None => "the data do not separate into regions; choose other data".into(),
    };
    let merged = active.iter().any(|active| !active);
    let cause = match merged {
        true => format!(", since regions with the same {} were merged", estimate.value_name()),
        false => String::new(),
    };
    Ok(Some(format!("{}{cause}: {advice}", empty_regions::sentence(empty))))
}

#[cfg(test)]
mod tests;
