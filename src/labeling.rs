//! Labels of data by a method that is chosen by name: a data model, whose parameters are estimated or given, or a
//! baseline that ignores cuts.
//!
//! A baseline has the parameters of its own classes; the energy of its labels, and the bound below it, are those of the
//! piecewise constant model with these parameters.

mod baseline;

use ndarray::Array2;

use crate::data::{DataModel, ModelName, ModelTask, Observed, PiecewiseConstant};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::names::Named;
use crate::segment::{Alternation, Segmentation, lambda, segment};
use crate::solve::{Observer, Request, Solution, solve};
use crate::start::Start;

pub use baseline::{Baseline, labeled};

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
/// Those of [`segment`], [`solve`] and [`labeled`], data that the model cannot describe, and parameters that are not
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
            model.with(observed, Estimation { mesh, alternation, request, observe })
        }
        Labeler::Given(model, mu) => model.with(observed, Solve { mesh, mu, request, observe }),
        Labeler::Baseline(baseline) => {
            let (solution, mu) =
                labeled(mesh, observed.data, baseline, alternation.regions, request, observe)?;
            Ok(Labeling::of::<PiecewiseConstant>(solution, &mu, 0))
        }
    }
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
        let Segmentation { solution, parameters, estimates } =
            segment(mesh, model, alternation, request, observe)?;
        Ok(Labeling::of::<D>(solution, &parameters, estimates))
    }
}

struct Solve<'a> {
    mesh: &'a Mesh,
    mu: &'a [serde_json::Value],
    request: &'a Request,
    observe: Observer<'a>,
}

impl ModelTask for Solve<'_> {
    type Output = Labeling;

    fn run<D: DataModel>(self, model: &D) -> Result<Labeling> {
        let Solve { mesh, mu, request, observe } = self;
        let read = |(p, mu): (usize, &serde_json::Value)| {
            serde_json::from_value(mu.clone()).map_err(|error| {
                Error::unsuitable(format!("the parameters of region {p}: {error}"))
            })
        };
        let mu: Vec<D::Parameters> = mu.iter().enumerate().map(read).collect::<Result<_>>()?;
        model.check(&mu)?;
        let s = pointwise_costs(model, &mu);
        let solution = solve(mesh, &s, &Start::Argmin, request, observe)?;
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
