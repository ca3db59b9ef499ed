//! A default lambda for costs of classes, by validation; the same for labels of vertices and of faces.
//!
//! ```text
//! f = g + h            costs of four fifths of the known rows, drawn at random, and of the others
//! u_i                  labels of 5/4 g with lambda_i = 0.08 R_1 / sqrt(area) / 2^i
//! V_i = sum_k <u_ik, h_k>
//! ```
//!
//! R_1 is what the best single class costs above the cheapest labels. Labels that follow the noise of g cost more of h, whose
//! noise is another, and so do labels that miss what is there. Of the lambdas whose V_i is within two standard errors of the
//! smallest one, the largest is chosen; the standard error of a difference is that of its sum over the vertices. All is done on a coarse
//! mesh: the energy, and with it the best lambda, hardly depends on the resolution.
//!
//! Reference: T. Hastie, R. Tibshirani, J. Friedman, *The Elements of Statistical Learning*, 2nd edition, 2009, section 7.10.

use ndarray::Array2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::carry::to_vertices;
use crate::coarse::Hierarchy;
use crate::domain::Element;
use crate::error::Result;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::{Mass, Stencil};
use crate::problem::Problem;
use crate::regions::{self, with_regions};
use crate::request::{Observer, Request};
use crate::run::{Run, Status, Stop};
use crate::solve::{check_range, integrate, model_mesh};
use crate::solver::{Method, Setup};
use crate::start::cheapest_labels;
use crate::transfer::restrict;

/// Maximum number of vertices of the mesh on which lambdas are tried.
const MAX_TRIAL_VERTICES: usize = 4000;

/// Number of lambdas that are tried, each half of the previous one.
const TRIALS: i32 = 12;

/// Relative gap of a trial, and its maximum number of steps.
const TRIAL_GAP: f64 = 1e-3;
const MAX_TRIAL_STEPS: u64 = 400;

/// The share of the known rows that labels are fitted to.
const FITTED_SHARE: f64 = 0.8;

/// With fewer known rows, all are fitted and validated.
const MIN_DIVIDED: usize = 50;

/// lambda for pointwise costs at the vertices or faces of a mesh; a row of NaN is unknown. It is 0 where one class is the cheapest
/// everywhere.
///
/// # Errors
/// No face has an area, or the integrated costs leave the range of double precision.
pub fn of_costs(
    mesh: &Mesh,
    (s, of): (&Array2<f64>, Element),
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let known: Vec<usize> = (0..s.nrows()).filter(|&k| !s[[k, 0]].is_nan()).collect();
    let mut fitted = s.clone();
    if known.len() >= MIN_DIVIDED {
        let mut rng = Pcg64::seed_from_u64(0);
        for k in known {
            if rng.random::<f64>() >= FITTED_SHARE {
                fitted.row_mut(k).fill(f64::NAN);
            }
        }
    }
    let at_vertices = |s: &Array2<f64>| {
        let s = match of {
            Element::Vertices => s.clone(),
            Element::Faces => to_vertices(mesh, s),
        };
        s.mapv_into(|s| if s.is_nan() { 0.0 } else { s })
    };
    let (all, fitted) = (at_vertices(s), at_vertices(&fitted));
    let (model, _) = model_mesh(mesh)?;
    with_regions!(s.ncols(), of_costs_compiled(&model, [&all, &fitted], request, observe))
}

fn of_costs_compiled<const M: usize>(
    model: &Mesh,
    s: [&Array2<f64>; 2],
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let m = s[0].ncols();
    let mass = Mass::Barycentric.on(model);
    let mut f = s.map(|s| integrate(&mass, m, &regions::rows::<M>(s.view())));
    let hierarchy = Hierarchy::down_to(model, MAX_TRIAL_VERTICES);
    for level in &hierarchy.levels {
        f = f.map(|f| restrict(level, &f));
    }
    let mesh = hierarchy.levels.last().map_or(model, |level| &level.mesh);
    let [all, fitted] = f;
    let mut problem =
        Problem::new(Stencil::new(mesh), fitted, 0.0).in_relaxation(request.relaxation);
    check_range(&problem)?;
    let single = |p: usize| problem.data_term(&vec![Row::one_hot(p); problem.f.len()]);
    let best_single = (0..m).map(single).fold(f64::INFINITY, f64::min);
    if best_single <= 0.0 {
        return Ok(0.0);
    }
    // The costs that are not fitted, up to a constant at each vertex, which all labels share. With none, all are validated.
    let validated: Vec<Row<M>> = all
        .iter()
        .zip(&problem.f)
        .map(|(all, fitted)| {
            let left = Row::from_fn(|p| if p < m { all.0[p] - fitted.0[p] } else { 0.0 });
            left - Row::from_fn(|_| left.0[0])
        })
        .collect();
    let nothing_left = validated.iter().all(|f| f.max() <= 0.0 && f.min() >= 0.0);
    let validated = if nothing_left { problem.f.clone() } else { validated };
    // A share of the costs has the energy of that share of lambda.
    let share = if nothing_left { 1.0 } else { FITTED_SHARE };

    let initial = 0.08 * best_single / share / mesh.area().sqrt();
    let lambdas: Vec<f64> = (0..TRIALS).map(|i| initial * 0.5_f64.powi(i)).collect();
    let (mut start, mut dual_start) = (cheapest_labels(&problem.f), None);
    let mut tried: Vec<(f64, Vec<usize>)> = Vec::new();
    // From the smallest on, whose q is feasible for the next one.
    for &lambda in lambdas.iter().rev() {
        problem.lambda = share * lambda;
        let mut run = Run::new(&start);
        let setup = Setup { domain: mesh.into(), problem: &problem, start, dual_start };
        let mut solver = Method::default().build(setup)?;
        let stop = Stop {
            relative_gap: Some(TRIAL_GAP),
            iterations: Some(MAX_TRIAL_STEPS),
            ..request.stop.clone()
        };
        let status = run.advance(&mut *solver, &problem, &stop, &mut |_| observe(None));
        if status == Status::Interrupted {
            break;
        }
        tried.push((lambda, run.best_u().iter().map(|u| u.argmax()).collect()));
        let last = solver.iterate();
        (start, dual_start) = (last.u.to_vec(), Some(last.q.to_vec()));
    }
    Ok(largest_as_good_as_the_best(&tried, &validated).unwrap_or(initial / 8.0))
}

/// The largest lambda whose labels cost at most two standard errors more than the best ones.
fn largest_as_good_as_the_best<const M: usize>(
    tried: &[(f64, Vec<usize>)],
    validated: &[Row<M>],
) -> Option<f64> {
    let cost =
        |labels: &[usize]| -> f64 { labels.iter().zip(validated).map(|(&p, f)| f.0[p]).sum() };
    let (_, best) = tried.iter().min_by(|a, b| cost(&a.1).total_cmp(&cost(&b.1)))?;
    let as_good = |labels: &[usize]| {
        let (mut sum, mut squares) = (0.0, 0.0);
        for ((&p, &q), f) in labels.iter().zip(best).zip(validated) {
            let difference = f.0[p] - f.0[q];
            sum += difference;
            squares += difference * difference;
        }
        sum <= 2.0 * squares.sqrt()
    };
    let good = tried.iter().filter(|(_, labels)| as_good(labels)).map(|(lambda, _)| *lambda);
    good.reduce(f64::max)
}
