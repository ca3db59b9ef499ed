//! Segmentation of data: the alternation of the labels U and the region parameters, then a certificate.
//!
//! The parameters are re-estimated every r steps of U (the paper takes r = 10) until they settle. A bound
//! holds for fixed costs only, so it is void at each re-estimation; after the last one the problem is
//! solved to the requested gap, and that gap is a certificate for the parameters found.
//! Delaunoy et al., ICCV 2009, section 3.2.
//!
//! What the parameters are, what they cost and how they are fitted is the business of a [`DataModel`].
//!
//! Two regions with the same parameters become one, and the other is empty: `segment/unions.rs`.
//!
//! Coarse to fine, each coarser mesh goes through the same first, and passes on U, q and the parameters. What lambda is
//! taken where none is given: `segment/lambda.rs`.

mod alternation;
mod coarse;
pub mod lambda;
mod unions;

use std::time::Duration;

use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::coarse::is_certified;
use crate::data::DataModel;
use crate::error::Result;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::order::Order;
use crate::regions::{self, with_regions};
use crate::remarks::named;
use crate::run::Status;
use crate::solve::{Observer, Request, Solution, check_rows, conclude, model_mesh};
use crate::unreached::unreached;

pub use alternation::Alternation;
use alternation::{Found, Level, MOST_ESTIMATES};

/// What a segmentation ends with; P are the parameters of its model.
pub struct Segmentation<P> {
    /// Labels, energies and bounds, for the final parameters.
    pub solution: Solution,
    /// mu, one per region; what the final gap is a certificate for.
    pub parameters: Vec<P>,
    /// How often they were re-estimated.
    pub estimates: usize,
}

/// Segments data on a mesh as it is: no scaling. The model has a datum for each vertex of the mesh. `observe` is called
/// as [`Observer`] says. Panics if `every` is 0.
///
/// Fails if lambda, a setting of the solver or the number of regions is out of range, the model has another number of
/// vertices than the mesh, no face has an area, the integrated costs leave the range of double precision, or a fit of
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
    assert!(alternation.every > 0);
    check_rows("data", model.vertices(), mesh)?;
    let (sound, mut warnings) = model_mesh(mesh)?;
    warnings.extend(unreached(&sound, |k| model.is_known(k)));
    let mut rng = Pcg64::seed_from_u64(alternation.seed);
    let weights = request.mass.weights(&sound);
    let mu = model.start(alternation.initial, alternation.regions, &weights, &mut rng)?;
    let order = Order::of(&sound);
    let (sound, model) = (order.mesh(sound), model.in_order(&order));
    let segmentation = with_regions!(
        alternation.regions,
        segment_compiled::<D>(&sound, warnings, &*model, mu, alternation, request, observe)
    )?;
    Ok(Segmentation { solution: segmentation.solution.of(mesh, &order), ..segmentation })
}

fn segment_compiled<const M: usize, D: DataModel>(
    mesh: &Mesh,
    mut warnings: Vec<String>,
    model: &D,
    mut mu: Vec<D::Parameters>,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Segmentation<D::Parameters>> {
    let m = alternation.regions;
    let mass = request.mass.on(mesh);
    let integrate = |s: &[Row<M>]| mass.integrate(s);
    let scale = model.scale(&request.mass.weights(mesh));
    let level =
        Level { mesh, model, integrate: &integrate, scale, alternation, request, unite: true };
    let mut problem = level.problem(&mu)?;
    let (mut pair, mut record) = (None, None);
    if request.coarse_to_fine && !is_certified(&problem, request) {
        let spent;
        (mu, pair, spent) = coarse::start(&level, mu, observe)?;
        problem.set_costs(level.costs(&mu, &vec![true; m]));
        record = Some(spent);
    }
    let spent = record.as_ref().map_or(Duration::ZERO, |record| record.spent);
    let stop = request.stop.after(spent);
    let Found { problem, run, status, mu, estimates, settled, open, .. } =
        level.alternate(problem, mu, pair, spent, &stop, observe)?;

    if !settled || estimates == MOST_ESTIMATES {
        // Contradicted bounds certify nothing.
        let certificate = match status {
            Status::Contradicted => "",
            _ => "; the certificate holds for the last ones",
        };
        // About what ended them, if it can be moved. Who breaks off does not want to wait for advice.
        let advice = match status {
            Status::IterationLimit => "; raise --max-iterations",
            Status::TimeLimit => "; raise --time-limit",
            _ => "",
        };
        warnings.push(format!(
            "the region parameters still moved after {estimates} re-estimations{certificate}{advice}"
        ));
    }
    let mut solution = conclude(mesh, &problem, m, request, run, status, warnings);
    solution.summary.coarse_to_fine = record;
    let empty = &solution.summary.empty_regions;
    let said = match status {
        // Who breaks off does not want to wait for advice.
        Status::Interrupted => None,
        _ if empty.is_empty() => None,
        Status::IterationLimit | Status::TimeLimit => {
            Some(format!("{} so far: the run ended before its gap was reached", named(empty)))
        }
        _ => remark(&level, empty, &open, observe)?,
    };
    solution.summary.warnings.extend(said);
    Ok(Segmentation { solution, parameters: mu, estimates })
}

/// What must be said where the labels are fewer than what was asked for. That all data are the same says who has them,
/// with their name: `data/input.rs`, `data/curved.rs`.
fn remark<D: DataModel, const M: usize>(
    level: &Level<'_, D, M>,
    empty: &[usize],
    open: &[bool],
    observe: Observer<'_>,
) -> Result<Option<String>> {
    let &Level { mesh, model, alternation, request, .. } = level;
    let different = model.different(alternation.regions);
    if different == 1 {
        return Ok(None);
    }
    if different < alternation.regions {
        return Ok(Some(format!(
            "{}: the data have only {different} different values; ask for {different} regions",
            named(empty)
        )));
    }
    let half = 0.5 * request.lambda;
    let fewer = alternation.regions - empty.len();
    let found = match half > 0.0 {
        true => {
            let request = Request { lambda: half, ..request.clone() };
            let found = lambda::separating(mesh, model, alternation, &request, observe)?;
            // No lambda makes regions that the data do not have.
            found.lambda.filter(|_| found.regions == alternation.regions)
        }
        false => None,
    };
    let advice = match found {
        // The coarse mesh may keep a region a little longer than the fine one.
        Some(lambda) => {
            let lambda = 0.5 * lambda;
            format!("lambda is too large for these data; try --lambda {lambda:.1e}")
        }
        None if fewer > 1 => format!(
            "the data do not separate into {} regions; ask for {fewer}",
            alternation.regions
        ),
        None => "the data do not separate into regions; choose other data".into(),
    };
    let one = open.iter().any(|open| !open);
    let cause = match one {
        true => format!(", since regions with one {} became one", D::TOLD),
        false => String::new(),
    };
    Ok(Some(format!("{}{cause}: {advice}", named(empty))))
}

#[cfg(test)]
mod tests;
