//! The energies and the certificate of any U, whoever computed it.

use ndarray::Array2;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::{Mass, Operator, Stencil};
use crate::problem::{Problem, Smoothing, SmoothingMode, relative_gap, rounded};
use crate::regions::{self, with_regions};
use crate::solve::{check_range, integrate, model_mesh};
use crate::sweep::sweep;

/// How far entries may leave the simplex and still count as rounding.
const FEASIBLE: f64 = 1e-9;

#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    pub vertices: usize,
    pub faces: usize,
    pub regions: usize,
    pub lambda: f64,
    pub mass: &'static str,
    pub area: f64,
    /// E(U) = data_term + lambda * total_variation.
    pub energy: f64,
    pub data_term: f64,
    pub total_variation: f64,
    /// E_eps(U), if an eps was given.
    pub smoothed_energy: Option<f64>,
    /// D(q), q_j = lambda (K U)_j / sqrt(|(K U)_j|^2 + eps_j^2): no labels have less energy.
    pub dual_bound: f64,
    /// None if U is infeasible: its energy is then no upper bound.
    pub gap: Option<f64>,
    pub relative_gap: Option<f64>,
    pub rounded_energy: f64,
    pub rounded_relative_gap: f64,
    /// The eps of the bound, and of E_eps if that was asked for.
    pub epsilon: f64,
    pub epsilon_mode: &'static str,
    /// Whether every row of U is in the simplex to 1e-9; if not, the gap is none.
    pub feasible: bool,
    pub largest_row_sum_error: f64,
    pub smallest_entry: f64,
    pub warnings: Vec<String>,
}

/// Scores U (V x m) for pointwise costs s (V x m). Without an eps the bound takes one from the mesh.
///
/// # Errors
/// Shapes that do not fit each other; a mesh without area; lambda negative or not finite.
pub fn evaluate(
    mesh: &Mesh,
    s: &Array2<f64>,
    u: &Array2<f64>,
    lambda: f64,
    mass: Mass,
    smoothing: Option<Smoothing>,
) -> Result<Evaluation> {
    regions::check(s.ncols())?;
    if u.dim() != s.dim() {
        return Err(Error::unsuitable(format!(
            "U has {} x {} entries, the costs {} x {}",
            u.nrows(),
            u.ncols(),
            s.nrows(),
            s.ncols()
        )));
    }
    crate::solve::check_lambda(lambda)?;
    crate::solve::check_rows("costs", s.nrows(), mesh)?;
    crate::solve::check_finite("costs", s)?;
    crate::solve::check_finite("entries of U", u)?;
    let (model, warnings) = model_mesh(mesh)?;
    let mut evaluation =
        with_regions!(s.ncols(), evaluate_compiled(&model, s, u, lambda, mass, smoothing))?;
    evaluation.faces = mesh.faces.len();
    evaluation.warnings = warnings;
    Ok(evaluation)
}

fn evaluate_compiled<const M: usize>(
    model: &Mesh,
    s: &Array2<f64>,
    u: &Array2<f64>,
    lambda: f64,
    mass: Mass,
    smoothing: Option<Smoothing>,
) -> Result<Evaluation> {
    let m = s.ncols();
    let f = integrate(&mass.on(model), m, &regions::rows::<M>(s.view()));
    let problem = Problem::new(Stencil::new(model), f, lambda);
    check_range(&problem)?;
    let u: Vec<Row<M>> = regions::rows(u.view());

    let (bounding, dual_bound) = bound(&problem, &u, smoothing);
    let data_term = problem.data_term(&u);
    let total_variation = problem.total_variation(&u);
    let energy = data_term + lambda * total_variation;
    let rounded_energy = problem.energy(&rounded(&u));
    let scale = problem.scale();
    let largest_row_sum_error =
        u.iter().map(|row| (row.0.iter().sum::<f64>() - 1.0).abs()).fold(0.0, f64::max);
    let smallest_entry =
        u.iter().flat_map(|row| &row.0[..m]).copied().fold(f64::INFINITY, f64::min);
    let feasible = largest_row_sum_error <= FEASIBLE && smallest_entry >= -FEASIBLE;
    Ok(Evaluation {
        vertices: model.vertices.len(),
        faces: model.faces.len(),
        regions: m,
        lambda,
        mass: mass.name(),
        area: model.area(),
        energy,
        data_term,
        total_variation,
        smoothed_energy: smoothing.map(|smoothing| problem.smoothed_energy(&u, smoothing)),
        dual_bound,
        gap: feasible.then_some(energy - dual_bound),
        relative_gap: feasible.then(|| relative_gap(energy, dual_bound, scale)),
        rounded_energy,
        rounded_relative_gap: relative_gap(rounded_energy, dual_bound, scale),
        epsilon: bounding.epsilon,
        epsilon_mode: bounding.mode.name(),
        feasible,
        largest_row_sum_error,
        smallest_entry,
        warnings: Vec::new(),
    })
}

/// Each eps gives a true bound; without one given, the best of a ladder from the default down.
const LADDER: [f64; 6] = [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10];

fn bound<const M: usize>(
    problem: &Problem<Stencil, M>,
    u: &[Row<M>],
    given: Option<Smoothing>,
) -> (Smoothing, f64) {
    let Problem { k, lambda, .. } = problem;
    let mut q = vec![Tangent::ZERO; k.faces()];
    let mut at = |smoothing: Smoothing| {
        sweep(&mut q[..], |j, q| *q = smoothing.dual(k.at(u, j), k.area(j), *lambda));
        (smoothing, problem.dual_bound(&q))
    };
    if let Some(smoothing) = given {
        return at(smoothing);
    }
    let default = Smoothing::default_for(k, SmoothingMode::Intrinsic);
    LADDER
        .map(|share| at(Smoothing { epsilon: share * default.epsilon, ..default }))
        .into_iter()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .expect("the ladder has steps")
}
