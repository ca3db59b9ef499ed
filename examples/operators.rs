//! Gradients, masses, and a solver, step by step: `cargo run --release --no-default-features --example operators`.

use std::ops::ControlFlow;

use meshseg::field::{Row, Tangent};
use meshseg::mesh::source;
use meshseg::operator::mass::consistent_matrix;
use meshseg::operator::{Adjoint, Mass, Matrix, Operator, Stencil};
use meshseg::problem::Problem;
use meshseg::run::{Run, Sample, Status, Stop};
use meshseg::solver::{Method, Setup};

/// Regions.
const M: usize = 3;

fn main() -> meshseg::Result<()> {
    let mesh = source("torus:60x40")?;
    let (vertices, faces) = (mesh.vertices.len(), mesh.faces.len());

    // K, which is A_j times the gradient on face j, and its adjoint, row by row: the building blocks of the methods.
    let k = Stencil::new(&mesh);
    let kt = k.adjoint();
    let u: Vec<Row<M>> = (0..vertices)
        .map(|v| Row::from_fn(|p| (mesh.vertices[v].x * (p + 1) as f64).sin()))
        .collect();
    let q: Vec<Tangent<M>> = (0..faces)
        .map(|j| Tangent([0, 1].map(|i| Row::from_fn(|p| ((j + i + p) as f64).cos()))))
        .collect();
    let k_u: f64 = (0..faces).map(|j| k.at(&u, j).dot(q[j])).sum();
    let kt_q: f64 = (0..vertices).map(|v| u[v].dot(kt.at(&q, v))).sum();
    println!("<K u, q> = {k_u:.12}\n<u, K^T q> = {kt_q:.12}");
    assert!((k_u - kt_q).abs() <= 1e-12 * faces as f64);

    // K as a sparse matrix, 2F x V, and the mass matrices of the vertices.
    let matrix = Matrix::new(&mesh);
    println!("K: {:?} with {} entries", matrix.csr().shape(), matrix.csr().nnz());
    let consistent: f64 = consistent_matrix(&mesh).data().iter().sum();
    let lumped: f64 = Mass::Voronoi.weights(&mesh).iter().sum();
    println!("area {:.9}, of the masses {consistent:.9} and {lumped:.9}", mesh.area());
    assert!((consistent - mesh.area()).abs() <= 1e-12 * mesh.area());

    // A problem with costs per vertex, and the progress of a solver on it.
    let costs: Vec<Row<M>> = u.iter().map(|&u| -u).collect();
    let problem = Problem::new(k, Mass::Barycentric.on(&mesh).integrate(&costs), 0.05);
    let start = vec![Row([1.0 / M as f64; M]); vertices];
    let mut run = Run::new(&start);
    let setup = Setup { domain: (&mesh).into(), problem: &problem, start, dual_start: None };
    let mut solver = Method::default().build(setup)?;
    let mut history: Vec<Sample> = Vec::new();
    let stop = Stop { relative_gap: Some(1e-4), ..Stop::default() };
    let status = run.advance(&mut *solver, &problem, &stop, &mut |sample| {
        history.extend(sample);
        ControlFlow::Continue(())
    });
    for Sample { iteration, energy, dual_bound, relative_gap, .. } in &history {
        // Energies and bounds of a `Problem` are relative to the baseline, a lower bound on every energy.
        println!("{iteration:5} {energy:.9} {dual_bound:.9} {relative_gap:.1e}");
    }
    assert_eq!(status, Status::Converged);
    assert!(history.windows(2).all(|pair| pair[1].gap <= pair[0].gap));
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
