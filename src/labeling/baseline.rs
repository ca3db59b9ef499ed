//! Labels of the data alone, with which segmentations are compared.
//!
//! ```text
//! k-means      argmin_p |C(x) - c_p|, with the area-weighted centers c_p of Lloyd's iteration
//! thresholds   the number of thresholds at or below C(x), for scalar data
//! ```

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use crate::counted::counted;
use crate::data::constant::Mean;
use crate::data::kmeans::kmeans;
use crate::data::thresholds::{class_of, least_variance_thresholds};
use crate::data::{Data, DataModel, PiecewiseConstant};
use crate::empty_regions;
use crate::error::{Error, Result};
use crate::evaluate::{Question, evaluate};
use crate::mesh::Mesh;
use crate::names::Named;
use crate::problem::{label_gap, relative_gap};
use crate::rounding::Rounding;
use crate::run::{Sample, Status};
use crate::solve::{Observer, Request, RoundingRecord, Solution, Summary, model_mesh, solve};
use crate::start::Start;
use ndarray::Array2;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// A method that labels each vertex by its datum alone.
#[derive(Clone, Debug, PartialEq)]
pub enum Baseline {
    /// The nearest center of k-means.
    KMeans {
        /// The seed of `Pcg64`, which draws the first centers.
        seed: u64,
    },
    /// The thresholds of least variance within the classes (Otsu's).
    Otsu,
    /// Given thresholds, ascending.
    Thresholds(Vec<f64>),
}

impl Baseline {
    /// Its name, as that of a solver.
    pub fn name(&self) -> &'static str {
        match self {
            Baseline::KMeans { .. } => "kmeans",
            Baseline::Otsu | Baseline::Thresholds(_) => "threshold",
        }
    }

    /// The region of each vertex, 0 where the data are unknown, and the mean of each region.
    ///
    /// # Errors
    /// Thresholds of data that are not scalar, not ascending, or of another number than the regions need; fewer
    /// different values than regions; a class without data.
    fn classes(&self, data: &Data, area: &[f64], m: usize) -> Result<(Vec<usize>, Vec<Mean>)> {
        let known = data.known_area(area);
        let thresholds = match self {
            Baseline::KMeans { seed } => {
                let mut rng = Pcg64::seed_from_u64(*seed);
                let centers = kmeans(&data.values, data.dimension, &known, m, &mut rng);
                let mu: Vec<Mean> = centers.into_iter().map(|mean| Mean { mean }).collect();
                let model = PiecewiseConstant::new(data);
                let cost = model.cost(&mu);
                let mut s = vec![0.0; m];
                let nearest = |k: usize| {
                    if !data.is_known(k) {
                        return 0;
                    }
                    cost(k, &mut s);
                    (1..m).fold(0, |best, p| if s[p] < s[best] { p } else { best })
                };
                let labels = (0..data.len()).map(nearest).collect();
                drop(cost);
                return Ok((labels, mu));
            }
            _ if data.dimension > 1 => {
                return Err(Error::unsuitable(format!(
                    "thresholds need data with one number per vertex, but these have {}; use kmeans",
                    data.dimension
                )));
            }
            Baseline::Otsu => least_variance_thresholds(&data.values, &known, m),
            Baseline::Thresholds(given) => given.clone(),
        };
        if !thresholds.is_sorted_by(|a, b| a < b) {
            return Err(Error::unsuitable("the thresholds must be ascending numbers"));
        }
        if thresholds.len() + 1 != m {
            return Err(Error::unsuitable(match self {
                Baseline::Thresholds(_) => {
                    format!("{m} regions need {} thresholds, not {}", m - 1, thresholds.len())
                }
                _ if thresholds.is_empty() => {
                    "the data have one value only, so there is nothing to segment; choose other data".into()
                }
                _ => format!(
                    "the data have only {0} different values; use --regions {0}",
                    thresholds.len() + 1
                ),
            }));
        }
        let class = |&y: &f64| if y.is_nan() { 0 } else { class_of(y, &thresholds) };
        let labels: Vec<usize> = data.values.iter().map(class).collect();
        let mut sums = vec![[0.0; 2]; m];
        for (k, &p) in labels.iter().enumerate().filter(|&(k, _)| data.is_known(k)) {
            sums[p][0] += known[k];
            sums[p][1] += known[k] * data.values[k];
        }
        if let Some(p) = sums.iter().position(|[mass, _]| *mass == 0.0) {
            let message = format!("no data lie between the thresholds of region {p}");
            return Err(Error::unsuitable(message));
        }
        let mu = sums.iter().map(|[mass, sum]| Mean { mean: vec![sum / mass] }).collect();
        Ok((labels, mu))
    }
}

/// Labels of the data, scored for the means of their regions; the bound is that of a solve as requested.
///
/// # Errors
/// Those of [`solve`], and data that the baseline cannot label.
pub fn labeled(
    mesh: &Mesh,
    data: &Data,
    baseline: &Baseline,
    m: usize,
    request: &Request,
    observe: Observer<'_>,
) -> Result<(Solution, Vec<Mean>)> {
    let begin = Instant::now();
    let (labels, mu) = baseline.classes(data, &request.mass.weights(mesh), m)?;
    let seconds = begin.elapsed().as_secs_f64();
    let s = super::pointwise_costs(&PiecewiseConstant::new(data), &mu);
    let u = Array2::from_shape_fn(s.dim(), |(k, p)| f64::from(labels[k] == p));
    // The steps are those of the bound, not of the baseline.
    let mut quietly = |_: Option<&Sample>| observe(None);
    let Solution { summary: solved, .. } = solve(mesh, &s, &Start::Argmin, request, &mut quietly)?;
    let question = Question {
        lambda: request.lambda,
        relaxation: request.relaxation,
        mass: request.mass,
        smoothing: None,
        q: None,
        dual_steps: 0,
    };
    let scored = evaluate(mesh, &s, &u, question, &mut |_| ControlFlow::Continue(()))?;
    let (energy, dual_bound) = (scored.energy, solved.dual_bound);
    let above = |x: f64| x - solved.baseline;
    // The classes are not rounded; a bound for labelings is one for them as well.
    let rounding = solved.rounding.clone().map(|record| RoundingRecord {
        rounding: Rounding::Argmax.name().into(),
        argmax_energy: energy,
        rounding_seconds: Some(0.0),
        ..record
    });
    let label_bound = rounding.as_ref().map_or(dual_bound, |record| record.label_bound);
    let gap = energy - dual_bound;
    let relative_gap = relative_gap(above(energy), above(dual_bound));
    let status = match solved.status {
        status @ (Status::Interrupted | Status::Contradicted) => status,
        _ => Status::Ended,
    };
    let labels: ndarray::Array1<i32> = labels.into_iter().map(|p| p as i32).collect();
    let unknown = (0..data.len()).filter(|&k| !data.is_known(k)).count();
    let empty_regions = empty_regions::of_labels(&labels, m);
    let mut warnings = model_mesh(mesh)?.1;
    if !empty_regions.is_empty() {
        warnings.push(format!(
            "{}: the data have fewer clusters; use fewer regions",
            empty_regions::sentence(&empty_regions)
        ));
    }
    if let Status::IterationLimit | Status::TimeLimit = solved.status {
        warnings.push("the bound is not the best one: its solve was stopped at a limit".into());
    }
    if unknown > 0 {
        warnings.push(format!(
            "{} without data: {} looks at no neighbors and puts them into region 0",
            counted(unknown, "vertex is", "vertices are"),
            baseline.name()
        ));
    }
    let summary = Summary {
        solver: baseline.name().to_owned(),
        solver_options: BTreeMap::new(),
        status,
        status_sentence: match status {
            Status::Ended => {
                "ended: the baseline ignores cuts; the bound is that of its means".into()
            }
            status => status.sentence().into(),
        },
        iterations: 0,
        seconds,
        energy,
        dual_bound,
        gap,
        relative_gap,
        rounded_energy: energy,
        rounding,
        rounded_relative_gap: label_gap(above(energy), above(label_bound)),
        empty_regions,
        cut_threshold: None,
        coarse_to_fine: None,
        warnings,
        ..solved
    };
    let sample = Sample {
        iteration: 0,
        seconds,
        energy,
        dual_bound,
        gap,
        relative_gap,
        change: None,
        smoothed_energy: None,
        certificate: None,
    };
    Ok((Solution { summary, trace: vec![sample], u, labels, q: None }, mu))
}
