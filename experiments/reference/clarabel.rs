//! The exact optimum of small problems by an interior-point method, as an external solver:
//! `cargo run --release --example clarabel -- PROBLEM.npz OUT`.
//!
//! ```text
//! min sum_k <u_k, f_k> + sum_j t_j      u_k in the simplex,   |lambda (K U)_j| <= t_j
//! ```
//!
//! A second-order cone program, with the rows of K as in PROBLEM.npz. It writes only the last iterate, with
//! q_j = -lambda z_j from the dual variable of the cone. The clock starts before the factorization.
//! P. J. Goulart, Y. Chen, *Clarabel: An interior-point solver for conic programs with quadratic objectives*, 2024.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT, ZeroConeT,
};
use meshseg::exchange::Exchanged;
use meshseg::names::Named;
use meshseg::npy;
use meshseg::operator::Matrix;
use meshseg::relaxation::Relaxation;
use ndarray::Array2;

/// With the default tolerances, the result is off by 1e-7 of the optimum.
const TOLERANCE: f64 = 1e-11;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [problem, out, ..] = &arguments[..] else {
        return Err("usage: clarabel PROBLEM.npz OUT [--time-limit=SECONDS]".into());
    };
    let seconds = arguments.iter().find_map(|word| word.strip_prefix("--time-limit="));
    let time_limit = seconds.map(str::parse).transpose()?.unwrap_or(f64::INFINITY);
    solve(&Exchanged::read(Path::new(problem))?, Path::new(out), time_limit)
}

fn solve(problem: &Exchanged, out: &Path, time_limit: f64) -> Result<(), Box<dyn Error>> {
    let Exchanged { mesh, f, lambda, relaxation, .. } = problem;
    if *relaxation != Relaxation::Frobenius {
        let name = relaxation.name();
        return Err(format!("the relaxation is {name}; this program solves frobenius only").into());
    }
    let (k, (n, m), faces) = (Matrix::new(mesh), f.dim(), mesh.faces.len());
    // Some tolerances are absolute, so energies are in units of their upper bound.
    let cost = f.iter().fold(f64::MIN_POSITIVE, |max, f| f64::max(max, f.abs())) * n as f64;
    let weight = lambda / cost;
    let mut objective: Vec<f64> = f.iter().map(|f| f / cost).collect();
    objective.resize(n * m + faces, 1.0);

    // A x + s = b with s in the cones: rows sum to 1; u >= 0; (t_j, lambda (K U)_j) in second-order cones.
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let mut entry = |row: usize, column: usize, value: f64| {
        rows.push(row);
        columns.push(column);
        values.push(value);
    };
    for v in 0..n {
        for p in 0..m {
            entry(v, v * m + p, 1.0);
            entry(n + v * m + p, v * m + p, -1.0);
        }
    }
    let first = n + n * m;
    for j in 0..faces {
        entry(first + j * (1 + 2 * m), n * m + j, -1.0);
    }
    for (&value, (row, v)) in k.csr() {
        let (j, axis) = (row / 2, row % 2);
        for p in 0..m {
            entry(first + j * (1 + 2 * m) + 1 + axis * m + p, v * m + p, -weight * value);
        }
    }
    let height = first + faces * (1 + 2 * m);
    let mut b = vec![0.0; height];
    b[..n].fill(1.0);
    let mut cones: Vec<SupportedConeT<f64>> = vec![ZeroConeT(n), NonnegativeConeT(n * m)];
    cones.extend((0..faces).map(|_| SecondOrderConeT(1 + 2 * m)));
    let unknowns = objective.len();
    let a = CscMatrix::new_from_triplets(height, unknowns, rows, columns, values);
    let settings = DefaultSettingsBuilder::default()
        .tol_gap_abs(TOLERANCE)
        .tol_gap_rel(TOLERANCE)
        .tol_feas(TOLERANCE)
        .time_limit(time_limit)
        .verbose(false)
        .build()?;
    let begin = Instant::now();
    let quadratic = CscMatrix::zeros((unknowns, unknowns));
    let mut solver = DefaultSolver::new(&quadratic, &objective, &a, &b, &cones, settings)?;
    solver.solve();
    let seconds = begin.elapsed().as_secs_f64();
    let solution = &solver.solution;
    if !matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
        return Err(
            format!("{:?} after {} iterations", solution.status, solution.iterations).into()
        );
    }

    let iteration = solution.iterations;
    let mut u = Array2::from_shape_vec((n, m), solution.x[..n * m].to_vec())?;
    for mut row in u.outer_iter_mut() {
        row.mapv_inplace(|x| x.max(0.0));
        let sum = row.sum();
        row /= sum;
    }
    let mut q = Array2::zeros((2 * faces, m));
    for (j, z) in solution.z[first..].chunks_exact(1 + 2 * m).enumerate() {
        for (i, z) in z[1..].iter().enumerate() {
            q[[2 * j + i / m, i % m]] = -lambda * z;
        }
    }
    npy::write(&out.join(format!("u_{iteration}.npy")), &u)?;
    npy::write(&out.join(format!("q_{iteration}.npy")), &q)?;
    fs::write(out.join("trace.csv"), format!("iteration,seconds\n{iteration},{seconds}\n"))?;
    Ok(())
}
