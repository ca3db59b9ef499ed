//! Labels of data by a method that is chosen by name: a data model, whose parameters are estimated or given, or a
//! baseline that ignores cuts.
//!
//! A baseline has the parameters of its own classes; the energy of its labels, and the bound below it, are those of the
//! piecewise constant model with these parameters.

mod baseline;
mod seeded;

use std::ops::RangeInclusive;

use ndarray::{Array1, Array2};

use crate::data::{Data, DataModel, ModelName, ModelTask, Observed, PiecewiseConstant};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::names::Named;
use crate::operator::Mass;
use crate::regions::check as check_regions;
use crate::seeds::Seeds;
use crate::segment::count::{self, Count};
use crate::segment::{Alternation, Segmentation, lambda, segment};
use crate::solve::{Observer, Request, Solution, check_rows, model_mesh, solve_seeded};
use crate::start::Start;

pub use baseline::{Baseline, labeled};
use seeded::initial_labels;

/// What labels the data.
#[derive(Clone, Debug)]
pub enum Labeler {
    /// A data model, whose parameters are re-estimated.
    Estimated(ModelName),
    /// A data model with given parameters, one map per region, as in `summary.json`.
    Given(ModelName, Vec<serde_json::Value>),
    /// A baseline.
    Baseline(Baseline),
}

impl Labeler {
    /// The name of the model or the baseline.
    pub fn name(&self) -> &'static str {
        match self {
            Labeler::Estimated(model) | Labeler::Given(model, _) => model.name(),
            Labeler::Baseline(baseline) => baseline.name(),
        }
    }
}

/// Labels and the parameters of their regions.
pub struct Labeling {
    /// Labels, energies and bounds, for these parameters.
    pub solution: Solution,
    /// One per region.
    pub regions: Vec<RegionParameters>,
    /// [`DataModel::VALUE_NAME`].
    pub value_name: &'static str,
    /// Number of re-estimations.
    pub estimates: usize,
}

/// mu_p.
#[derive(Clone, Debug)]
pub struct RegionParameters {
    /// A map, under the names of the model.
    pub all: serde_json::Value,
    /// [`DataModel::value`].
    pub value: Vec<f64>,
}

impl RegionParameters {
    fn of<D: DataModel>(mu: &D::Parameters) -> Self {
        let all = serde_json::to_value(mu).expect("a map of numbers");
        RegionParameters { all, value: D::value(mu).to_vec() }
    }
}

/// Labels data on a mesh as it is, without scaling. Without lambda, the request gets the one that suits the data, see
/// [`lambda`]. For `observe` see [`Observer`].
///
/// # Errors
/// Those of [`segment`], [`solve_seeded`] and [`labeled`], data that the model cannot describe, and parameters that are not
/// those of the model, or of data of another dimension.
pub fn label(
    mesh: &Mesh,
    observed: Observed<'_>,
    labeler: &Labeler,
    alternation: &Alternation,
    lambda: Option<f64>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Labeling> {
    let model = match labeler {
        Labeler::Estimated(model) | Labeler::Given(model, _) => *model,
        Labeler::Baseline(_) => ModelName::Constant,
    };
    let lambda = match lambda {
        Some(lambda) => lambda,
        None => default_lambda(mesh, observed, model, alternation, request, observe)?,
    };
    let request = &Request { lambda, ..request.clone() };
    match labeler {
        Labeler::Estimated(model) => {
            let alternation = &with_initial_labels(mesh, observed.data, alternation, request)?;
            model.with(observed, Estimation { mesh, alternation, request, observe })
        }
        Labeler::Given(model, mu) => {
            let seeds = &alternation.seeds;
            model.with(observed, Solve { mesh, mu, seeds, request, observe })
        }
        Labeler::Baseline(_) if !alternation.seeds.is_empty() => {
            Err(Error::unsuitable("a baseline cannot respect seeds; choose a model"))
        }
        Labeler::Baseline(baseline) => {
            let (solution, mu) =
                labeled(mesh, observed.data, baseline, alternation.regions, request, observe)?;
            Ok(Labeling::of::<PiecewiseConstant>(solution, &mu, 0))
        }
    }
}

/// With seeds, U starts from labels that agree with them.
fn with_initial_labels(
    mesh: &Mesh,
    data: &Data,
    alternation: &Alternation,
    request: &Request,
) -> Result<Alternation> {
    let mut alternation = alternation.clone();
    let Alternation { regions, seed, seeds, labels, .. } = &alternation;
    if !seeds.is_empty() && labels.is_none() {
        check_regions(*regions)?;
        check_rows("data", data.len(), mesh)?;
        seeds.check(data.len(), *regions)?;
        let weights = request.mass.weights(&model_mesh(mesh)?.0);
        alternation.labels = Some(initial_labels(data, seeds, &weights, *regions, *seed));
    }
    Ok(alternation)
}

impl Labeling {
    fn of<D: DataModel>(solution: Solution, mu: &[D::Parameters], estimates: usize) -> Self {
        let regions = mu.iter().map(RegionParameters::of::<D>).collect();
        Labeling { solution, regions, value_name: D::VALUE_NAME, estimates }
    }
}

struct Estimation<'a> {
    mesh: &'a Mesh,
    alternation: &'a Alternation,
    request: &'a Request,
    observe: Observer<'a>,
}

impl ModelTask for Estimation<'_> {
    type Output = Labeling;

    fn run<D: DataModel>(self, model: &D) -> Result<Labeling> {
        let Estimation { mesh, alternation, request, observe } = self;
        let Segmentation { mut solution, parameters, estimates } =
            segment(mesh, model, alternation, request, observe)?;
        let warning = seeds_only(&solution.labels, alternation);
        solution.summary.warnings.extend(warning);
        Ok(Labeling::of::<D>(solution, &parameters, estimates))
    }
}

/// A warning about regions that have no vertices besides their seeds.
fn seeds_only(labels: &Array1<i32>, alternation: &Alternation) -> Option<String> {
    let Alternation { seeds, regions: m, .. } = alternation;
    if seeds.count() == labels.len() {
        return None;
    }
    let mut others = vec![0_usize; *m];
    for (_, &p) in labels.iter().enumerate().filter(|&(k, _)| seeds.region(k).is_none()) {
        others[p as usize] += 1;
    }
    let seeded = seeds.seeded(*m);
    let alone: Vec<String> =
        (0..*m).filter(|&p| seeded[p] && others[p] == 0).map(|p| p.to_string()).collect();
    (!alone.is_empty()).then(|| {
        format!(
            "no vertices besides their seeds belong to: region {}; give them more seeds, or a smaller --lambda",
            alone.join(", ")
        )
    })
}

struct Solve<'a> {
    mesh: &'a Mesh,
    mu: &'a [serde_json::Value],
    seeds: &'a Seeds,
    request: &'a Request,
    observe: Observer<'a>,
}

impl ModelTask for Solve<'_> {
    type Output = Labeling;

    fn run<D: DataModel>(self, model: &D) -> Result<Labeling> {
        let Solve { mesh, mu, seeds, request, observe } = self;
        let read = |(p, mu): (usize, &serde_json::Value)| {
            serde_json::from_value(mu.clone()).map_err(|error| {
                Error::unsuitable(format!("the parameters of region {p}: {error}"))
            })
        };
        let mu: Vec<D::Parameters> = mu.iter().enumerate().map(read).collect::<Result<_>>()?;
        model.check(&mu)?;
        let s = pointwise_costs(model, &mu);
        let solution = solve_seeded(mesh, &s, seeds, &Start::Argmin, request, observe)?;
        Ok(Labeling::of::<D>(solution, &mu, 0))
    }
}

/// s, V x m; NaN where the data are unknown.
pub fn pointwise_costs<D: DataModel>(model: &D, mu: &[D::Parameters]) -> Array2<f64> {
    let cost = model.cost(mu);
    let mut s = Array2::from_elem((model.vertices(), mu.len()), f64::NAN);
    for (k, mut row) in s.outer_iter_mut().enumerate().filter(|&(k, _)| model.is_known(k)) {
        cost(k, row.as_slice_mut().expect("rows are contiguous"));
    }
    s
}

/// The index of each number of regions in a range, see [`count`].
///
/// # Errors
/// Those of [`count::of_data`], and models whose costs are log densities, which the index does not compare.
pub fn count_regions(
    mesh: &Mesh,
    observed: Observed<'_>,
    model: ModelName,
    numbers: RangeInclusive<usize>,
    mass: Mass,
    seed: u64,
) -> Result<Vec<Count>> {
    if !matches!(model, ModelName::Constant | ModelName::L1) {
        return Err(Error::unsuitable(format!(
            "the number of regions is chosen for the models constant and l1 only; with {} give a number",
            model.name()
        )));
    }
    model.with(observed, CountRegions { mesh, numbers, mass, seed })
}

struct CountRegions<'a> {
    mesh: &'a Mesh,
    numbers: RangeInclusive<usize>,
    mass: Mass,
    seed: u64,
}

impl ModelTask for CountRegions<'_> {
    type Output = Vec<Count>;

    fn run<D: DataModel>(self, model: &D) -> Result<Vec<Count>> {
        let CountRegions { mesh, numbers, mass, seed } = self;
        count::of_data(mesh, model, numbers, mass, seed)
    }
}

/// The lambda that suits the data, see [`lambda`].
///
/// # Errors
/// Those of [`lambda::of_data`], and data that the model cannot describe.
pub fn default_lambda(
    mesh: &Mesh,
    observed: Observed<'_>,
    model: ModelName,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    model.with(observed, DefaultLambda { mesh, alternation, request, observe })
}

struct DefaultLambda<'a> {
    mesh: &'a Mesh,
    alternation: &'a Alternation,
    request: &'a Request,
    observe: Observer<'a>,
}

impl ModelTask for DefaultLambda<'_> {
    type Output = f64;

    fn run<D: DataModel>(self, model: &D) -> Result<f64> {
        let DefaultLambda { mesh, alternation, request, observe } = self;
        lambda::of_data(mesh, model, alternation, request, observe)
    }
}
