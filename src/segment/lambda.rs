//! A default lambda for data of any kind, and a smaller lambda that keeps the regions which a given one empties.
//!
//! ```text
//! lambda_i = 0.02 (scale of the costs) sqrt(area) / 2^i              for constant data the variance without outliers
//! R(U)     = min_mu int s_mu - min_mu sum_p int u_p s_{mu_p}         costs that labels explain, relative to one region
//! ```
//!
//! lambda_0 weighs a cut as much as an error of one standard deviation within a fiftieth of the size of the surface.
//! This suits colors and textures, but empties all regions but one where the data vary over shorter distances, as
//! curvature does. So lambda is halved until, on a coarse mesh with the model restricted to it, no region that the
//! clusters of the data use is empty and the labels explain at least two thirds of what the clusters explain, which
//! ignore cuts. Data of coarse vertices have little noise, so noise does not make lambda smaller.

use std::borrow::Cow;
use std::time::Instant;

use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::alternation::{Alternation, JointProblem};
use super::estimate::{Estimate, ModelEstimate};
use crate::coarse::Hierarchy;
use crate::data::{DataModel, Initial, Scale, Weights};
use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::operator::{Mass, Quadrature};
use crate::problem::rounded;
use crate::regions::with_regions;
use crate::run::Stop;
use crate::seeds::Seeds;
use crate::solve::{Observer, Request, model_mesh};

/// Maximum number of vertices of the mesh on which lambdas are tried.
const MAX_TRIAL_VERTICES: usize = 4000;

/// Relative gap of a trial: its labels need not be exact.
const TRIAL_GAP: f64 = 1e-2;

/// Maximum number of steps of a trial. A region may vanish late: the last of three bands of a sphere after 340.
const MAX_TRIAL_STEPS: u64 = 400;

/// Maximum number of lambdas that are tried, each half of the previous one.
const MAX_TRIALS: i32 = 14;

/// The fraction of what the clusters explain that labels must explain.
const EXPLAINED_SHARE: f64 = 2.0 / 3.0;

/// The default lambda for data of any kind: the first of lambda_0, lambda_1, ... that loses no region, or lambda_0 if
/// all of them do.
///
/// # Errors
/// Data whose costs leave the range of double precision, and a fit that fails.
pub fn of_data<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let estimate = &ModelEstimate::new(Cow::Borrowed(model), Vec::new());
    of_estimate(mesh, estimate, alternation, request, observe)
}

/// Not generic, so that it is compiled here.
fn of_estimate(
    mesh: &Mesh,
    estimate: &dyn Estimate,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let cells = barycentric_areas(mesh);
    let initial = initial_lambda(estimate.scale(&cells).cost, cells.iter().sum());
    if !initial.is_finite() {
        return Err(Error::unsuitable(
            "the costs of the data leave the range of double precision; scale the data down",
        ));
    }
    let (usable, _) = model_mesh(mesh)?;
    let request = Request { lambda: initial, ..request.clone() };
    let found = find_separating(&usable, estimate, alternation, &request, observe)?;
    Ok(found.lambda.unwrap_or(initial))
}

/// lambda_0 for costs of the given scale on a surface of the given area.
fn initial_lambda(cost: f64, area: f64) -> f64 {
    0.02 * cost * area.sqrt()
}

/// The result of a search for lambda.
pub(super) struct Separation {
    /// How many distinct regions, larger than a speck, the clusters of the data have.
    pub regions: usize,
    /// The first lambda that keeps all of these and explains enough; `None` if all fail.
    pub lambda: Option<f64>,
}

/// Searches lambda, lambda / 2, ..., starting with that of the request, for the first that leaves no region empty and
/// explains enough. The mesh has no faces without area.
///
/// # Errors
/// Costs that leave the range of double precision, and a fit that fails.
pub(super) fn find_separating(
    mesh: &Mesh,
    estimate: &dyn Estimate,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Separation> {
    with_regions!(
        alternation.regions,
        find_separating_compiled(mesh, estimate, alternation, request, observe)
    )
}

fn find_separating_compiled<const M: usize>(
    finest: &Mesh,
    estimate: &dyn Estimate,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Separation> {
    let begin = Instant::now();
    let estimate = &mut *estimate.without_parameters();
    let (hierarchy, known) = coarse_weights(finest, estimate, request.mass);
    let mesh = hierarchy.levels.last().map_or(finest, |level| &level.mesh);
    let mut rng = Pcg64::seed_from_u64(alternation.seed);
    estimate.start(Initial::KMeans, alternation.regions, &known, &mut rng)?;

    let mass = Quadrature::Lumped(known.clone());
    let scale = estimate.scale(&known);
    let stop = Stop {
        relative_gap: Some(TRIAL_GAP),
        iterations: Some(MAX_TRIAL_STEPS),
        ..request.stop.after(begin.elapsed())
    };
    let clusters = Explained::of(&labels_without_cuts::<M>(estimate), estimate, &known, scale)?;
    let seeds = &Seeds::default();
    let not_found = Separation { regions: clusters.regions, lambda: None };
    if clusters.costs <= 0.0 {
        return Ok(not_found);
    }
    for i in 0..MAX_TRIALS {
        let request = &Request { lambda: request.lambda * 0.5_f64.powi(i), ..request.clone() };
        let is_finest = false;
        let joint =
            JointProblem { mesh, mass: &mass, scale, seeds, alternation, request, is_finest };
        estimate.reset();
        let problem = joint.problem::<M>(estimate)?;
        let mut flow = std::ops::ControlFlow::Continue(());
        let mut observe = |_: Option<&_>| {
            flow = observe(None);
            flow
        };
        let spent = begin.elapsed();
        let found = joint.alternate(estimate, problem, None, spent, &stop, &mut observe)?;
        if flow.is_break() {
            return Ok(not_found);
        }
        let reached = Explained::of(&rounded(found.run.best_u()), estimate, &known, scale)?;
        if reached.regions >= clusters.regions && reached.costs >= EXPLAINED_SHARE * clusters.costs
        {
            return Ok(Separation { lambda: Some(request.lambda), ..not_found });
        }
    }
    Ok(not_found)
}

/// Restricts the model to the coarse mesh on which choices are tried: the last level. Returns the levels and the weights
/// of its vertices, 0 where the data are unknown.
pub(super) fn coarse_weights<'a>(
    finest: &'a Mesh,
    estimate: &mut dyn Estimate,
    mass: Mass,
) -> (Hierarchy<'a>, Vec<f64>) {
    let hierarchy = Hierarchy::down_to(finest, MAX_TRIAL_VERTICES);
    let mut weights = mass.weights(finest);
    for level in &hierarchy.levels {
        weights = estimate.restrict(level, &weights);
    }
    let known = |(k, &w): (usize, &f64)| if estimate.is_known(k) { w } else { 0.0 };
    let known = weights.iter().enumerate().map(known).collect();
    (hierarchy, known)
}

/// The labels of minimum cost at each vertex, ignoring cuts.
pub(super) fn labels_without_cuts<const M: usize>(estimate: &dyn Estimate) -> Vec<Row<M>> {
    let s: Vec<Row<M>> = estimate.costs();
    let cheapest = |s: &Row<M>| (0..estimate.regions()).min_by(|&a, &b| s.0[a].total_cmp(&s.0[b]));
    s.iter().map(|s| Row::one_hot(cheapest(s).expect("there are regions"))).collect()
}

/// How well labels explain the data.
pub(super) struct Explained {
    /// R(U).
    pub costs: f64,
    /// The costs that are left.
    pub within: f64,
    /// Number of regions that are larger than a speck and have distinct parameters.
    pub regions: usize,
}

/// A region of less than this fraction of the area is a speck.
const SPECK_AREA_SHARE: f64 = 1e-3;

/// Regions are distinct if their distance exceeds this fraction of the scale of distances, for constant data the
/// standard deviation. With 0.1, two regions of a photograph and two of six on Spot counted as distinct although the
/// fine mesh merged them; 0.2 and 0.3 distinguish the same regions on all data tried.
const DISTINCT_DISTANCE: f64 = 0.25;

impl Explained {
    /// For one-hot labels and the weights of the known vertices; fits start from the initial parameters.
    pub fn of<const M: usize>(
        labels: &[Row<M>],
        estimate: &mut dyn Estimate,
        known: &[f64],
        scale: Scale,
    ) -> Result<Self> {
        let mut fitted = |labels: &dyn Fn(usize) -> Row<M>| -> Result<f64> {
            let weights: Vec<Row<M>> =
                known.iter().enumerate().map(|(k, &w)| labels(k) * w).collect();
            estimate.reset();
            estimate.fit(Weights::of(&weights))?;
            Ok(estimate.costs::<M>().iter().zip(&weights).map(|(&s, w)| w.dot(s)).sum())
        };
        let one = fitted(&|_| Row::one_hot(0))?;
        let within = fitted(&|k| labels[k])?;
        let mut mass = vec![0.0; estimate.regions()];
        labels.iter().zip(known).for_each(|(u, &w)| mass[u.argmax()] += w);
        let total: f64 = mass.iter().sum();
        let mut different: Vec<usize> = Vec::new();
        for (p, mass) in mass.into_iter().enumerate() {
            let distinct =
                |&other: &usize| estimate.distance(p, other) > DISTINCT_DISTANCE * scale.distance;
            if mass > SPECK_AREA_SHARE * total && different.iter().all(distinct) {
                different.push(p);
            }
        }
        Ok(Explained { costs: one - within, within, regions: different.len() })
    }
}

#[cfg(test)]
mod tests;
