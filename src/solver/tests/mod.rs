//! What every solver must do, whatever its method, by kind of theorem.

mod certificates;
mod corners;
mod methods;
mod sameness;

use std::ops::{ControlFlow, Range};

use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::Operator;
use crate::problem::Problem;
use crate::run::{Run, Status, Stop};
use crate::solver::{Engines, Options, Setup, Solver, build};

/// Every method, in each variant that converges to a minimizer.
const VARIANTS: [(&str, &[&str]); 10] = [
    ("chambolle-pock", &[]),
    ("chambolle-pock", &["steps=diagonal"]),
    ("chambolle-pock", &["steps=plain"]),
    ("douglas-rachford", &[]),
    ("douglas-rachford", &["inner=cholesky"]),
    ("fista", &[]),
    ("fista", &["mass-metric=barycentric", "continuation=100"]),
    ("fista", &["mass-metric=voronoi", "epsilon-mode=paper", "restart=never"]),
    ("projected-gradient", &[]),
    ("projected-gradient", &["mass-metric=none", "epsilon-mode=paper"]),
];

/// Those of [`VARIANTS`] without smoothing, which reach E* itself.
const EXACT: Range<usize> = 0..5;
const FISTA: Range<usize> = 5..8;
const PROJECTED_GRADIENT: Range<usize> = 8..10;

/// The one that does not.
const CONSISTENT: (&str, &[&str]) = ("projected-gradient", &["mass-metric=consistent"]);

fn solver<'a, K: Engines + 'a, const M: usize>(
    variant: (&str, &[&str]),
    mesh: &Mesh,
    problem: &Problem<K, M>,
    start: Vec<Row<M>>,
) -> Box<dyn Solver<K, M> + 'a> {
    solver_from(variant, mesh, problem, (start, None))
}

/// Started from U and, where a method has one, a dual field.
fn solver_from<'a, K: Engines + 'a, const M: usize>(
    (name, options): (&str, &[&str]),
    mesh: &Mesh,
    problem: &Problem<K, M>,
    (start, dual_start): (Vec<Row<M>>, Option<Vec<Tangent<M>>>),
) -> Box<dyn Solver<K, M> + 'a> {
    let options = Options::parse(options).unwrap();
    build(name, Setup { mesh, problem, start, dual_start, options: &options }).unwrap()
}

/// 1/m in the first m regions.
fn uniform<const M: usize>(n: usize, m: usize) -> Vec<Row<M>> {
    vec![Row::from_fn(|p| if p < m { 1.0 / m as f64 } else { 0.0 }); n]
}

/// The iterate after so many steps.
fn after<K: Operator, const M: usize>(
    solver: &mut dyn Solver<K, M>,
    problem: &Problem<K, M>,
    steps: u64,
) -> (Vec<Row<M>>, Vec<Tangent<M>>) {
    assert_eq!(solver.advance(problem, steps, &mut || true), steps);
    (solver.iterate().u.to_vec(), solver.iterate().q.to_vec())
}

/// A run to a relative gap or a number of iterations.
fn run<K: Operator, const M: usize>(
    solver: &mut dyn Solver<K, M>,
    problem: &Problem<K, M>,
    gap: f64,
    iterations: u64,
) -> (Run<M>, Status) {
    let stop = Stop { relative_gap: Some(gap), iterations: Some(iterations), ..Stop::default() };
    let mut run = Run::new(solver.iterate().u);
    let status = run.advance(solver, problem, &stop, &mut |_| ControlFlow::Continue(()));
    (run, status)
}
