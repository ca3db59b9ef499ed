//! The fused engine against the reference implementation: on all kinds of meshes, for several numbers of regions and
//! threads, in both precisions and on all instruction sets.

use std::borrow::Cow;

use pulp::Arch;

use super::super::rows::Rows;
use super::super::stepping::Stepping;
use super::super::steps::{Rule, Steps};
use super::lanes::Real;
use super::pass::MAX_DEPTH;
use super::{Fused, Partition};
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::order::Order;
use crate::operator::{Operator, Stencil};
use crate::problem::Problem;
use crate::regions::pad_costs;
use crate::relaxation::Relaxation;
use crate::samples::{
    assert_within, bumpy, random_dual_in, random_labels, random_problem, rng, shape,
    with_isolated_vertices, zoo,
};
use crate::solver::balance::{Balance, Balancing};
use crate::solver::{OneByOne, Solver};
use crate::sweep::with_threads;

type State<const M: usize> = (Vec<Row<M>>, Vec<Tangent<M>>);

fn stepping<const M: usize>(problem: &Problem<Stencil, M>, start: &State<M>) -> Stepping<M> {
    Stepping {
        steps: Steps::new(problem, Rule::Local, 1.5),
        balance: Balance::new(Balancing::Adaptive, &start.0, Some(&start.1)),
        rho: 1.9,
    }
}

fn fused<T: Real, const M: usize>(
    problem: &Problem<Stencil, M>,
    start: &State<M>,
    arch: Arch,
) -> Fused<T, M> {
    let (u, q) = start.clone();
    let partition = Partition::new::<T, M>(&problem.k, arch);
    Fused::new(problem, u, Some(q), stepping(problem, start), partition)
}

fn rows<const M: usize>(problem: &Problem<Stencil, M>, start: &State<M>) -> OneByOne<Rows<M>, M> {
    let (u, q) = start.clone();
    OneByOne::new(Rows { u_bar: u.clone(), u, q, stepping: stepping(problem, start) })
}

fn after<const M: usize>(
    mut solver: impl Solver<Stencil, M>,
    problem: &Problem<Stencil, M>,
    steps: u64,
) -> State<M> {
    assert_eq!(solver.advance(problem, steps, &mut || true), steps);
    let now = solver.iterate();
    (now.u.to_vec(), now.q.to_vec())
}

fn start<const M: usize>(problem: &Problem<Stencil, M>, seed: u64) -> State<M> {
    let mut rng = rng(seed);
    let u = random_labels::<M>(problem.k.vertices(), M, &mut rng);
    let faces = problem.k.faces();
    (u, random_dual_in(problem.relaxation, faces, problem.lambda, &mut rng))
}

/// The largest difference of u, and of q in units of lambda.
fn difference<const M: usize>(a: &State<M>, b: &State<M>, lambda: f64) -> (f64, f64) {
    let u = a.0.iter().zip(&b.0).map(|(&a, &b)| (a - b).max_abs()).fold(0.0, f64::max);
    let q = a.1.iter().zip(&b.1).map(|(&a, &b)| (a - b).norm()).fold(0.0, f64::max);
    (u, q / lambda)
}

fn check_iterates<const M: usize>(name: &str, mesh: &Mesh) {
    check_iterates_in::<M>(Relaxation::Frobenius, name, mesh);
}

/// From a random pair, 50 steps give the iterate of `rows`, with 1, 2 and 3 threads.
fn check_iterates_in<const M: usize>(relaxation: Relaxation, name: &str, mesh: &Mesh) {
    let mesh = &*mesh.without_degenerate_faces().0;
    let problem =
        random_problem::<M>(mesh, 0.03 * mesh.area().sqrt(), 111).in_relaxation(relaxation);
    let start = start(&problem, 112);
    let expected = after(rows(&problem, &start), &problem, 50);
    let mut bits = Vec::new();
    for threads in [1, 2, 3] {
        let (double, single) = with_threads(Some(threads), || {
            let double = after(fused::<f64, M>(&problem, &start, Arch::new()), &problem, 50);
            (double, after(fused::<f32, M>(&problem, &start, Arch::new()), &problem, 50))
        })
        .unwrap();
        let (u, q) = difference(&double, &expected, problem.lambda);
        assert!(u <= 1e-9 && q <= 1e-8, "{name}, m = {M}, f64, {threads} threads: {u:e} {q:e}");
        let (u, q) = difference(&single, &expected, problem.lambda);
        assert!(u <= 1e-3 && q <= 1e-2, "{name}, m = {M}, f32, {threads} threads: {u:e} {q:e}");
        bits.push((double, single));
    }
    assert!(
        bits[0] == bits[1] && bits[0] == bits[2],
        "{name}, m = {M}: the number of threads matters"
    );
}

/// A mesh so narrow that a pass makes several iterations, even with three threads.
fn narrow() -> Mesh {
    let mesh = shape("torus:1200x16");
    let ordered = Order::of(&mesh).mesh(Cow::Borrowed(&mesh)).into_owned();
    let problem = random_problem::<3>(&ordered, 0.02, 120);
    let start = start(&problem, 121);
    for threads in [1, 3] {
        let parts =
            with_threads(Some(threads), || fused::<f64, 3>(&problem, &start, Arch::new()).parts);
        let depths: Vec<usize> = parts.unwrap().iter().map(|part| part.window.depth()).collect();
        assert_eq!(depths, vec![MAX_DEPTH; threads]);
    }
    ordered
}

#[test]
fn iterates_match_the_reference_implementation() {
    for (name, mesh) in zoo() {
        check_iterates::<3>(name, &mesh);
        check_iterates::<4>(name, &mesh);
    }
    // Large enough for three threads, with a seam between the first vertices and the last.
    for (name, mesh) in
        [("torus", shape("torus:90x90")), ("bumpy", bumpy(90)), ("narrow", narrow())]
    {
        check_iterates::<3>(name, &mesh);
        check_iterates::<4>(name, &mesh);
    }
}

/// The same with a ball for each region.
#[test]
fn iterates_match_where_regions_are_separate() {
    for (name, mesh) in zoo() {
        check_iterates_in::<3>(Relaxation::Separate, name, &mesh);
    }
    for (name, mesh) in [("torus", shape("torus:90x90")), ("narrow", narrow())] {
        check_iterates_in::<4>(Relaxation::Separate, name, &mesh);
    }
    check_iterates_in::<16>(Relaxation::Separate, "bumpy", &with_isolated_vertices(bumpy(9)));
}

/// Each number of regions is compiled separately, which takes long: `tests/optimum.rs` compares all of them.
#[test]
fn iterates_match_with_many_regions() {
    let mesh = with_isolated_vertices(bumpy(9));
    check_iterates::<16>("bumpy", &mesh);
    check_iterates::<64>("bumpy", &mesh);
}

/// u as stored in the parts, not divided by its row sums as the sampled one is in single precision.
fn raw_u<T: Real, const M: usize>(fused: &Fused<T, M>) -> Vec<Row<M>> {
    let mut u = vec![Row::ZERO; fused.u.len()];
    for part in &fused.parts {
        part.read_u(&mut u[part.own()]);
    }
    u
}

fn check_bound_and_change<T: Real, const M: usize>(name: &str, mesh: &Mesh) {
    check_bound_and_change_in::<T, M>(Relaxation::Frobenius, name, mesh);
}

/// The bound and the change that the engine reports are those of its fields.
fn check_bound_and_change_in<T: Real, const M: usize>(
    relaxation: Relaxation,
    name: &str,
    mesh: &Mesh,
) {
    let mesh = &*mesh.without_degenerate_faces().0;
    let mut problem =
        random_problem::<M>(mesh, 0.03 * mesh.area().sqrt(), 118).in_relaxation(relaxation);
    pad_costs(M - 1, &mut problem.f);
    let mut start = start(&problem, 119);
    start.0.fill(Row::one_hot(0));
    let mut bits = Vec::new();
    for threads in [1, 2, 3] {
        with_threads(Some(threads), || {
            // The first makes six steps in as few passes as possible, the other one step per pass.
            let [mut fused, mut other] =
                [0, 1].map(|_| fused::<T, M>(&problem, &start, Arch::new()));
            let mut reported = Vec::new();
            for _ in 0..4 {
                fused.advance(&problem, 6, &mut || true);
                (0..5).for_each(|_| other.pass(1, false));
                let before = raw_u(&other);
                other.pass(1, true);
                let moves = raw_u(&fused).into_iter().zip(before).map(|(u, before)| u - before);
                let largest = moves.map(Row::max_abs).fold(0.0, f64::max);
                let solver: &mut dyn Solver<Stencil, M> = &mut fused;
                let (bound, change) = (solver.dual_bound(&problem), solver.change());
                let now = solver.iterate();
                assert!(now.u.iter().all(|u| u.0[M - 1] == 0.0), "{name}: a padding region");
                assert_within(bound, problem.dual_bound(now.q), 1e-12, problem.spread());
                // The difference is rounded once.
                let rounding = if T::DOUBLE { 0.0 } else { f64::from(f32::EPSILON) };
                assert_within(change, largest, rounding, largest);
                reported.push((bound.to_bits(), change.to_bits()));
            }
            bits.push(reported);
        })
        .unwrap();
    }
    assert!(
        bits[0] == bits[1] && bits[0] == bits[2],
        "{name}, m = {M}: the number of threads matters"
    );
}

#[test]
fn bound_and_change_match_the_fields() {
    for (name, mesh) in zoo() {
        check_bound_and_change::<f64, 3>(name, &mesh);
        check_bound_and_change::<f32, 3>(name, &mesh);
    }
    for (name, mesh) in
        [("torus", shape("torus:90x90")), ("bumpy", bumpy(90)), ("narrow", narrow())]
    {
        check_bound_and_change::<f64, 16>(name, &mesh);
        check_bound_and_change::<f32, 16>(name, &mesh);
        check_bound_and_change_in::<f64, 4>(Relaxation::Separate, name, &mesh);
        check_bound_and_change_in::<f32, 4>(Relaxation::Separate, name, &mesh);
    }
}

/// AVX-512 and AVX2, as far as this machine has them, agree bit for bit, and portable code up to rounding.
#[test]
fn instruction_sets_agree() {
    let mesh = bumpy(20);
    let problem = random_problem::<4>(&mesh, 0.02, 113);
    let start = start(&problem, 114);
    let results = |arch| {
        let double = after(fused::<f64, 4>(&problem, &start, arch), &problem, 30);
        let single = after(fused::<f32, 4>(&problem, &start, arch), &problem, 30);
        let bounds = [bound::<f64>(&problem, &start, arch), bound::<f32>(&problem, &start, arch)];
        (double, single, bounds)
    };
    let portable = results(Arch::Scalar);
    let fastest = results(Arch::new());
    let (u, q) = difference(&portable.0, &fastest.0, problem.lambda);
    assert!(u <= 1e-12 && q <= 1e-11, "f64: {u:e} {q:e}");
    let (u, q) = difference(&portable.1, &fastest.1, problem.lambda);
    assert!(u <= 1e-4 && q <= 1e-3, "f32: {u:e} {q:e}");
    #[cfg(target_arch = "x86_64")]
    if let Some(arch) = pulp::x86::V3::try_new() {
        assert!(results(Arch::V3(arch)) == fastest);
    }
}

/// The bound that the engine reports after some steps, which is that of its q.
fn bound<T: Real>(problem: &Problem<Stencil, 4>, start: &State<4>, arch: Arch) -> f64 {
    let mut solver: Box<dyn Solver<Stencil, 4>> = Box::new(fused::<T, 4>(problem, start, arch));
    solver.advance(problem, 6, &mut || true);
    let reported = solver.dual_bound(problem);
    assert_within(reported, problem.dual_bound(solver.iterate().q), 1e-12, problem.spread());
    reported
}

/// With NaN among the costs of any one region, the bound is NaN.
#[test]
fn nan_in_the_costs_makes_the_bound_nan() {
    let mesh = bumpy(20);
    for p in 0..4 {
        let mut problem = random_problem::<4>(&mesh, 0.02, 117);
        let start = start(&problem, 118);
        let reported = |problem: &Problem<Stencil, 4>, solver: &mut dyn Solver<Stencil, 4>| {
            solver.restart(problem);
            solver.dual_bound(problem)
        };
        let mut double = fused::<f64, 4>(&problem, &start, Arch::new());
        let mut single = fused::<f32, 4>(&problem, &start, Arch::new());
        assert!(
            reported(&problem, &mut double).is_finite()
                && reported(&problem, &mut single).is_finite()
        );
        problem.f[77].0[p] = f64::NAN;
        assert!(
            reported(&problem, &mut double).is_nan() && reported(&problem, &mut single).is_nan()
        );
    }
}

/// With balanced steps, costs that change twice, and padding regions.
#[test]
fn iterates_match_after_the_costs_change() {
    let mesh = shape("torus:40x30");
    let mut problem = random_problem::<16>(&mesh, 0.02, 115);
    pad_costs(9, &mut problem.f);
    let u = vec![Row::from_fn(|p| if p < 9 { 1.0 / 9.0 } else { 0.0 }); mesh.vertices.len()];
    let start = (u, vec![Tangent::ZERO; mesh.faces.len()]);
    let mut solvers: [Box<dyn Solver<Stencil, 16>>; 2] = [
        Box::new(rows(&problem, &start)),
        Box::new(fused::<f64, 16>(&problem, &start, Arch::new())),
    ];
    for round in 0..6 {
        let states = [0, 1].map(|i| {
            for _ in 0..3 {
                solvers[i].advance(&problem, 20, &mut || true);
            }
            let now = solvers[i].iterate();
            (now.u.to_vec(), now.q.to_vec())
        });
        let (u, q) = difference(&states[0], &states[1], problem.lambda);
        assert!(u <= 1e-8 && q <= 1e-7, "round {round}: {u:e} {q:e}");
        if round == 1 {
            problem.f.iter_mut().for_each(|f| f.0[..9].iter_mut().for_each(|f| *f *= 0.01));
            solvers.iter_mut().for_each(|solver| solver.follow(&problem));
        }
        if round == 3 {
            problem.f.iter_mut().for_each(|f| f.0[..9].reverse());
            solvers.iter_mut().for_each(|solver| solver.restart(&problem));
        }
    }
}

/// Scaling brings numbers into the range of single precision that would not fit otherwise.
#[test]
fn single_precision_works_at_any_scale() {
    for scale in [1e-12, 1.0, 1e12] {
        let mesh = bumpy(12).scaled(scale);
        let problem = random_problem::<4>(&mesh, 0.02 * mesh.area().sqrt(), 116);
        let start = start(&problem, 117);
        let expected = after(rows(&problem, &start), &problem, 50);
        let single = after(fused::<f32, 4>(&problem, &start, Arch::new()), &problem, 50);
        let (u, q) = difference(&single, &expected, problem.lambda);
        assert!(u <= 1e-3 && q <= 1e-2, "scale {scale:e}: {u:e} {q:e}");
        assert!(single.0.iter().all(|u| (u.0.iter().sum::<f64>() - 1.0).abs() <= 1e-14));
        assert!(single.1.iter().all(|q| q.norm() <= problem.lambda * (1.0 + 1e-15)));
    }
}
