//! A default lambda for costs of classes, by validation.
//!
//! ```text
//! f = g + h            costs of four fifths of the known rows, drawn at random, and of the others
//! u_i                  labels of 5/4 g with lambda_i = 0.08 r sqrt(area) / 2^i
//! V_i = sum_k <u_ik, h_k>
//! ```
//!
//! r is what the best single class costs above the cheapest labels, per area. Labels that follow the noise of g cost
//! more of h, whose noise is another, and so do labels that miss what is there. Of the lambdas whose V_i is within a
//! standard error of the smallest one, the largest is chosen; the standard error of a difference is that of its sum
//! over the unknowns. All is done where the labels will be, on vertices or on faces, and at the resolution of the mesh,
//! since cells average noise: on the whole mesh if it is small, or else on patches around faces that are drawn at
//! random.
//!
//! Reference: T. Hastie, R. Tibshirani, J. Friedman, *The Elements of Statistical Learning*, 2nd edition, 2009, section
//! 7.10.

use ndarray::Array2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::carry::{to_faces, to_vertices};
use super::patches::{Patch, patches};
use crate::domain::{Domain, Element};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::dual::Dual;
use crate::operator::{Mass, Stencil};
use crate::problem::Problem;
use crate::regions::{self, with_regions};
use crate::request::{Observer, Request};
use crate::run::{Run, Status, Stop};
use crate::solve::{check_range, integrate};
use crate::solver::{Method, Setup};
use crate::start::cheapest_labels;

/// Number of lambdas that are tried, each half of the previous one.
const TRIALS: i32 = 12;

/// Relative gap of a trial, and its maximum number of steps.
const TRIAL_GAP: f64 = 2e-3;
const MAX_TRIAL_STEPS: u64 = 300;

/// The share of the known rows that labels are fitted to.
const FITTED_SHARE: f64 = 0.8;

/// With fewer known rows, all are fitted and validated.
const MIN_DIVIDED: usize = 50;

/// A lambda with labels that cost so many standard errors more than the best ones is too large, and so are all larger
/// ones.
const HOPELESS: f64 = 10.0;

/// lambda for labels on the vertices or faces of a mesh, and pointwise costs on either; a row of NaN is unknown. It is
/// 0 where one class is the cheapest everywhere, and `None` if the observer ends the search.
///
/// # Errors
/// No face has an area, or the integrated costs leave the range of double precision.
pub fn of_costs(
    mesh: &Mesh,
    (s, of): (&Array2<f64>, Element),
    on: Element,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<f64>> {
    let mut rng = Pcg64::seed_from_u64(0);
    let is_known = |k: usize| !s[[k, 0]].is_nan();
    let known = (0..s.nrows()).filter(|&k| is_known(k)).count();
    let fitted_share = if known < MIN_DIVIDED { 1.0 } else { FITTED_SHARE };
    let is_fitted: Vec<bool> = (0..s.nrows()).map(|_| rng.random::<f64>() < fitted_share).collect();
    let known_face = |j: usize| match of {
        Element::Faces => is_known(j),
        Element::Vertices => mesh.faces[j].iter().any(|&v| is_known(v as usize)),
    };
    let mut parts = Vec::new();
    for Patch { mesh, vertices, faces } in patches(mesh, &known_face, &mut rng) {
        let rows = if of == Element::Faces { &faces } else { &vertices };
        let all = s.select(ndarray::Axis(0), rows);
        let mut fitted = all.clone();
        for (mut row, &k) in fitted.outer_iter_mut().zip(rows) {
            if !is_fitted[k] {
                row.fill(f64::NAN);
            }
        }
        let carried = |s: &Array2<f64>| {
            let s = match (of, on) {
                (Element::Faces, Element::Vertices) => to_vertices(&mesh, s),
                (Element::Vertices, Element::Faces) => to_faces(&mesh, s),
                _ => s.clone(),
            };
            s.mapv_into(|s| if s.is_nan() { 0.0 } else { s })
        };
        let [all, fitted] = [carried(&all), carried(&fitted)];
        parts.push(Part { mesh, all, fitted });
    }
    with_regions!(s.ncols(), search(mesh.area(), parts, (on, fitted_share), request, observe))
}

/// A patch with its costs on vertices or on faces: all, and those that are fitted.
struct Part {
    mesh: Mesh,
    all: Array2<f64>,
    fitted: Array2<f64>,
}

/// The problem on a patch, and the costs that are not fitted.
struct Trial<'a, const M: usize> {
    domain: Domain<'a>,
    problem: Problem<Stencil, M>,
    validated: Vec<Row<M>>,
    u: Vec<Row<M>>,
    q: Option<Vec<Tangent<M>>>,
}

fn search<const M: usize>(
    area: f64,
    parts: Vec<Part>,
    (on, fitted_share): (Element, f64),
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<f64>> {
    let m = parts.first().map_or(M, |part| part.all.ncols());
    let duals: Vec<Dual> = match on {
        Element::Vertices => Vec::new(),
        Element::Faces => parts.iter().map(|part| Dual::new(&part.mesh)).collect(),
    };
    let mut trials = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let domain = duals.get(i).map_or(Domain::Vertices(&part.mesh), Domain::Faces);
        trials.push(Trial::<M>::new(domain, part, m, request)?);
    }
    let single = |p: usize| -> f64 {
        let cost = |trial: &Trial<'_, M>| {
            trial.problem.data_term(&vec![Row::one_hot(p); trial.problem.f.len()])
        };
        trials.iter().map(cost).sum()
    };
    let best_single = (0..m).map(single).fold(f64::INFINITY, f64::min);
    if best_single <= 0.0 {
        return Ok(Some(0.0));
    }
    let tried_area: f64 = trials.iter().map(|trial| trial.domain.area()).sum();
    let initial = 0.08 * best_single / fitted_share / tried_area * area.sqrt();
    let validated: Vec<Row<M>> =
        trials.iter().flat_map(|trial| trial.validated.iter().copied()).collect();
    let mut tried: Vec<(f64, Vec<usize>)> = Vec::new();
    // From the smallest on, whose q is feasible for the next one.
    for i in (0..TRIALS).rev() {
        let lambda = initial * 0.5_f64.powi(i);
        let mut labels = Vec::with_capacity(validated.len());
        for trial in &mut trials {
            // A share of the costs has the labels of that share of lambda.
            if !trial.solve(fitted_share * lambda, request, observe, &mut labels)? {
                return Ok(None);
            }
        }
        tried.push((lambda, labels));
        let [sum, error] =
            excess(&tried[best(&tried, &validated)].1, &tried[tried.len() - 1].1, &validated);
        if sum > HOPELESS * error {
            break;
        }
    }
    let best = &tried[best(&tried, &validated)].1;
    let is_good = |(_, labels): &&(f64, Vec<usize>)| {
        let [sum, error] = excess(best, labels, &validated);
        sum <= error
    };
    Ok(tried.iter().filter(is_good).map(|(lambda, _)| *lambda).reduce(f64::max))
}

impl<'a, const M: usize> Trial<'a, M> {
    fn new(domain: Domain<'a>, part: &Part, m: usize, request: &Request) -> Result<Self> {
        let mass = domain.quadrature(Mass::Barycentric);
        let integrated = |s: &Array2<f64>| integrate(&mass, m, &regions::rows::<M>(s.view()));
        let (all, fitted) = (integrated(&part.all), integrated(&part.fitted));
        // Up to a constant for each unknown, which all labels share.
        let left = |(all, fitted): (&Row<M>, &Row<M>)| {
            let left = Row::from_fn(|p| if p < m { all.0[p] - fitted.0[p] } else { 0.0 });
            left - Row::from_fn(|p| if p < m { left.0[0] } else { 0.0 })
        };
        let mut validated: Vec<Row<M>> = all.iter().zip(&fitted).map(left).collect();
        let problem = Problem::new(domain.stencil(), fitted, 0.0).in_relaxation(request.relaxation);
        check_range(&problem)?;
        if part.all == part.fitted {
            validated.clone_from(&problem.f);
        }
        let u = cheapest_labels(&problem.f);
        Ok(Trial { domain, problem, validated, u, q: None })
    }

    /// Appends the labels for a lambda; whether the observer lets the search go on.
    fn solve(
        &mut self,
        lambda: f64,
        request: &Request,
        observe: Observer<'_>,
        labels: &mut Vec<usize>,
    ) -> Result<bool> {
        self.problem.lambda = lambda;
        let start = std::mem::take(&mut self.u);
        let mut run = Run::new(&start);
        let (domain, problem) = (self.domain, &self.problem);
        let setup = Setup { domain, problem, start, dual_start: self.q.take() };
        let mut solver = Method::default().build(setup)?;
        let stop = Stop {
            relative_gap: Some(TRIAL_GAP),
            iterations: Some(MAX_TRIAL_STEPS),
            ..request.stop.clone()
        };
        let status = run.advance(&mut *solver, problem, &stop, &mut |_| observe(None));
        labels.extend(run.best_u().iter().map(|u| u.argmax()));
        let last = solver.iterate();
        let (u, q) = (last.u.to_vec(), last.q.to_vec());
        (self.u, self.q) = (u, Some(q));
        Ok(status != Status::Interrupted)
    }
}

/// The index of the labels that cost least.
fn best<const M: usize>(tried: &[(f64, Vec<usize>)], validated: &[Row<M>]) -> usize {
    let cost = |(_, labels): &(f64, Vec<usize>)| -> f64 {
        labels.iter().zip(validated).map(|(&p, f)| f.0[p]).sum()
    };
    let costs: Vec<f64> = tried.iter().map(cost).collect();
    (1..costs.len()).fold(0, |best, i| if costs[i] < costs[best] { i } else { best })
}

/// What labels cost more than the best ones, and the standard error of this sum.
fn excess<const M: usize>(best: &[usize], labels: &[usize], validated: &[Row<M>]) -> [f64; 2] {
    let (mut sum, mut squares) = (0.0, 0.0);
    for ((&p, &q), f) in labels.iter().zip(best).zip(validated) {
        let difference = f.0[p] - f.0[q];
        sum += difference;
        squares += difference * difference;
    }
    [sum, squares.sqrt()]
}
