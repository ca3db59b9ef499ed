//! Properties of all solvers, one file per kind.

mod certificates;
mod corners;
mod methods;
mod sameness;

use std::ops::ControlFlow;

use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::Operator;
use crate::problem::Problem;
use crate::run::{Run, Status, Stop};
use crate::solver::{Engines, Method, Options, Setup, Solver};

/// The name of a method, and settings that differ from the defaults.
type Variant = (&'static str, &'static [&'static str]);

/// Variants with other settings that also converge to a minimizer.
const OTHER_SETTINGS: [Variant; 6] = [
    ("chambolle-pock", &["steps=diagonal"]),
    ("chambolle-pock", &["steps=plain"]),
    ("douglas-rachford", &["inner=cholesky"]),
    ("fista", &["mass-metric=barycentric", "continuation=100"]),
    ("fista", &["mass-metric=voronoi", "epsilon-mode=paper", "restart=never"]),
    ("projected-gradient", &["mass-metric=none", "epsilon-mode=paper"]),
];

/// Every method, in each variant that converges to a minimizer.
fn variants() -> impl Iterator<Item = Variant> {
    let methods = Method::all().into_iter().map(|method| method.name());
    let relaxed = methods.filter(|name| EXPANSIONS.iter().all(|(other, _)| name != other));
    relaxed.map(|name| (name, &[] as &[&str])).chain(OTHER_SETTINGS)
}

/// The variants without smoothing, which reach E* itself.
fn exact() -> impl Iterator<Item = Variant> {
    let is_exact = |name: &str| {
        let mut method = Method::named(name).unwrap();
        method.settings().iter().all(|setting| setting.key != "epsilon")
    };
    variants().filter(move |(name, _)| is_exact(name))
}

/// The variants of one method.
fn variants_of(name: &str) -> impl Iterator<Item = Variant> {
    variants().filter(move |variant| variant.0 == name)
}

/// A relaxation that does not converge to a minimizer.
const CONSISTENT: Variant = ("projected-gradient", &["mass-metric=consistent"]);

/// Methods without a relaxation, which end at labels.
const EXPANSIONS: [Variant; 3] = [
    ("alpha-expansion", &[]),
    ("alpha-expansion", &["weights=cotangent"]),
    ("alpha-expansion", &["weights=crofton"]),
];

/// Every variant, whether it converges to a minimizer or not.
fn all_variants() -> impl Iterator<Item = Variant> {
    variants().chain([CONSISTENT]).chain(EXPANSIONS)
}

fn solver<'a, K: Engines + 'a, const M: usize>(
    variant: (&str, &[&str]),
    mesh: &Mesh,
    problem: &Problem<K, M>,
    start: Vec<Row<M>>,
) -> Box<dyn Solver<K, M> + 'a> {
    solver_from(variant, mesh, problem, (start, None))
}

/// A solver that starts from U and, if the method has one, a dual field.
fn solver_from<'a, K: Engines + 'a, const M: usize>(
    (name, options): (&str, &[&str]),
    mesh: &Mesh,
    problem: &Problem<K, M>,
    (start, dual_start): (Vec<Row<M>>, Option<Vec<Tangent<M>>>),
) -> Box<dyn Solver<K, M> + 'a> {
    let method = Method::parse(name, &Options::parse(options).unwrap()).unwrap();
    method.build(Setup { domain: mesh.into(), problem, start, dual_start }).unwrap()
}

/// U with 1/m in the first m regions.
fn uniform<const M: usize>(n: usize, m: usize) -> Vec<Row<M>> {
    vec![Row::from_fn(|p| if p < m { 1.0 / m as f64 } else { 0.0 }); n]
}

/// The iterate after the given number of steps.
fn after<K: Operator, const M: usize>(
    solver: &mut dyn Solver<K, M>,
    problem: &Problem<K, M>,
    steps: u64,
) -> (Vec<Row<M>>, Vec<Tangent<M>>) {
    assert_eq!(solver.advance(problem, steps, &mut || true), steps);
    (solver.iterate().u.to_vec(), solver.iterate().q.to_vec())
}

/// A run until a relative gap or a number of iterations is reached.
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
